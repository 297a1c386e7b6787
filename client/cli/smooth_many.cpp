#include "client/cli/smooth_many.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cli/files.h"
#include "client/cli/smooth_run.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Row {
  FilePair pair;
  Result<v1::SmoothReport> report;
};

Result<v1::SmoothReport> smooth_one(const SmoothArguments& arguments, const FilePair& pair,
                                    const std::string& title, const Console& console) {
  if (auto writable = check_writable(pair.out); !writable) return writable.error();
  auto smoothed = smooth_file(arguments, pair.in, pair.out, title, console);
  if (!smoothed) return smoothed.error();
  if (auto written = write_file(pair.out, smoothed->mesh); !written) return written.error();
  return std::move(smoothed->report);
}

std::string text(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", value);
  return buffer.data();
}

std::vector<std::string> cells(const Row& row) {
  const std::string name = row.pair.in;
  if (!row.report) return {name, "", "", "", "", std::string(cause_code(row.report.error().cause))};
  const v1::SmoothReport& report = *row.report;
  return {name,
          std::to_string(report.input().triangles()),
          text(report.noise().sigma_over_edge()),
          text(report.errors().ev_over_edge()),
          text(report.timings().total_ms()),
          "ok"};
}

/// Names to the left, numbers to the right, words to the left.
void print_table(std::ostream& out, const std::vector<Row>& rows) {
  std::vector<std::vector<std::string>> lines = {{"file", "triangles", "noise/h", "Ev/h", "ms", "result"}};
  for (const Row& row : rows) lines.push_back(cells(row));
  std::vector<std::size_t> widths(lines.front().size());
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string gap(widths[i] - line[i].size(), ' ');
      const bool last = i + 1 == line.size();
      out << (i == 0 ? "" : "  ") << (i == 0 ? line[i] + gap : last ? line[i] : gap + line[i]);
    }
    out << "\n";
  }
}

Json json_of(const std::vector<Row>& rows, std::size_t failed) {
  Json files = Json::array();
  for (const Row& row : rows) {
    Json file = {{"in", row.pair.in}, {"out", row.pair.out}};
    if (row.report) {
      file["report"] = Json::parse(to_json(*row.report, true));
    } else {
      file["error"] = {{"code", cause_code(row.report.error().cause)},
                       {"message", row.report.error().message}};
    }
    files.push_back(std::move(file));
  }
  return {{"files", std::move(files)}, {"failed", failed}};
}

Result<> make_folder(const std::string& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (!failure) return {};
  return Error{Cause::FileError, "cannot make the folder '" + folder + "': " + failure.message()};
}

}  // namespace

Result<> smooth_many(const SmoothArguments& arguments, const std::vector<FilePair>& pairs,
                     const Console& console) {
  if (auto made = make_folder(arguments.output_folder); !made) return made;
  std::vector<Row> rows;
  std::size_t failed = 0;
  std::optional<Error> first;
  for (std::size_t i = 0; i < pairs.size() && !console.stop.stop_requested(); ++i) {
    const std::string title =
        "[" + std::to_string(i + 1) + "/" + std::to_string(pairs.size()) + "] " + pairs[i].in + " ";
    rows.push_back({pairs[i], smooth_one(arguments, pairs[i], title, console)});
    if (rows.back().report) continue;
    const Error& error = rows.back().report.error();
    if (!first) first = error;
    ++failed;
    print_error(console, error, pairs[i].in + ": ");
  }
  const std::string json = json_of(rows, failed).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  const bool only_json = arguments.json || arguments.report == "-";
  if (only_json) {
    console.out << json;
  } else {
    print_table(console.out, rows);
  }
  if (!arguments.report.empty() && arguments.report != "-") {
    if (auto written = write_file(arguments.report, json); !written) return written;
  }
  if (rows.size() < pairs.size()) {
    return Error{Cause::Cancelled, std::to_string(pairs.size() - rows.size()) + " of " +
                                       std::to_string(pairs.size()) + " files were not begun"};
  }
  if (!first) return {};
  return Error{first->cause,
               std::to_string(failed) + " of " + std::to_string(pairs.size()) + " files failed"};
}

}  // namespace burnish::cli
