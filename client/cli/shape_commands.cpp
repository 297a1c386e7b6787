// `noise` and `sample`: meshes to try the rest on.
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cli/choices.h"
#include "client/cli/commands.h"
#include "client/cli/files.h"
#include "client/cli/mesh_files.h"
#include "core/io/codec.h"
#include "core/shape/noise.h"
#include "core/shape/sample.h"

namespace burnish::cli {
namespace {

struct NoiseArguments {
  std::string in, out;
  NoiseOptions noise;
  bool json = false;
};

struct SampleArguments {
  std::string out;
  unsigned resolution = kSampleResolution;
  NoiseOptions noise{.amplitude = 0.3};
  bool json = false;
};

/// What was written, for programs; where the mesh goes to standard output, this goes beside it.
void print_json(const Console& console, const std::string& file, const Encoded& encoded, std::size_t vertices,
                std::size_t triangles) {
  const nlohmann::ordered_json json = {
      {"file", file},
      {"format", format_name(encoded.format)},
      {"vertices", encoded.vertices.value_or(static_cast<std::uint32_t>(vertices))},
      {"triangles", encoded.triangles.value_or(static_cast<std::uint32_t>(triangles))},
      {"bytes", encoded.bytes.size()}};
  (file == "-" ? console.err : console.out)
      << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

/// A surface with noise, and where it was before.
struct NoisySurface {
  Surface surface;
  std::vector<Vec3f> before;

  MovedPositions moved(std::span<const Vec3d> original) const {
    return {original, surface.weld, before, surface.mesh.positions, surface.mesh.frame};
  }
};

Result<NoisySurface> noisy_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                   const NoiseOptions& noise, const RunControl& run) {
  Result<Surface> surface = prepare_surface(positions, triangles, run);
  if (!surface) return surface.error();
  NoisySurface noisy{std::move(*surface), {}};
  noisy.before = noisy.surface.mesh.positions;
  if (Result<> added = add_noise(noisy.surface, noise); !added) return added.error();
  return noisy;
}

Result<> make_noisy(const NoiseArguments& arguments, const Console& console) {
  const RunControl run{.stop = console.stop, .threads = 0};
  if (Result<> writable = check_output(arguments.out); !writable) return writable;
  Result<std::string> bytes = read_input(arguments.in, console);
  if (!bytes) return bytes.error();
  Result<std::unique_ptr<Document>> document = decode(*bytes, std::nullopt, no_limits(), run);
  if (!document) return document.error();
  const std::span<const Vec3d> positions = (*document)->positions();
  Result<NoisySurface> noisy = noisy_surface(positions, (*document)->triangles(), arguments.noise, run);
  if (!noisy) return noisy.error();
  Result<Encoded> file = encode(**document, noisy->moved(positions),
                                {.format = format_of_name(arguments.out), .draco = {}}, run);
  if (!file) return file.error();
  if (Result<> written = write_output(arguments.out, file->bytes, console); !written) return written;
  if (arguments.json)
    print_json(console, arguments.out, *file, positions.size(), (*document)->triangles().size());
  return {};
}

Result<> make_sample_file(const SampleArguments& arguments, const Console& console) {
  const RunControl run{.stop = console.stop, .threads = 0};
  if (Result<> writable = check_output(arguments.out); !writable) return writable;
  Result<Shape> shape = make_sample(arguments.resolution);
  if (!shape) return shape.error();
  Result<NoisySurface> noisy = noisy_surface(shape->positions, shape->triangles, arguments.noise, run);
  if (!noisy) return noisy.error();
  const MovedPositions moved = noisy->moved(shape->positions);
  const Format format = format_of_name(arguments.out).value_or(Format::Obj);
  Result<Encoded> file = encode_as(format, moved, shape->triangles, {}, {}, run);
  if (!file) return file.error();
  if (Result<> written = write_output(arguments.out, file->bytes, console); !written) return written;
  if (arguments.json)
    print_json(console, arguments.out, *file, shape->positions.size(), shape->triangles.size());
  return {};
}

void add_noise_size(CLI::App* command, NoiseOptions& noise) {
  command
      ->add_option(
          "--amplitude", noise.amplitude,
          "Size in mean edge lengths: the standard deviation of gaussian, the bound of uniform and impulsive")
      ->capture_default_str();
  command->add_option("--seed", noise.seed, "The same seed gives the same bytes")->capture_default_str();
}

}  // namespace

void add_noise_command(CLI::App& app, Command& chosen) {
  static const std::map<std::string, NoiseKind> kKinds = {{"gaussian", NoiseKind::Gaussian},
                                                          {"uniform", NoiseKind::Uniform},
                                                          {"impulsive", NoiseKind::Impulsive}};
  static const std::map<std::string, NoiseDirection> kDirections = {{"normal", NoiseDirection::Normal},
                                                                    {"random", NoiseDirection::Random}};
  auto arguments = std::make_shared<NoiseArguments>();
  NoiseOptions& noise = arguments->noise;
  CLI::App* command = app.add_subcommand("noise", "Add artificial scanner noise to a mesh");
  command->add_option("IN", arguments->in, "Mesh file: " + list_of_format_names() + "; - for standard input")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("OUT", arguments->out,
                   "File to write, in the format of its extension, else as IN; - for standard output")
      ->type_name("FILE")
      ->required();
  command->add_flag("--json", arguments->json, "Print what was written as JSON");
  add_noise_size(command, noise);
  command
      ->add_option("--kind", noise.kind,
                   "gaussian (default), uniform, or impulsive: uniform at some vertices")
      ->transform(choice_of(kKinds))
      ->type_name(names_of(kKinds));
  command
      ->add_option(
          "--direction", noise.direction,
          "normal (default): along the area-weighted vertex normal; random: each coordinate on its own")
      ->transform(choice_of(kDirections))
      ->type_name(names_of(kDirections));
  command->add_option("--fraction", noise.fraction, "Part of the vertices that impulsive noise hits")
      ->capture_default_str();
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return make_noisy(*arguments, console); };
  });
}

void add_sample_command(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<SampleArguments>();
  CLI::App* command = app.add_subcommand("sample",
                                         "Write a made-up scan: a cube with a dome, a bowl and pyramids, "
                                         "under gaussian noise along its normals");
  command
      ->add_option("OUT", arguments->out,
                   "File to write, in the format of its extension, else OBJ; - for standard output")
      ->type_name("FILE")
      ->required();
  command->add_flag("--json", arguments->json, "Print what was written as JSON");
  add_noise_size(command, arguments->noise);
  command->add_option("--resolution", arguments->resolution, "Cells per side, 4 to 1000; 12 N^2 triangles")
      ->capture_default_str();
  command->footer("With --amplitude 0 it is the noise-free reference, triangle for triangle.");
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return make_sample_file(*arguments, console); };
  });
}

}  // namespace burnish::cli
