#include "client/cli/report_table.h"

#include <array>
#include <cstdio>
#include <map>
#include <ostream>
#include <string>

#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

/// Short text of a value: four significant digits.
std::string text(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", value);
  return buffer.data();
}

std::string text(const google::protobuf::Value& value) {
  return value.kind_case() == google::protobuf::Value::kStringValue ? value.string_value()
                                                                    : text(value.number_value());
}

void row(std::ostream& out, const std::string& label, const std::string& value) {
  out << "  " << label << std::string(label.size() < 20 ? 20 - label.size() : 1, ' ') << value << "\n";
}

std::string counts(const v1::MeshSummary& mesh) {
  return std::to_string(mesh.vertices()) + " vertices, " + std::to_string(mesh.triangles()) + " triangles, " +
         std::to_string(mesh.boundary_edges()) + " boundary edges, " + std::to_string(mesh.components()) +
         (mesh.components() == 1 ? " component" : " components");
}

using Parameters = google::protobuf::Map<std::string, google::protobuf::Value>;

std::string list(const Parameters& parameters) {
  std::map<std::string, std::string> sorted;
  for (const auto& [name, value] : parameters) sorted[name] = text(value);
  std::string line;
  for (const auto& [name, value] : sorted) {
    line.append(line.empty() ? "" : ", ").append(name).append(" ").append(value);
  }
  return line;
}

std::string encoding(const v1::EncodingSummary& encoding) {
  if (encoding.format() != v1::MESH_FORMAT_DRACO)
    return std::string(format_name(from_proto(encoding.format()).value_or(Format::Obj)));
  const std::string method =
      encoding.draco_method() == v1::DRACO_METHOD_EDGEBREAKER ? "edgebreaker" : "sequential";
  const std::string bits =
      encoding.position_bits() == 0 ? "lossless" : std::to_string(encoding.position_bits()) + " bits";
  return "drc, " + method + ", positions " + bits + ", error up to " + text(encoding.quantisation_error());
}

void print_change(std::ostream& out, const v1::MeshChange& change) {
  out << "change from the input\n";
  row(out, "displacement",
      "rms " + text(change.rms_displacement()) + ", largest " + text(change.max_displacement()));
  row(out, "area", text(change.area_percent()) + " %");
  row(out, "volume", text(change.volume_percent()) + " %");
  row(out, "smallest angle",
      text(change.smallest_angle_degrees_before()) + " -> " + text(change.smallest_angle_degrees_after()) +
          " degrees");
}

void print_timings(std::ostream& out, const v1::StageTimings& timings) {
  out << "time in ms\n";
  row(out, "total", text(timings.total_ms()));
  row(out, "stages",
      "queue " + text(timings.queue_ms()) + ", decode " + text(timings.decode_ms()) + ", prepare " +
          text(timings.prepare_ms()) + ", smooth " + text(timings.smooth_ms()) + ", measure " +
          text(timings.measure_ms()) + ", encode " + text(timings.encode_ms()));
}

void print_errors(std::ostream& out, const v1::MeshErrors& errors) {
  out << "errors against the " << errors.against() << "\n";
  row(out, "Ev",
      text(errors.ev()) + " = " + text(errors.ev_over_edge()) +
          " mean edges = " + text(errors.ev_over_diagonal()) + " diagonals");
  row(out, "distance",
      "mean " + text(errors.mean_distance()) + ", rms " + text(errors.rms_distance()) + ", largest " +
          text(errors.max_distance()));
  if (!errors.has_mean_normal_degrees()) return;
  row(out, "normals",
      "mean " + text(errors.mean_normal_degrees()) + ", largest " + text(errors.max_normal_degrees()) +
          " degrees, flipped triangles " + std::to_string(errors.flipped_triangles()));
}

void print_warnings(std::ostream& out,
                    const google::protobuf::RepeatedPtrField<v1::ReportWarning>& warnings) {
  if (!warnings.empty()) out << "warnings\n";
  for (const v1::ReportWarning& warning : warnings) {
    row(out, warning.code(), warning.message() + " (" + std::to_string(warning.count()) + ")");
  }
}

std::string choice(const v1::MethodChoice& choice) {
  return choice.method() + ", " + list(choice.parameters()) + ": " + choice.reason();
}

std::string noise(const v1::NoiseEstimate& noise) {
  return noise.kind() + ", " + text(noise.sigma_over_edge()) + " mean edges";
}

/// Who did it: the version, and the request by which the server's log names it.
template <class Report>
std::string origin(const Report& report) {
  return " (burnish " + report.version() + ", request " + report.request_id() + ")\n";
}

}  // namespace

void print_comparison(std::ostream& out, const v1::CompareResponse& comparison) {
  out << "comparison" << origin(comparison);
  row(out, "reference", counts(comparison.reference()));
  row(out, "mesh", counts(comparison.mesh()));
  print_errors(out, comparison.errors());
  print_warnings(out, comparison.warnings());
}

void print_report(std::ostream& out, const v1::SmoothReport& report) {
  out << report.method() << origin(report);
  row(out, "parameters", list(report.parameters()));
  if (report.has_choice()) row(out, "chose", choice(report.choice()));
  row(out, "input", counts(report.input()));
  row(out, "output", counts(report.output()));
  if (report.has_noise()) row(out, "noise", noise(report.noise()));
  if (report.pinned_vertices() > 0)
    row(out, "pinned", std::to_string(report.pinned_vertices()) + " vertices");
  row(out, "written as", encoding(report.encoding()));
  print_errors(out, report.errors());
  print_change(out, report.change());
  print_timings(out, report.timings());
  print_warnings(out, report.warnings());
}

void print_forecast(std::ostream& out, const std::string& file, const v1::SmoothReport& report,
                    double seconds, std::uint64_t memory_bytes) {
  out << file << " (burnish " << report.version() << ", dry run: nothing is written)\n";
  row(out, "input", counts(report.input()));
  row(out, "noise", noise(report.noise()));
  row(out, "method", report.method());
  row(out, "parameters", list(report.parameters()));
  if (report.has_choice()) row(out, "would choose", choice(report.choice()));
  if (report.pinned_vertices() > 0)
    row(out, "pinned", std::to_string(report.pinned_vertices()) + " vertices");
  row(out, "smoothing takes", "about " + text(seconds) + " s on one core");
  row(out, "memory", "about " + text(static_cast<double>(memory_bytes) / (1 << 20)) + " MiB");
  print_warnings(out, report.warnings());
}

void print_heatmap(std::ostream& out, const std::string& file, double most, double largest) {
  out << "heat map\n";
  row(out, "file", file);
  row(out, "palest", "0");
  row(out, "darkest", text(most) + (largest > most ? " or more, up to " + text(largest) : ""));
}

}  // namespace burnish::cli
