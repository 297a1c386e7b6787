#include "server/observe/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

namespace burnish {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> lines_of(const Metrics& metrics, const Gauges& gauges = {}) {
  std::istringstream text(metrics.text(gauges));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

double value_of(const Metrics& metrics, const std::string& series) {
  for (const std::string& line : lines_of(metrics)) {
    if (line.starts_with(series + " ")) return std::stod(line.substr(series.size() + 1));
  }
  ADD_FAILURE() << "no series " << series;
  return -1;
}

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

TEST(Metrics, HasEverySeriesFromTheStart) {
  const auto lines = lines_of(Metrics());
  for (const std::string transport : {"grpc", "http"}) {
    for (const std::string kind : {"smooth", "compare"}) {
      const std::string labels = "kind=\"" + kind + "\",transport=\"" + transport + "\"} 0";
      EXPECT_THAT(lines, Contains("burnish_requests_total{" + labels));
      EXPECT_THAT(lines, Contains("burnish_request_mesh_bytes_count{" + labels));
      EXPECT_THAT(lines, Contains("burnish_outcomes_total{code=\"ok\"," + labels));
      for (const Cause cause : all_causes()) {
        const std::string line =
            "burnish_outcomes_total{code=\"" + std::string(cause_code(cause)) + "\"," + labels;
        const bool clients = cause == Cause::Unreachable || cause == Cause::FileError;
        EXPECT_EQ(std::ranges::count(lines, line), clients ? 0 : 1) << line;
      }
    }
  }
  for (const std::string stage : {"queue", "decode", "prepare", "smooth", "measure", "encode"}) {
    EXPECT_THAT(lines, Contains("burnish_stage_seconds_count{kind=\"smooth\",stage=\"" + stage + "\"} 0"));
  }
}

TEST(Metrics, CountsRequestsByTransportKindAndOutcome) {
  Metrics metrics;
  const Error full{Cause::QueueFull, "full"}, clients{Cause::Unreachable, "never on a server"};
  for (int i = 0; i < 4; ++i) metrics.count_request(Transport::Http, Kind::Compare);
  metrics.count_outcome(Transport::Http, Kind::Compare, nullptr);
  for (int i = 0; i < 2; ++i) metrics.count_outcome(Transport::Http, Kind::Compare, &full);
  metrics.count_outcome(Transport::Http, Kind::Compare, &clients);
  const auto lines = lines_of(metrics);
  EXPECT_THAT(lines, Contains("burnish_requests_total{kind=\"compare\",transport=\"http\"} 4"));
  EXPECT_THAT(lines, Contains("burnish_requests_total{kind=\"smooth\",transport=\"http\"} 0"));
  EXPECT_THAT(lines, Contains("burnish_outcomes_total{code=\"ok\",kind=\"compare\",transport=\"http\"} 1"));
  EXPECT_THAT(lines,
              Contains("burnish_outcomes_total{code=\"queue_full\",kind=\"compare\",transport=\"http\"} 2"));
  EXPECT_THAT(lines,
              Contains("burnish_outcomes_total{code=\"internal\",kind=\"compare\",transport=\"http\"} 1"));
}

TEST(Metrics, ObservesSecondsPerStage) {
  Metrics metrics;
  v1::StageTimings timings;
  timings.set_queue_ms(1500);
  timings.set_smooth_ms(250);
  timings.set_total_ms(2000);
  metrics.observe(Kind::Smooth, timings);
  const auto lines = lines_of(metrics);
  EXPECT_THAT(lines, Contains("burnish_stage_seconds_sum{kind=\"smooth\",stage=\"queue\"} 1.5"));
  EXPECT_THAT(lines, Contains("burnish_stage_seconds_sum{kind=\"smooth\",stage=\"smooth\"} 0.25"));
  EXPECT_THAT(lines, Contains("burnish_stage_seconds_count{kind=\"smooth\",stage=\"encode\"} 1"));
  EXPECT_THAT(lines, Contains("burnish_stage_seconds_count{kind=\"compare\",stage=\"queue\"} 0"));
  EXPECT_THAT(lines, Contains("burnish_job_seconds_sum{kind=\"smooth\"} 2"));
}

TEST(Metrics, KnowsThatAComparisonNeitherSmoothsNorEncodes) {
  Metrics metrics;
  metrics.observe(Kind::Compare, v1::StageTimings());
  metrics.count_bytes(Transport::Grpc, Kind::Compare, 10, 20);
  const auto lines = lines_of(metrics);
  EXPECT_THAT(lines, Contains("burnish_stage_seconds_count{kind=\"compare\",stage=\"measure\"} 1"));
  EXPECT_THAT(lines, Contains("burnish_request_mesh_bytes_sum{kind=\"compare\",transport=\"grpc\"} 10"));
  for (const char* absent : {"kind=\"compare\",stage=\"smooth\"", "kind=\"compare\",stage=\"encode\"",
                             "burnish_response_mesh_bytes_sum{kind=\"compare\""}) {
    EXPECT_THAT(lines, Not(Contains(HasSubstr(absent)))) << absent;
  }
}

TEST(Metrics, ObservesMeshBytesThatCameAndWent) {
  Metrics metrics;
  metrics.count_bytes(Transport::Grpc, Kind::Smooth, 5000, 4000);
  metrics.count_bytes(Transport::Grpc, Kind::Smooth, 3000, 0);  // refused: no mesh went
  metrics.count_bytes(Transport::Grpc, Kind::Smooth, 0, 0);
  const auto lines = lines_of(metrics);
  const std::string labels = "{kind=\"smooth\",transport=\"grpc\"} ";
  EXPECT_THAT(lines, Contains("burnish_request_mesh_bytes_sum" + labels + "8000"));
  EXPECT_THAT(lines, Contains("burnish_request_mesh_bytes_count" + labels + "2"));
  EXPECT_THAT(lines, Contains("burnish_response_mesh_bytes_sum" + labels + "4000"));
  EXPECT_THAT(lines, Contains("burnish_response_mesh_bytes_count" + labels + "1"));
}

TEST(Metrics, ShowsWhatItIsGiven) {
  const auto lines = lines_of(Metrics(), {.queued = 1,
                                          .running = 2,
                                          .workers = 3,
                                          .reserved_bytes = 4,
                                          .spooled_bytes = 5,
                                          .lifecycle = "draining"});
  for (const char* line :
       {"burnish_queue_depth 1", "burnish_jobs_running 2", "burnish_workers 3",
        "burnish_reserved_memory_bytes 4", "burnish_spooled_bytes 5",
        "burnish_lifecycle_state{state=\"draining\"} 1", "burnish_lifecycle_state{state=\"starting\"} 0",
        "burnish_lifecycle_state{state=\"serving\"} 0", "burnish_lifecycle_state{state=\"stopped\"} 0"}) {
    EXPECT_THAT(lines, Contains(line));
  }
  EXPECT_THAT(lines, Contains(HasSubstr("burnish_build_info{version=\"0.")));
}

TEST(Metrics, TellsWhenTheLastSelfTestWas) {
  Metrics metrics;
  EXPECT_EQ(value_of(metrics, "burnish_self_test_timestamp_seconds"), 0);
  metrics.record_self_test(true);
  EXPECT_EQ(value_of(metrics, "burnish_self_test_passed"), 1);
  EXPECT_NEAR(value_of(metrics, "burnish_self_test_timestamp_seconds"), seconds_now(), 60);
  metrics.record_self_test(false);
  EXPECT_EQ(value_of(metrics, "burnish_self_test_passed"), 0);
}

TEST(Metrics, MeasuresTheProcess) {
  const Metrics metrics;
  const double open = value_of(metrics, "process_open_fds");
  const std::ifstream one_more("/proc/self/stat");
  EXPECT_EQ(value_of(metrics, "process_open_fds"), open + 1);
  EXPECT_GT(value_of(metrics, "process_max_fds"), open);
  EXPECT_GT(value_of(metrics, "process_resident_memory_bytes"), 1 << 20);
  EXPECT_GT(value_of(metrics, "process_virtual_memory_bytes"),
            value_of(metrics, "process_resident_memory_bytes"));
  EXPECT_LE(value_of(metrics, "process_start_time_seconds"),
            seconds_now() + 2);  // to a clock tick and rounding
  EXPECT_GE(value_of(metrics, "process_start_time_seconds"), seconds_now() - 3600);

  const double cpu = value_of(metrics, "process_cpu_seconds_total");
  const auto spun = [&] { return value_of(metrics, "process_cpu_seconds_total") - cpu; };
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (spun() <= 0 && std::chrono::steady_clock::now() < end) {
  }
  EXPECT_GT(spun(), 0);
}

TEST(Metrics, CountsFromManyThreadsWithoutLoss) {
  Metrics metrics;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < 1000; ++k) {
          metrics.count_request(Transport::Grpc, Kind::Smooth);
          metrics.count_outcome(Transport::Grpc, Kind::Smooth, nullptr);
          metrics.observe(Kind::Smooth, v1::StageTimings());
        }
        metrics.text({});
      });
    }
  }
  const auto lines = lines_of(metrics);
  EXPECT_THAT(lines, Contains("burnish_requests_total{kind=\"smooth\",transport=\"grpc\"} 4000"));
  EXPECT_THAT(lines, Contains("burnish_stage_seconds_count{kind=\"smooth\",stage=\"decode\"} 4000"));
}

}  // namespace
}  // namespace burnish
