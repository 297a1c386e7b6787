#include "tests/bench/models.h"

#include <algorithm>

#include "core/io/codec.h"

namespace burnish::bench {

Model model_of(std::string name, testing::Shape shape) {
  Surface clean = expect(prepare_surface(shape.positions, shape.triangles, {}), name);
  return {std::move(name), std::move(shape), std::move(clean)};
}

Model load_model(const std::filesystem::path& obj) {
  const auto document = expect(decode(testing::read_file(obj), Format::Obj, {}, {}), obj.string());
  testing::Shape shape;
  shape.positions.assign(document->positions().begin(), document->positions().end());
  shape.triangles.assign(document->triangles().begin(), document->triangles().end());
  return model_of(obj.stem().string(), std::move(shape));
}

std::vector<std::filesystem::path> obj_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code failure;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failure)) {
    if (entry.path().extension() == ".obj") files.push_back(entry.path());
  }
  if (files.empty()) {
    std::fprintf(stderr, "%s: no OBJ files\n", folder.c_str());
    std::exit(2);
  }
  std::ranges::sort(files);
  return files;
}

Surface with_noise(const Model& model, const NoiseOptions& noise) {
  Surface moved = model.clean;
  if (!add_noise(moved, noise)) std::abort();
  std::vector<Vec3d> positions;
  for (const Index v : moved.weld) {
    positions.push_back(moved.mesh.frame.to_file(to_double(moved.mesh.positions[v])));
  }
  return expect(prepare_surface(positions, model.shape.triangles, {}), model.name);
}

ErrorMeasures errors_of(const Surface& surface, const Surface& clean, unsigned threads) {
  return expect(measure_errors(surface, surface.mesh.positions, clean, clean.mesh.positions, true,
                               {.threads = threads}),
                "measuring");
}

}  // namespace burnish::bench
