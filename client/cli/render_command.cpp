#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <memory>
#include <ostream>

#include <nlohmann/json.hpp>

#include "client/cli/choices.h"
#include "client/cli/commands.h"
#include "client/cli/files.h"
#include "client/cli/heat.h"
#include "client/cli/mesh_files.h"
#include "client/render/color_map.h"
#include "client/render/sheet.h"

namespace burnish::cli {
namespace {

using render::Color;

struct RenderArguments {
  std::vector<std::string> files;  // meshes, then the picture
  std::string size, background = "#ffffff", color = "#d6cfc2", reference, unit;
  std::vector<std::string> labels;
  std::optional<double> heat_most;
  double heat_largest = 0;  // of all distances, once they are known
  render::View view;
  render::Sheet sheet;
  unsigned threads = 0;
  bool no_labels = false, flat = false, vertex_colors = false, json = false;
};

/// One mesh and what its panel points to. Not moved once the panel is made.
struct Subject {
  std::string bytes;
  LoadedMesh mesh;
  std::vector<double> distances;
  std::vector<float> heat;
  std::vector<render::Light> lights;
};

Result<std::unique_ptr<Subject>> load(const std::string& path, const Console& console,
                                      const RunControl& run) {
  auto subject = std::make_unique<Subject>();
  auto bytes = read_input(path, console);
  if (!bytes) return bytes.error();
  subject->bytes = std::move(*bytes);
  v1::StageTimings timings;
  auto mesh = load_mesh(subject->bytes, std::nullopt, path + ": ", no_limits(), run, timings);
  if (!mesh) return mesh.error();
  subject->mesh = std::move(*mesh);
  return subject;
}

Result<> take_vertex_colors(Subject& subject, const std::string& path, const RunControl& run) {
  const Surface& surface = subject.mesh.surface;
  const MovedPositions still{subject.mesh.document->positions(), surface.weld, surface.mesh.positions,
                             surface.mesh.positions, surface.mesh.frame};
  const auto shared = subject.mesh.document->shared_attributes(still, run);
  if (!shared) return shared.error();
  if (shared->colors.empty()) return Error{Cause::BadOption, path + " has no colours at its vertices"};
  subject.lights.resize(shared->colors.size() / 3);
  for (std::size_t v = 0; v < subject.lights.size(); ++v) {
    Color color{};
    for (std::size_t c = 0; c < 3; ++c) {
      color[c] =
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(shared->colors[3 * v + c], 0.0F, 1.0F)));
    }
    subject.lights[v] = render::to_light(color);
  }
  return {};
}

using Subjects = std::vector<std::unique_ptr<Subject>>;

/// Colours by the distance to the reference, all on one scale.
Result<> take_heat(RenderArguments& arguments, Subjects& subjects, const Console& console,
                   const RunControl& run) {
  const auto reference = load(arguments.reference, console, run);
  if (!reference) return reference.error();
  std::vector<double> all;
  for (auto& subject : subjects) {
    auto distances = file_vertex_distances(subject->mesh, (*reference)->mesh, run);
    if (!distances) return distances.error();
    subject->distances = std::move(*distances);
    all.insert(all.end(), subject->distances.begin(), subject->distances.end());
  }
  const double most = arguments.heat_most.value_or(end_of_heat(all));
  arguments.heat_largest = *std::max_element(all.begin(), all.end());
  for (auto& subject : subjects) {
    for (const double distance : subject->distances)
      subject->heat.push_back(static_cast<float>(distance / most));
  }
  arguments.sheet.legend =
      render::Legend{.most = most,
                     .open = arguments.heat_largest > most,
                     .title = "distance to the reference in " +
                              (arguments.unit.empty() ? "units of the file" : arguments.unit)};
  return {};
}

std::string stem(const std::string& path) { return std::filesystem::path(path).stem().string(); }

std::vector<render::Panel> panels_of(const RenderArguments& arguments, const Subjects& subjects) {
  std::vector<render::Panel> panels;
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    const Subject& subject = *subjects[i];
    const Document& document = *subject.mesh.document;
    std::string label = arguments.no_labels         ? ""
                        : !arguments.labels.empty() ? arguments.labels[i]
                        : subjects.size() > 1       ? stem(arguments.files[i])
                                                    : "";
    panels.push_back({.model = {document.positions(), document.triangles(), subject.lights, subject.heat},
                      .label = std::move(label),
                      .view = arguments.view});
  }
  return panels;
}

/// "1200x600"
Result<> set_size(const std::string& text, std::size_t meshes, render::Sheet& sheet) {
  if (text.empty()) {
    constexpr unsigned kPanel = 640, kWidest = 1600;
    const auto count = static_cast<unsigned>(std::min<std::size_t>(meshes, render::kMostSide));
    const unsigned columns = std::min(sheet.columns == 0 ? count : sheet.columns, count);
    sheet.width = std::min(kPanel * columns, kWidest);
    sheet.height = std::min(sheet.width / columns * ((count + columns - 1) / columns), render::kMostSide);
    return {};
  }
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, sheet.width);
  const bool crossed = width.ec == std::errc() && width.ptr != end && *width.ptr == 'x';
  const auto height = crossed ? std::from_chars(width.ptr + 1, end, sheet.height) : width;
  const auto fits = [](unsigned side) { return side >= render::kLeastSide && side <= render::kMostSide; };
  if (crossed && height.ec == std::errc() && height.ptr == end && fits(sheet.width) && fits(sheet.height))
    return {};
  return Error{Cause::BadOption, "--size takes WIDTHxHEIGHT in pixels, each " +
                                     std::to_string(render::kLeastSide) + " to " +
                                     std::to_string(render::kMostSide) + ", not '" + text + "'"};
}

Result<> check(RenderArguments& arguments) {
  const std::size_t meshes = arguments.files.size() - 1;
  if (auto set = set_size(arguments.size, meshes, arguments.sheet); !set) return set;
  const auto background = render::parse_color(arguments.background),
             paint = render::parse_color(arguments.color);
  if (!background) return background.error();
  if (!paint) return paint.error();
  render::Look& look = arguments.sheet.look;
  look.background = *background, look.paint = *paint;
  look.shading = arguments.flat ? render::Shading::Flat : render::Shading::Smooth;
  if (arguments.labels.empty() || arguments.labels.size() == meshes) return {};
  return Error{Cause::BadOption, "--label is given " + std::to_string(arguments.labels.size()) +
                                     " times for " + std::to_string(meshes) +
                                     (meshes == 1 ? " mesh" : " meshes")};
}

void print_json(std::ostream& out, const RenderArguments& arguments, const render::Picture& picture,
                std::size_t bytes) {
  nlohmann::ordered_json json = {{"file", arguments.files.back()},
                                 {"width", picture.width},
                                 {"height", picture.height},
                                 {"bytes", bytes}};
  if (arguments.sheet.legend)
    json.update({{"heatMost", arguments.sheet.legend->most}, {"heatLargest", arguments.heat_largest}});
  out << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

Result<> render_meshes(RenderArguments arguments, const Console& console) {
  if (auto fine = check(arguments); !fine) return fine;
  const std::string& out = arguments.files.back();
  if (auto writable = check_output(out); !writable) return writable;
  const RunControl run{.stop = console.stop, .threads = arguments.threads};
  Subjects subjects;
  for (std::size_t i = 0; i + 1 < arguments.files.size(); ++i) {
    auto subject = load(arguments.files[i], console, run);
    if (!subject) return subject.error();
    if (arguments.vertex_colors) {
      if (auto taken = take_vertex_colors(**subject, arguments.files[i], run); !taken) return taken;
    }
    subjects.push_back(std::move(*subject));
  }
  if (!arguments.reference.empty()) {
    if (auto taken = take_heat(arguments, subjects, console, run); !taken) return taken;
  }
  const auto picture = render::draw_sheet(panels_of(arguments, subjects), arguments.sheet, run);
  if (!picture) return picture.error();
  const auto png = render::to_png(*picture);
  if (!png) return png.error();
  if (auto written = write_output(out, *png, console); !written) return written;
  if (arguments.json) print_json(out == "-" ? console.err : console.out, arguments, *picture, png->size());
  return {};
}

void add_view(CLI::App* command, RenderArguments& arguments) {
  static const std::map<std::string, render::UpAxis> kUp = {{"y", render::UpAxis::Y},
                                                            {"z", render::UpAxis::Z}};
  static const std::map<std::string, render::Fit> kFits = {{"row", render::Fit::Row},
                                                           {"each", render::Fit::Each}};
  command
      ->add_option("--azimuth", arguments.view.azimuth,
                   "Degrees to the right of the front, which is +z, or -y when z is up")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  command->add_option("--elevation", arguments.view.elevation, "Degrees above the horizon")
      ->check(CLI::Range(-90.0, 90.0))
      ->capture_default_str();
  command->add_option("--up", arguments.view.up, "Axis that points up: y (default) or z")
      ->transform(choice_of(kUp))
      ->type_name(names_of(kUp));
  command->add_option("--zoom", arguments.view.zoom, "1: the whole mesh fits")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  command
      ->add_option("--fit", arguments.sheet.fit,
                   "row (default): meshes of a row are seen from one place; each: every mesh fills its panel")
      ->transform(choice_of(kFits))
      ->type_name(names_of(kFits));
}

void add_look(CLI::App* command, RenderArguments& arguments) {
  render::Look& look = arguments.sheet.look;
  command->add_option("--color", arguments.color, "Of the surface, #rrggbb")->capture_default_str();
  command->add_option("--background", arguments.background, "#rrggbb")->capture_default_str();
  command->add_flag("--flat", arguments.flat, "Show the triangles; default: shade across them");
  command->add_option("--samples", look.samples, "Rays per pixel, along each side")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  command
      ->add_option("--occlusion", look.occlusion,
                   "Rays per sample that see how much of the sky is hidden; 0: none")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
}

void add_heat(CLI::App* command, RenderArguments& arguments) {
  CLI::Option* reference = command->add_option("--reference", arguments.reference,
                                               "Colour by the distance to this mesh, with a legend");
  reference->type_name("FILE");
  command
      ->add_option("--heat-most", arguments.heat_most,
                   "Distance of the darkest colour; default: what 99% do not exceed, rounded up")
      ->check(CLI::Range(1e-30, 1e60))
      ->needs(reference);
  command->add_option("--unit", arguments.unit, "Unit of the files' coordinates, for the legend, such as mm")
      ->needs(reference);
  command
      ->add_flag("--vertex-colors", arguments.vertex_colors,
                 "Use the colours that the files give their vertices")
      ->excludes(reference);
}

}  // namespace

void add_render_command(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render", "Draw meshes side by side, without a display");
  command
      ->add_option("FILES", arguments->files,
                   "Mesh files, then the PNG file to write; - for standard input and output")
      ->type_name("FILE")
      ->required()
      ->expected(2, 1000);
  command->add_option("--size", arguments->size,
                      "WIDTHxHEIGHT of the picture in pixels; default: 640 for each mesh, 1600 wide at most");
  command->add_option("--columns", arguments->sheet.columns, "Meshes in a row; default: all")
      ->check(CLI::Range(1, 1000));
  command
      ->add_option("--label", arguments->labels,
                   "Words below a mesh, once for each; default: the files' names if there are several")
      ->allow_extra_args(false);
  command->add_flag("--no-labels", arguments->no_labels, "No words below the meshes");
  add_view(command, *arguments);
  add_look(command, *arguments);
  add_heat(command, *arguments);
  command->add_option("--threads", arguments->threads, "0 = all cores; any number gives the same bytes")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print what was written as JSON");
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return render_meshes(*arguments, console); };
  });
}

}  // namespace burnish::cli
