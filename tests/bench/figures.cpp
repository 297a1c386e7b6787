// The paper's figures 6 to 9 as one contact sheet: a row for each model, and in it the original, the noisy
// mesh (Gaussian, a fifth of the mean edge length, along the normals), the paper's methods after its
// iterations, and `auto`; below each its Ev over h.
//   figures OUT.png [FOLDER]       FOLDER: OBJ files, such as ../shared/meshes/paper; default: four of our
//   own shapes
#include <cstdio>
#include <deque>
#include <fstream>

#include "client/render/sheet.h"
#include "core/smooth/registry.h"
#include "tests/bench/models.h"
#include "tests/support/procedural.h"

namespace burnish::bench {
namespace {

constexpr const char* kMethods[] = {"laplacian", "taubin", "mean_curvature_flow", "adaptive"};
constexpr std::int64_t kIterations = 20;

/// In place of the paper's Moai, Octa-flower, Bunny and Monk.
std::vector<Model> own_models() {
  std::vector<Model> models;
  for (const char* const name : {"blobs", "twisted_star", "knot", "relief"}) {
    models.push_back(model_of(name, testing::procedural_shape(name, 3, 20'000).shape));
  }
  return models;
}

std::vector<Model> models_of(const std::filesystem::path& folder) {
  std::vector<Model> models;
  for (const auto& file : obj_files(folder)) models.push_back(load_model(file));
  return models;
}

/// Panels and the meshes that they point to.
class ContactSheet {
 public:
  void add_row(const Model& model) {
    add(model.clean, model.name);
    const Surface noisy = with_noise(model, {.amplitude = 0.2});
    add(noisy, "noisy, " + error(noisy, model));
    for (const char* const name : kMethods)
      add(smoothed(noisy, name, {{"iterations", kIterations}}), model, name);
    add(smoothed(noisy, "auto", {}), model, "auto");
  }

  std::string png(unsigned columns) const {
    constexpr unsigned kSide = 176;
    const auto rows = static_cast<unsigned>(panels_.size()) / columns;
    const render::Sheet sheet{
        .width = columns * kSide, .height = rows * (kSide + 10), .columns = columns, .text_size = 12};
    return expect(render::to_png(expect(render::draw_sheet(panels_, sheet, {.threads = 0}), "drawing")),
                  "PNG");
  }

 private:
  static Surface smoothed(Surface surface, const char* name,
                          const std::map<std::string, ParameterValue>& given) {
    const Method& method = *expect(find_method(name), name);
    expect(method.run(surface, expect(resolve_parameters(method, given), name), {.threads = 0}), name);
    return surface;
  }

  static std::string error(const Surface& surface, const Model& model) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", errors_of(surface, model.clean, 0).ev_over_edge);
    return text;
  }

  void add(const Surface& surface, const Model& model, const std::string& name) {
    add(surface, name + ", " + error(surface, model));
  }

  void add(const Surface& surface, std::string label) {
    auto& positions = positions_.emplace_back();
    for (const Vec3f& p : surface.mesh.positions)
      positions.push_back(surface.mesh.frame.to_file(to_double(p)));
    const auto& triangles = triangles_.emplace_back(surface.mesh.triangles);
    panels_.push_back({.model = {.positions = positions, .triangles = triangles}, .label = std::move(label)});
  }

  std::deque<std::vector<Vec3d>> positions_;
  std::deque<std::vector<Triangle>> triangles_;
  std::vector<render::Panel> panels_;
};

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  using namespace burnish::bench;
  if (count < 2 || count > 3) {
    std::fprintf(stderr, "usage: figures OUT.png [FOLDER]\n");
    return 2;
  }
  ContactSheet sheet;
  for (const Model& model : count > 2 ? models_of(arguments[2]) : own_models()) sheet.add_row(model);
  const std::string png = sheet.png(static_cast<unsigned>(std::size(kMethods)) + 3);
  return std::ofstream(arguments[1], std::ios::binary) << png ? 0 : 2;
}
