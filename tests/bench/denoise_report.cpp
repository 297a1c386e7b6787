#include "tests/bench/denoise_report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>

namespace burnish::bench {
namespace {

std::string text(double value, int digits) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
  return buffer;
}

/// What occurs, in the order of its first time.
std::vector<std::string> distinct(const std::vector<Outcome>& outcomes, std::string Outcome::*member) {
  std::vector<std::string> values;
  for (const Outcome& o : outcomes) {
    if (std::ranges::find(values, o.*member) == values.end()) values.push_back(o.*member);
  }
  return values;
}

using Value = std::function<std::optional<double>(const Outcome&)>;

std::optional<double> mean(const std::vector<Outcome>& outcomes, const std::string& group,
                           const std::string& method, const Value& value) {
  double sum = 0;
  int count = 0;
  for (const Outcome& o : outcomes) {
    if (o.group != group || o.method != method) continue;
    const auto one = value(o);
    if (!one) return {};
    sum += *one;
    ++count;
  }
  if (count == 0) return {};
  return sum / count;
}

std::optional<double> default_ev(const Outcome& o) { return o.defaults.ev; }
std::optional<double> best_ev(const Outcome& o) {
  if (!o.best_ev) return {};
  return o.best_ev->ev;
}
std::optional<double> default_degrees(const Outcome& o) { return o.defaults.degrees; }
std::optional<double> best_degrees(const Outcome& o) {
  if (!o.best_degrees) return {};
  return o.best_degrees->degrees;
}
std::optional<double> milliseconds(const Outcome& o) { return o.defaults.milliseconds; }

void print_table(const std::vector<Outcome>& outcomes, const char* title, int digits, const Value& plain,
                 const Value& best) {
  const auto groups = distinct(outcomes, &Outcome::group);
  std::printf("%s\n\n| method |", title);
  for (const std::string& group : groups) std::printf(" %s |", group.c_str());
  std::printf("\n|---|");
  for (std::size_t i = 0; i < groups.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const std::string& method : distinct(outcomes, &Outcome::method)) {
    std::printf("| %s |", method.c_str());
    for (const std::string& group : groups) {
      const auto value = mean(outcomes, group, method, plain), swept = mean(outcomes, group, method, best);
      std::printf(" %s%s |", value ? text(*value, digits).c_str() : "",
                  swept ? (" (" + text(*swept, digits) + ")").c_str() : "");
    }
    std::printf("\n");
  }
  std::printf("\n");
}

constexpr int kNames = 216, kPanel = 210, kGap = 24, kRow = 18, kHead = 46, kAcross = 5;

/// One panel with its bars; (x, y) is its top left corner.
void draw_panel(std::ostream& out, const std::vector<Outcome>& outcomes, const std::string& group,
                const std::vector<std::string>& methods, double x, double y) {
  const double noisy = mean(outcomes, group, "noisy", default_ev).value_or(0), full = 1.2 * noisy;
  const auto at = [&](double ev) { return text(x + kPanel * std::min(ev / full, 1.0), 1); };
  const double bottom = y + kHead + kRow * static_cast<double>(methods.size());
  out << "<text class='group' x='" << x << "' y='" << y + 20 << "'>" << group << "</text>\n"
      << "<text class='small' x='" << x << "' y='" << y + 36 << "'>noisy " << text(noisy, 3) << "</text>\n"
      << "<line class='noisy' x1='" << at(noisy) << "' x2='" << at(noisy) << "' y1='" << y + 28 << "' y2='"
      << bottom << "'/>\n";
  double best = full;
  for (const std::string& method : methods)
    best = std::min(best, mean(outcomes, group, method, default_ev).value_or(full));
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const double top = y + kHead + kRow * static_cast<double>(i);
    const auto ev = mean(outcomes, group, methods[i], default_ev),
               swept = mean(outcomes, group, methods[i], best_ev);
    if (!ev) continue;
    const double width = kPanel * std::min(*ev / full, 1.0);
    out << "<rect class='" << (*ev <= best ? "first" : "bar") << "' x='" << x << "' y='" << top + 3
        << "' width='" << text(width, 1) << "' height='" << kRow - 6 << "' rx='2'/>\n"
        << "<text class='" << (width > 45 ? "value" : "small") << "' x='"
        << text(width > 45 ? x + 4 : x + width + 5, 1) << "' y='" << top + 13 << "'>" << text(*ev, 3)
        << "</text>\n";
    if (swept) {
      out << "<line class='tick' x1='" << at(*swept) << "' x2='" << at(*swept) << "' y1='" << top + 1
          << "' y2='" << top + kRow - 1 << "'/>\n";
    }
  }
}

constexpr const char* kStyle = R"(<style>
text { font: 12px system-ui, sans-serif; fill: #222 }
.group { font-weight: 600; font-size: 13px } .small { font-size: 10px; fill: #666 }
.value { font-size: 10px; fill: #fff } .bar { fill: #5b84b1 } .first { fill: #2f9e6e }
.noisy { stroke: #c0504d; stroke-dasharray: 4 3 } .tick { stroke: #111; stroke-width: 2.5 }
</style>
)";

}  // namespace

void print_tables(const std::vector<Outcome>& outcomes) {
  print_table(outcomes, "Ev/h with defaults (best of a sweep)", 4, default_ev, best_ev);
  print_table(outcomes, "Mean normal error with defaults (best of a sweep), degrees", 2, default_degrees,
              best_degrees);
  print_table(outcomes, "Time with defaults, ms", 1, milliseconds,
              [](const Outcome&) { return std::optional<double>(); });
}

bool write_csv(const std::vector<Outcome>& outcomes, const std::filesystem::path& path) {
  std::ofstream out(path);
  out << "group,pair,method,ev_over_edge,mean_normal_degrees,milliseconds,best_ev_over_edge,best_ev_settings,"
         "best_mean_normal_degrees,best_mean_normal_settings\n";
  for (const Outcome& o : outcomes) {
    out << o.group << ',' << o.pair << ',' << o.method << ',' << text(o.defaults.ev, 5) << ','
        << text(o.defaults.degrees, 3) << ',' << text(o.defaults.milliseconds, 2) << ',';
    if (o.best_ev) out << text(o.best_ev->ev, 5) << ',' << o.best_ev->settings;
    out << (o.best_ev ? "," : ",,");
    if (o.best_degrees) out << text(o.best_degrees->degrees, 3) << ',' << o.best_degrees->settings;
    out << (o.best_degrees ? "\n" : ",\n");
  }
  return static_cast<bool>(out.flush());
}

bool write_svg(const std::vector<Outcome>& outcomes, const std::filesystem::path& path) {
  const auto groups = distinct(outcomes, &Outcome::group);
  auto methods = distinct(outcomes, &Outcome::method);
  std::erase(methods, "noisy");
  const auto rows = (groups.size() + kAcross - 1) / kAcross,
             across = std::min<std::size_t>(groups.size(), kAcross);
  const double row_height = kHead + kRow * static_cast<double>(methods.size()) + kGap;
  const double width = kNames + static_cast<double>(across) * (kPanel + kGap);
  const double height = 40 + row_height * static_cast<double>(rows);
  std::ofstream out(path);
  out << "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 " << width << ' ' << height << "' width='"
      << width << "' height='" << height << "'>\n"
      << kStyle << "<rect width='100%' height='100%' fill='#fff'/>\n"
      << "<text class='group' x='16' y='26'>Ev/h with defaults: less is better. Green: the least. Black "
         "tick: best "
         "of a sweep that knows the original. Dashed: the noisy input.</text>\n";
  for (std::size_t row = 0; row < rows; ++row) {
    const double y = 40 + row_height * static_cast<double>(row);
    for (std::size_t i = 0; i < methods.size(); ++i) {
      out << "<text text-anchor='end' x='" << kNames - 12 << "' y='"
          << y + kHead + kRow * static_cast<double>(i) + 13 << "'>" << methods[i] << "</text>\n";
    }
    for (std::size_t column = 0; column < across && row * kAcross + column < groups.size(); ++column) {
      draw_panel(out, outcomes, groups[row * kAcross + column], methods,
                 kNames + static_cast<double>(column) * (kPanel + kGap), y);
    }
  }
  out << "</svg>\n";
  return static_cast<bool>(out.flush());
}

}  // namespace burnish::bench
