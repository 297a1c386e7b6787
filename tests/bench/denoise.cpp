// How well every method removes noise, beside the best that someone who knows the original gets out of it.
// `l0` (l0.h), which is not one of the service's, takes part.
//   denoise FOLDER            pairs FOLDER/NAME/{Original,Noisy}.obj
//   denoise --procedural      our own shapes (tests/support/procedural.h) with seven kinds of noise
//   denoise --paper FOLDER    clean models FOLDER/*.obj with 10 to 50% noise: adaptive and auto, which must
//                             not be worse than the input, nor than adaptive by more than 2%
// Options: --out DIR (denoise.csv and denoise.svg; default: the working folder), --sweep (a grid of settings
// per method, denoise_sweep.cpp), --methods a,b, --seeds N (of noise and shape; 1, for --paper 3),
// --first-seed N (1; the networks saw procedural shapes of seeds 1 to 4), --threads N (1), --resolution N
// (triangles of procedural shapes, 10000).
//
// Ev is Eq. 9 of the paper: area-weighted root mean square distance of the result's vertices to the nearest
// point of the original's nearest triangle; h is the ORIGINAL's mean edge length, as in `burnish compare`.
// Normal errors are angles between corresponding triangles, their plain mean. Times are of the wall, for the
// method alone. Exit code 1 when --paper finds what must not be.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>

#include "tests/bench/denoise_report.h"
#include "tests/bench/denoise_sweep.h"
#include "tests/bench/l0.h"
#include "tests/bench/models.h"
#include "tests/support/procedural.h"

namespace burnish::bench {
namespace {

/// The registry's, and those that only this program has.
const std::vector<Method>& all_methods() {
  static const std::vector<Method> kMethods = [] {
    std::vector<Method> all(methods().begin(), methods().end());
    all.push_back(l0_method());
    return all;
  }();
  return kMethods;
}

struct Options {
  std::filesystem::path folder, out = ".";
  bool procedural = false, paper = false, sweep = false;
  std::vector<std::string> methods;  // empty: all
  unsigned seeds = 0, first_seed = 1, threads = 1, resolution = 10'000;

  bool wants(const std::string& method) const {
    return methods.empty() || std::ranges::find(methods, method) != methods.end();
  }
};

struct Pair {
  std::string group, name;
  Surface clean, noisy;
};

Score score_of(const Surface& surface, const Surface& clean, unsigned threads) {
  const ErrorMeasures errors = errors_of(surface, clean, threads);
  return {.ev = errors.ev_over_edge, .degrees = errors.mean_normal_degrees.value_or(NAN), .settings = {}};
}

Score run(const Method& method, const Settings& settings, const Pair& pair, unsigned threads) {
  Surface surface = pair.noisy;
  const auto values = expect(resolve_parameters(method, settings), method.name);
  const auto begin = std::chrono::steady_clock::now();
  expect(method.run(surface, values, {.threads = threads}), method.name);
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
  Score score = score_of(surface, pair.clean, threads);
  score.milliseconds = time.count();
  score.settings = text_of(settings);
  return score;
}

Outcome measure(const Method& method, const Pair& pair, const Options& options) {
  Outcome outcome{pair.group, pair.name, method.name, run(method, {}, pair, options.threads), {}, {}};
  if (!options.sweep) return outcome;
  for (const Settings& settings : sweep_of(method.name)) {
    const Score score = run(method, settings, pair, options.threads);
    if (!outcome.best_ev || score.ev < outcome.best_ev->ev) outcome.best_ev = score;
    if (!outcome.best_degrees || score.degrees < outcome.best_degrees->degrees) outcome.best_degrees = score;
  }
  return outcome;
}

void measure_all(const Pair& pair, const Options& options, std::vector<Outcome>& outcomes) {
  std::fprintf(stderr, "%s %s\n", pair.group.c_str(), pair.name.c_str());
  outcomes.push_back(
      {pair.group, pair.name, "noisy", score_of(pair.noisy, pair.clean, options.threads), {}, {}});
  for (const Method& method : all_methods()) {
    if (!options.wants(method.name)) continue;
    outcomes.push_back(measure(method, pair, options));
    const Outcome& o = outcomes.back();
    std::fprintf(stderr, "  %s %.4f %.2f", o.method.c_str(), o.defaults.ev, o.defaults.degrees);
    if (o.best_ev) {
      std::fprintf(stderr, "; %.4f by %s; %.2f by %s", o.best_ev->ev, o.best_ev->settings.c_str(),
                   o.best_degrees->degrees, o.best_degrees->settings.c_str());
    }
    std::fprintf(stderr, "\n");
  }
}

void measure_folder(const Options& options, std::vector<Outcome>& outcomes) {
  std::vector<std::filesystem::path> folders;
  std::error_code failure;
  for (const auto& entry : std::filesystem::directory_iterator(options.folder, failure)) {
    if (std::filesystem::exists(entry.path() / "Original.obj")) folders.push_back(entry.path());
  }
  std::ranges::sort(folders);
  for (const auto& folder : folders) {
    const std::string name = folder.filename().string();
    measure_all(
        {name, name, load_model(folder / "Original.obj").clean, load_model(folder / "Noisy.obj").clean},
        options, outcomes);
  }
}

struct NamedNoise {
  const char* name;
  NoiseOptions options;
};
const NamedNoise kNoises[] = {
    {"normal .1", {.amplitude = 0.1}},
    {"normal .2", {.amplitude = 0.2}},
    {"normal .3", {.amplitude = 0.3}},
    {"normal .5", {.amplitude = 0.5}},
    {"random .2", {.direction = NoiseDirection::Random, .amplitude = 0.2}},
    {"random .3", {.direction = NoiseDirection::Random, .amplitude = 0.3}},
    {"impulsive .7 20%", {.kind = NoiseKind::Impulsive, .amplitude = 0.7, .fraction = 0.2}},
};

const char* family_name(testing::Family family) {
  if (family == testing::Family::Machined) return "machined";
  return family == testing::Family::FreeForm ? "free-form" : "mixed";
}

void measure_procedural(const Options& options, std::vector<Outcome>& outcomes) {
  for (unsigned seed = options.first_seed; seed < options.first_seed + std::max(1U, options.seeds); ++seed) {
    for (auto& shape : testing::procedural_shapes(seed, options.resolution)) {
      const Model model = model_of(shape.name + " " + std::to_string(seed), std::move(shape.shape));
      for (const auto& [name, noise] : kNoises) {
        NoiseOptions seeded = noise;
        seeded.seed = seed;
        const std::string group = std::string(family_name(shape.family)) + " " + name;
        measure_all({group, model.name, model.clean, with_noise(model, seeded)}, options, outcomes);
      }
    }
  }
}

/// The last point of what a method without options must hold; true when it does.
bool measure_paper(const Options& options) {
  const auto automatic = find_method("auto");
  const Method& adaptive = *expect(find_method("adaptive"), "adaptive");
  const unsigned seeds = options.seeds > 0 ? options.seeds : 3;
  int runs = 0, worse_than_input = 0, worse_than_adaptive = 0;
  std::printf(
      "Ev/h, mean over %u seeds\n\n| model | noise | noisy | adaptive | auto |\n|---|---|---|---|---|\n",
      seeds);
  for (const auto& file : obj_files(options.folder)) {
    const Model model = load_model(file);
    for (const auto& [name, kind] : {std::pair{"Gaussian", NoiseKind::Gaussian},
                                     {"Uniform", NoiseKind::Uniform},
                                     {"Impulsive", NoiseKind::Impulsive}}) {
      for (const double amplitude : {0.1, 0.2, 0.3, 0.5}) {
        double noisy_sum = 0, adaptive_sum = 0, auto_sum = 0;
        for (unsigned seed = 1; seed <= seeds; ++seed) {
          const Pair pair{"", model.name, model.clean,
                          with_noise(model, {.kind = kind, .amplitude = amplitude, .seed = seed})};
          const double noisy_ev = score_of(pair.noisy, pair.clean, options.threads).ev;
          const double adaptive_ev = run(adaptive, {}, pair, options.threads).ev;
          noisy_sum += noisy_ev / seeds, adaptive_sum += adaptive_ev / seeds;
          if (!automatic) continue;
          const double auto_ev = run(**automatic, {}, pair, options.threads).ev;
          auto_sum += auto_ev / seeds;
          ++runs;
          worse_than_input += auto_ev > noisy_ev ? 1 : 0;
          worse_than_adaptive += auto_ev > 1.02 * adaptive_ev ? 1 : 0;
        }
        std::printf("| %s | %s %.0f%% | %.4f | %.4f | %s |\n", model.name.c_str(), name, 100 * amplitude,
                    noisy_sum, adaptive_sum, automatic ? std::to_string(auto_sum).substr(0, 6).c_str() : "");
      }
    }
  }
  if (runs == 0) {
    std::printf("\nThere is no method auto.\n");
  } else {
    std::printf("\nauto: %d runs, %d worse than the input, %d worse than adaptive by more than 2%%.\n", runs,
                worse_than_input, worse_than_adaptive);
  }
  return worse_than_input + worse_than_adaptive == 0;
}

[[noreturn]] void usage() {
  std::fprintf(stderr,
               "usage: denoise FOLDER | --procedural | --paper FOLDER  [--out DIR] [--sweep] [--methods a,b] "
               "[--seeds N] [--first-seed N] [--threads N] [--resolution N]\n");
  std::exit(2);
}

unsigned number_of(const char* text) {
  unsigned number = 0;
  const auto [end, failure] = std::from_chars(text, text + std::strlen(text), number);
  if (failure != std::errc() || *end != 0 || number == 0) usage();
  return number;
}

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts = {""};
  for (const char c : list) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  for (const std::string& method : parts) {
    if (method != l0_method().name) expect(find_method(method), "--methods");
  }
  return parts;
}

Options parse(int count, char** arguments) {
  Options options;
  for (int i = 1; i < count; ++i) {
    const std::string name = arguments[i];
    const auto value = [&] { return ++i < count ? arguments[i] : (usage(), nullptr); };
    if (name == "--procedural") {
      options.procedural = true;
    } else if (name == "--paper") {
      options.paper = true;
    } else if (name == "--sweep") {
      options.sweep = true;
    } else if (name == "--out") {
      options.out = value();
    } else if (name == "--methods") {
      options.methods = split(value());
    } else if (name == "--seeds") {
      options.seeds = number_of(value());
    } else if (name == "--first-seed") {
      options.first_seed = number_of(value());
    } else if (name == "--threads") {
      options.threads = number_of(value());
    } else if (name == "--resolution") {
      options.resolution = number_of(value());
    } else if (name.starts_with("-") || !options.folder.empty()) {
      usage();
    } else {
      options.folder = name;
    }
  }
  if (options.folder.empty() != options.procedural || (options.paper && options.procedural)) usage();
  return options;
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  using namespace burnish::bench;
  const Options options = parse(count, arguments);
  if (options.paper) return measure_paper(options) ? 0 : 1;
  std::vector<Outcome> outcomes;
  options.procedural ? measure_procedural(options, outcomes) : measure_folder(options, outcomes);
  if (outcomes.empty()) {
    std::fprintf(stderr, "%s: no pairs NAME/{Original,Noisy}.obj\n", options.folder.c_str());
    return 2;
  }
  print_tables(outcomes);
  std::error_code failure;
  std::filesystem::create_directories(options.out, failure);
  if (write_csv(outcomes, options.out / "denoise.csv") && write_svg(outcomes, options.out / "denoise.svg"))
    return 0;
  std::fprintf(stderr, "%s: cannot write\n", options.out.c_str());
  return 2;
}
