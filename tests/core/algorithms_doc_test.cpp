#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/smooth/registry.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

TEST(AlgorithmsDocument, HoldsTheRegistryWordForWord) {
  const std::string document = testing::read_file(BURNISH_DOCS "/algorithms.md");
  EXPECT_THAT(document, ::testing::HasSubstr(methods_markdown()))
      << "run: burnish methods --markdown, and put its output between the marks in docs/algorithms.md";
}

}  // namespace
}  // namespace burnish
