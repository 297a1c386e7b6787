#include "server/observe/process_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

namespace burnish {
namespace {

/// From /proc/self/stat; proc(5) numbers its fields from 1.
struct ProcessStat {
  double cpu_seconds = 0, seconds_from_boot_to_start = 0, virtual_bytes = 0, resident_bytes = 0;
};

ProcessStat read_stat() {
  std::ifstream file("/proc/self/stat");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  // Field 2 is the program's name in parentheses and may hold anything.
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return {};
  std::istringstream rest(text.substr(name_end + 1));
  const std::vector<std::string> fields{std::istream_iterator<std::string>(rest), {}};
  const auto field = [&](std::size_t number) {
    return number - 3 < fields.size() ? std::stod(fields[number - 3]) : 0.0;
  };
  const auto ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  return {.cpu_seconds = (field(14) + field(15)) / ticks,
          .seconds_from_boot_to_start = field(22) / ticks,
          .virtual_bytes = field(23),
          .resident_bytes = field(24) * static_cast<double>(sysconf(_SC_PAGESIZE))};
}

/// In Unix time.
double boot_seconds() {
  std::ifstream file("/proc/stat");
  for (std::string word; file >> word;) {
    double seconds = 0;
    if (word == "btime" && file >> seconds) return seconds;
  }
  return 0;
}

double open_descriptors() {
  std::error_code failure;
  std::filesystem::directory_iterator folder("/proc/self/fd", failure);
  if (failure) return 0;
  return static_cast<double>(std::distance(begin(folder), end(folder)) - 1);  // one is the listing's own
}

double most_descriptors() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  return static_cast<double>(limit.rlim_cur);
}

}  // namespace

prometheus::MetricFamily single_metric(std::string name, std::string help, prometheus::MetricType type,
                                       double value) {
  prometheus::ClientMetric metric;
  metric.gauge.value = metric.counter.value = value;
  return {std::move(name), std::move(help), type, {std::move(metric)}};
}

std::vector<prometheus::MetricFamily> process_metrics() {
  using enum prometheus::MetricType;
  static const double booted = boot_seconds();
  const ProcessStat stat = read_stat();
  return {
      single_metric("process_cpu_seconds_total", "CPU time spent, user and system.", Counter,
                    stat.cpu_seconds),
      single_metric("process_resident_memory_bytes", "Memory in RAM.", Gauge, stat.resident_bytes),
      single_metric("process_virtual_memory_bytes", "Address space.", Gauge, stat.virtual_bytes),
      single_metric("process_open_fds", "Open file descriptors.", Gauge, open_descriptors()),
      single_metric("process_max_fds", "Most file descriptors that may be open.", Gauge, most_descriptors()),
      single_metric("process_start_time_seconds", "Unix time of the start.", Gauge,
                    booted + stat.seconds_from_boot_to_start),
  };
}

}  // namespace burnish
