#include "server/jobs/spool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/client/temporary_folder.h"

namespace burnish {
namespace {

using ::testing::HasSubstr;

std::string text_of(std::size_t size) {
  std::string text(size, ' ');
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>('a' + i % 23);
  return text;
}

TEST(Spool, GivesBackWhatWasAppendedInMemoryAndFromItsFile) {
  for (const std::uint64_t in_memory : {0u, 1u, 999u, 1000u, 1001u, 5000u}) {
    Spool spool({.in_memory = in_memory});
    const std::string text = text_of(1000);
    for (const std::size_t chunk : {1u, 7u, 999u, 1000u}) {
      const auto body = spool.body();
      for (std::size_t at = 0; at < text.size(); at += chunk) {
        ASSERT_TRUE(body->append(std::string_view(text).substr(at, chunk)).ok());
      }
      EXPECT_EQ(body->size(), text.size());
      const auto view = body->finish();
      ASSERT_TRUE(view.ok());
      EXPECT_EQ(*view, text) << "in memory " << in_memory << ", chunks of " << chunk;
      EXPECT_EQ(body->finish().value(), text) << "safe to repeat";
    }
  }
}

TEST(Spool, AnEmptyBodyIsEmpty) {
  Spool spool({.in_memory = 0});
  const auto body = spool.body();
  ASSERT_TRUE(body->append("").ok());
  EXPECT_EQ(body->finish().value(), "");
}

TEST(Spool, CountsTheBytesOfBodiesThatLive) {
  Spool spool({.in_memory = 10});
  auto first = spool.body(), second = spool.body();
  ASSERT_TRUE(first->append(text_of(100)).ok());
  ASSERT_TRUE(second->append(text_of(5)).ok());
  EXPECT_EQ(spool.bytes(), 105u);
  first.reset();
  EXPECT_EQ(spool.bytes(), 5u);
  second.reset();
  EXPECT_EQ(spool.bytes(), 0u);
}

TEST(Spool, RefusesMoreThanItsLimitAndTakesAgainWhenThereIsRoom) {
  Spool spool({.in_memory = 10, .max_bytes = 100});
  auto first = spool.body();
  ASSERT_TRUE(first->append(text_of(60)).ok());
  const auto second = spool.body();
  const auto refused = second->append(text_of(41));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::MemoryFull);
  EXPECT_THAT(refused.error().message, HasSubstr("(max-spool-bytes)"));
  first.reset();
  EXPECT_TRUE(second->append(text_of(41)).ok());
  EXPECT_EQ(spool.bytes(), 41u);
}

TEST(Spool, LeavesNoFileInItsFolder) {
  const cli::TemporaryFolder folder;
  Spool spool({.folder = folder / "", .in_memory = 0});
  const auto body = spool.body();
  ASSERT_TRUE(body->append(text_of(100)).ok());
  EXPECT_EQ(folder.entries(), 0u) << "nothing is left even if the process dies now";
}

TEST(Spool, MakesItsFolder) {
  const cli::TemporaryFolder folder;
  Spool spool({.folder = folder / "some/spool", .in_memory = 0});
  ASSERT_TRUE(spool.check().ok());
  EXPECT_TRUE(spool.body()->append("x").ok());
}

TEST(Spool, SaysWhenItsFolderCannotBeWritten) {
  Spool spool({.folder = "/dev/null/spool", .in_memory = 0});
  const auto usable = spool.check();
  ASSERT_FALSE(usable.ok());
  EXPECT_EQ(usable.error().cause, Cause::BadOption);
  EXPECT_THAT(usable.error().message, HasSubstr("/dev/null/spool"));
  const auto body = spool.body();
  const auto kept = body->append("x");
  ASSERT_FALSE(kept.ok());
  EXPECT_EQ(kept.error().cause, Cause::StorageFull);
}

}  // namespace
}  // namespace burnish
