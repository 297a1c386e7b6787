// The paper's experiment: Tables 1 and 2 beside its figures, as Markdown.
//   paper_tables [FOLDER=../shared/meshes/paper] [SEEDS=5]
// Every OBJ file of the folder gets Gaussian noise of a fifth of the mean edge length along its normals, once
// per seed, and is smoothed in 20 iterations on one thread. Figures are means over the seeds with their
// standard deviation. Exit code 1 when, at any seed, a model of the paper has its methods in another order,
// or the error of adaptive over that of laplacian or taubin is more than .05 or .12 from the paper's.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/smooth/registry.h"
#include "tests/bench/models.h"

namespace burnish::bench {
namespace {

constexpr std::int64_t kIterations = 20;

/// What a table of the paper says of a method: Ev, and milliseconds.
struct Printed {
  double ev, milliseconds;
};

/// The methods of the tables, and how far the ratio of adaptive's Ev to theirs may be from the paper's.
struct Column {
  const char* method;
  double tolerance;
};
constexpr Column kColumns[] = {
    {"laplacian", 0.05}, {"taubin", 0.12}, {"mean_curvature_flow", INFINITY}, {"adaptive", INFINITY}};

const std::map<std::string, std::map<std::string, Printed>> kPaper = {
    {"moai",
     {{"laplacian", {0.022616, 78}},
      {"taubin", {0.006112, 172}},
      {"mean_curvature_flow", {0.010658, 1060}},
      {"adaptive", {0.005699, 5601}}}},
    {"octa-flower",
     {{"laplacian", {0.135568, 62}},
      {"taubin", {0.035798, 125}},
      {"mean_curvature_flow", {0.041597, 1045}},
      {"adaptive", {0.030784, 3604}}}},
};

double ev_over_edge(const Model& model, const Surface& surface) {
  return errors_of(surface, model.clean, 0).ev_over_edge;
}

double cpu_milliseconds() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// What a method did, seed by seed.
struct Measured {
  std::vector<double> ev, milliseconds;
};

void measure(const Model& model, const Surface& noisy, const Method& method,
             const std::map<std::string, ParameterValue>& given, Measured& measured) {
  Surface surface = noisy;
  const auto values = expect(resolve_parameters(method, given), method.name);
  const double begin = cpu_milliseconds();
  expect(method.run(surface, values, {.threads = 1}), method.name);
  measured.milliseconds.push_back(cpu_milliseconds() - begin);
  measured.ev.push_back(ev_over_edge(model, surface));
}

std::string text(double value, int digits) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
  return buffer;
}

/// "0.278 ± 0.001"
std::string mean_and_spread(const std::vector<double>& values, int digits) {
  double mean = 0, squares = 0;
  const auto count = static_cast<double>(values.size());
  for (const double value : values) mean += value / count;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return text(mean, digits) + " ± " + text(count > 1 ? std::sqrt(squares / (count - 1)) : 0, digits);
}

std::vector<double> ratios(const Measured& ours, const Measured& other) {
  std::vector<double> result;
  for (std::size_t i = 0; i < ours.ev.size(); ++i) result.push_back(ours.ev[i] / other.ev[i]);
  return result;
}

class Experiment {
 public:
  Experiment(Model model, int seeds) : model_(std::move(model)) {
    std::vector<double> noisy_ev;
    for (int seed = 1; seed <= seeds; ++seed) {
      const Surface noisy = with_noise(model_, {.amplitude = 0.2, .seed = static_cast<std::uint64_t>(seed)});
      noisy_.ev.push_back(ev_over_edge(model_, noisy));
      for (const Method& method : methods()) {
        measure(model_, noisy, method, {{"iterations", kIterations}}, paper_[method.name]);
        measure(model_, noisy, method, {}, defaults_[method.name]);
      }
    }
    const auto printed = kPaper.find(model_.name);
    if (printed != kPaper.end()) printed_ = printed->second;
  }

  void print_table() const {
    std::printf("**%s**, %zu vertices, %zu triangles. Noisy: Ev/h %s\n\n", model_.name.c_str(),
                model_.clean.mesh.positions.size(), model_.clean.mesh.triangles.size(),
                mean_and_spread(noisy_.ev, 3).c_str());
    std::printf(
        "| method | Ev/h | Ev of `adaptive` over it | the paper's Ev | its ratio | ms | the paper's ms |\n");
    std::printf("|---|---|---|---|---|---|---|\n");
    const Measured& adaptive = paper_.at("adaptive");
    for (const Column& column : kColumns) {
      const Measured& measured = paper_.at(column.method);
      const bool known = !printed_.empty();
      std::printf("| `%s` | %s | %s | %s | %s | %s | %s |\n", column.method,
                  mean_and_spread(measured.ev, 3).c_str(),
                  mean_and_spread(ratios(adaptive, measured), 3).c_str(),
                  known ? text(printed_.at(column.method).ev, 6).c_str() : "",
                  known ? text(printed_ratio(column.method), 3).c_str() : "",
                  mean_and_spread(measured.milliseconds, 1).c_str(),
                  known ? text(printed_.at(column.method).milliseconds, 0).c_str() : "");
    }
    std::printf("\n");
  }

  void print_defaults(const Method& method) const {
    const Measured& measured = defaults_.at(method.name);
    std::printf(" %s | %s |", mean_and_spread(measured.ev, 3).c_str(),
                mean_and_spread(measured.milliseconds, 1).c_str());
  }

  const std::string& name() const { return model_.name; }

  /// Complains to stderr about every seed that does not show what the paper shows.
  bool agrees() const {
    bool fine = true;
    for (std::size_t i = 0; i < noisy_.ev.size() && !printed_.empty(); ++i) {
      const auto complain = [&](const std::string& what) {
        std::fprintf(stderr, "%s, seed %zu: %s\n", model_.name.c_str(), i + 1, what.c_str());
        fine = false;
      };
      for (const Column& a : kColumns) {
        const double ev = paper_.at(a.method).ev[i];
        for (const Column& b : kColumns) {
          if (printed_.at(a.method).ev < printed_.at(b.method).ev && !(ev < paper_.at(b.method).ev[i])) {
            complain(std::string(a.method) + " is not better than " + b.method);
          }
        }
        const double ratio = paper_.at("adaptive").ev[i] / ev, printed = printed_ratio(a.method);
        if (!(std::abs(ratio - printed) <= a.tolerance)) {
          complain("adaptive over " + std::string(a.method) + " is " + text(ratio, 3) + ", the paper's " +
                   text(printed, 3));
        }
      }
    }
    return fine;
  }

 private:
  double printed_ratio(const char* method) const {
    return printed_.at("adaptive").ev / printed_.at(method).ev;
  }

  Model model_;
  Measured noisy_;
  std::map<std::string, Measured> paper_;     // 20 iterations
  std::map<std::string, Measured> defaults_;  // with the iterations that the method itself proposes
  std::map<std::string, Printed> printed_;    // empty: not a model of the paper
};

std::vector<Experiment> experiments(const std::filesystem::path& folder, int seeds) {
  std::vector<Experiment> all;
  for (const auto& file : obj_files(folder)) all.emplace_back(load_model(file), seeds);
  return all;
}

void print_every_method(const std::vector<Experiment>& all) {
  std::printf("Every method with its defaults:\n\n| method | iterations |");
  for (const Experiment& e : all) std::printf(" %s, Ev/h | ms |", e.name().c_str());
  std::printf("\n|---|---|");
  for (std::size_t i = 0; i < all.size(); ++i) std::printf("---|---|");
  std::printf("\n");
  for (const Method& method : methods()) {
    const auto defaults = expect(resolve_parameters(method, {}), method.name);
    std::printf("| `%s` | %lld |", method.name.c_str(),
                static_cast<long long>(defaults.integer("iterations")));
    for (const Experiment& e : all) e.print_defaults(method);
    std::printf("\n");
  }
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  using namespace burnish;
  const std::filesystem::path folder = count > 1 ? arguments[1] : testing::real_mesh("paper");
  int seeds = 5;
  if (count > 2) {
    const std::string_view given = arguments[2];
    const auto [end, failure] = std::from_chars(given.data(), given.data() + given.size(), seeds);
    if (failure != std::errc() || end != given.data() + given.size() || seeds < 1 || count > 3) {
      std::fprintf(stderr, "usage: paper_tables [FOLDER=../shared/meshes/paper] [SEEDS=5]\n");
      return 2;
    }
  }
  const auto all = bench::experiments(folder, seeds);
  bool fine = true;
  for (const auto& e : all) {
    e.print_table();
    fine &= e.agrees();
  }
  bench::print_every_method(all);
  return fine ? 0 : 1;
}
