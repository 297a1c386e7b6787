// Models with a known truth and noise on them, as a file with the noise would give them.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/measure/error.h"
#include "core/shape/noise.h"
#include "tests/support/shapes.h"

namespace burnish::bench {

/// The value, or the end of the program: a benchmark has nobody to tell.
template <class T>
T expect(Result<T> result, const std::string& what) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "%s: %s\n", what.c_str(), result.error().message.c_str());
  std::exit(2);
}

struct Model {
  std::string name;
  testing::Shape shape;
  Surface clean;
};

Model model_of(std::string name, testing::Shape shape);
Model load_model(const std::filesystem::path& obj);  ///< named by the file
/// The OBJ files of a folder, by name. Ends the program when there are none.
std::vector<std::filesystem::path> obj_files(const std::filesystem::path& folder);

Surface with_noise(const Model& model, const NoiseOptions& noise);

/// Of a surface with the triangles of `clean`.
ErrorMeasures errors_of(const Surface& surface, const Surface& clean, unsigned threads);

}  // namespace burnish::bench
