#include "server/config.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "server/lifecycle.h"

namespace burnish {
namespace {

std::variant<Config, int> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "burnishd");
  return parse_config(static_cast<int>(arguments.size()), arguments.data());
}

TEST(Config, UnderstandsAddresses) {
  struct Row {
    const char* text;
    Address address;
  };
  for (const Row& row : {Row{"127.0.0.1:8080", {"127.0.0.1", 8080}}, Row{"localhost:0", {"localhost", 0}},
                         Row{"[::1]:443", {"::1", 443}}, Row{"0.0.0.0:65535", {"0.0.0.0", 65535}}}) {
    const auto address = parse_address(row.text);
    ASSERT_TRUE(address.ok()) << row.text;
    EXPECT_EQ(address.value(), row.address) << row.text;
    EXPECT_EQ(address.value().text(), row.text);
  }
}

TEST(Config, RefusesWhatIsNoAddress) {
  for (const char* text : {"", "8080", ":8080", "localhost", "localhost:", "localhost:x", "localhost:65536",
                           "::1:80", "[::1]", "[]:80", "host:-1", "host:80 "}) {
    const auto address = parse_address(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_EQ(address.error().cause, Cause::BadOption) << text;
  }
}

TEST(Config, HasTheDocumentedDefaults) {
  const auto parsed = parse({});
  const auto* config = std::get_if<Config>(&parsed);
  ASSERT_NE(config, nullptr);
  EXPECT_EQ(config->grpc_listen.text(), "127.0.0.1:50051");
  EXPECT_EQ(config->http_listen.text(), "127.0.0.1:8080");
  EXPECT_EQ(config->max_bytes, 64u << 20);
  EXPECT_EQ(config->queue, 64u);
  EXPECT_EQ(config->longest_run.count(), 600);
  EXPECT_EQ(config->grace.count(), 30);
}

TEST(Config, ReadsFlags) {
  const auto parsed =
      parse({"--grpc-listen", "[::1]:1", "--http-listen",   "localhost:2", "--workers",    "3",
             "--queue",       "4",       "--threads",       "5",           "--max-bytes",  "6",
             "--max-seconds", "7",       "--grace-seconds", "8",           "--ports-file", "p",
             "--log-level",   "debug"});
  const auto* config = std::get_if<Config>(&parsed);
  ASSERT_NE(config, nullptr);
  EXPECT_EQ(config->grpc_listen.text(), "[::1]:1");
  EXPECT_EQ(config->http_listen.text(), "localhost:2");
  EXPECT_EQ(config->workers, 3u);
  EXPECT_EQ(config->queue, 4u);
  EXPECT_EQ(config->threads, 5u);
  EXPECT_EQ(config->max_bytes, 6u);
  EXPECT_EQ(config->longest_run.count(), 7);
  EXPECT_EQ(config->grace.count(), 8);
  EXPECT_EQ(config->ports_file, "p");
  EXPECT_EQ(config->log_level, "debug");
}

TEST(Config, ReadsTheEnvironmentAndLetsFlagsWin) {
  ::setenv("BURNISH_GRPC_LISTEN", "127.0.0.1:7", 1);
  ::setenv("BURNISH_QUEUE", "9", 1);
  const auto parsed = parse({"--queue", "10"});
  ::unsetenv("BURNISH_GRPC_LISTEN");
  ::unsetenv("BURNISH_QUEUE");
  const auto* config = std::get_if<Config>(&parsed);
  ASSERT_NE(config, nullptr);
  EXPECT_EQ(config->grpc_listen.port, 7);
  EXPECT_EQ(config->queue, 10u);
}

TEST(Config, EndsWithAnExitCodeWhenThereIsNothingToServe) {
  struct Row {
    std::vector<const char*> arguments;
    int exit_code;
  };
  for (const Row& row :
       {Row{{"--help"}, 0}, Row{{"--version"}, 0}, Row{{"--no-such-flag"}, 2}, Row{{"--workers", "-1"}, 2},
        Row{{"--max-bytes", "0"}, 2}, Row{{"--http-listen", "8080"}, 2}, Row{{"--max-seconds", "0"}, 2},
        Row{{"--log-level", "loud"}, 2}}) {
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto parsed = parse(row.arguments);
    const std::string printed =
        ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
    const int* exit_code = std::get_if<int>(&parsed);
    ASSERT_NE(exit_code, nullptr) << row.arguments[0];
    EXPECT_EQ(*exit_code, row.exit_code) << row.arguments[0];
    EXPECT_FALSE(printed.empty()) << row.arguments[0];
  }
}

TEST(Lifecycle, MovesForwardOnly) {
  Lifecycle life;
  EXPECT_EQ(lifecycle_name(life.state()), "starting");
  EXPECT_TRUE(life.move_to(LifecycleState::Serving));
  EXPECT_FALSE(life.move_to(LifecycleState::Serving));
  EXPECT_FALSE(life.move_to(LifecycleState::Stopped)) << "accepted work must drain first";
  EXPECT_TRUE(life.move_to(LifecycleState::Draining));
  EXPECT_FALSE(life.move_to(LifecycleState::Serving));
  EXPECT_TRUE(life.move_to(LifecycleState::Stopped));
  EXPECT_FALSE(life.move_to(LifecycleState::Draining));
  EXPECT_EQ(lifecycle_name(life.state()), "stopped");
}

}  // namespace
}  // namespace burnish
