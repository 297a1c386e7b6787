#include "server/config.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <utility>
#include <vector>

#include "server/lifecycle.h"
#include "tests/client/temporary_folder.h"

namespace burnish {
namespace {

std::variant<Config, int> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "burnishd");
  return parse_config(static_cast<int>(arguments.size()), arguments.data());
}

Config parsed(std::vector<const char*> arguments) {
  const auto result = parse(std::move(arguments));
  if (const auto* config = std::get_if<Config>(&result)) return *config;
  ADD_FAILURE() << "refused";
  return {};
}

/// Sets a variable for one test.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) { ::setenv(name, value.c_str(), 1); }
  ~Variable() { ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

TEST(Config, UnderstandsAddresses) {
  struct Row {
    const char* text;
    Address address;
  };
  for (const Row& row :
       {Row{"127.0.0.1:8080", {"127.0.0.1", 8080}}, Row{"localhost:0", {"localhost", 0}},
        Row{"[::1]:443", {"::1", 443}}, Row{"0.0.0.0:65535", {"0.0.0.0", 65535}},
        Row{"unix:/run/b:1.sock", {"", 0, "/run/b:1.sock"}}, Row{"unix:b.sock", {"", 0, "b.sock"}}}) {
    const auto address = parse_address(row.text);
    ASSERT_TRUE(address.ok()) << row.text;
    EXPECT_EQ(address.value(), row.address) << row.text;
    EXPECT_EQ(address.value().text(), row.text);
    EXPECT_EQ(address.value().is_unix(), row.address.host.empty()) << row.text;
  }
}

TEST(Config, RefusesWhatIsNoAddress) {
  const std::string too_long = "unix:/" + std::string(107, 'x');
  for (const char* text : {"", "8080", ":8080", "localhost", "localhost:", "localhost:x", "localhost:65536",
                           "::1:80", "[::1]", "[]:80", "host:-1", "host:80 ", "unix:", too_long.c_str()}) {
    const auto address = parse_address(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_EQ(address.error().cause, Cause::BadOption) << text;
  }
}

TEST(Config, ReadsFlags) {
  const Config config = parsed({"--grpc-listen",
                                "[::1]:1",
                                "--http-listen",
                                "localhost:2",
                                "--ports-file",
                                "p",
                                "--workers",
                                "3",
                                "--queue",
                                "4",
                                "--threads",
                                "5",
                                "--max-memory",
                                "6GiB",
                                "--spool-folder",
                                "s",
                                "--max-spool-bytes",
                                "7TiB",
                                "--max-bytes",
                                "8KiB",
                                "--max-vertices",
                                "9",
                                "--max-triangles",
                                "10",
                                "--max-attributes",
                                "11",
                                "--max-line-bytes",
                                "12",
                                "--max-iterations",
                                "13",
                                "--max-option-bytes",
                                "14",
                                "--max-unary-bytes",
                                "65536",
                                "--max-streams",
                                "16",
                                "--grpc-compression",
                                "--max-connections",
                                "17",
                                "--head-seconds",
                                "18",
                                "--min-body-rate",
                                "19",
                                "--cors-origin",
                                "https://a",
                                "--cors-origin",
                                "https://b:1",
                                "--max-seconds",
                                "20",
                                "--grace-seconds",
                                "21",
                                "--replica",
                                "burnish-1",
                                "--log-level",
                                "debug"});
  EXPECT_EQ(config.grpc_listen.text(), "[::1]:1");
  EXPECT_EQ(config.http_listen.text(), "localhost:2");
  EXPECT_EQ(config.ports_file, "p");
  EXPECT_EQ(config.workers, 3u);
  EXPECT_EQ(config.queue, 4u);
  EXPECT_EQ(config.threads, 5u);
  EXPECT_EQ(config.max_memory, 6ull << 30);
  EXPECT_EQ(config.replica, "burnish-1");
  EXPECT_EQ(config.spool_folder, "s");
  EXPECT_EQ(config.max_spool_bytes, 7ull << 40);
  EXPECT_EQ(config.limits.mesh.max_bytes, 8u << 10);
  EXPECT_EQ(config.limits.mesh.max_vertices, 9u);
  EXPECT_EQ(config.limits.mesh.max_triangles, 10u);
  EXPECT_EQ(config.limits.mesh.max_attributes, 11u);
  EXPECT_EQ(config.limits.mesh.max_line_bytes, 12u);
  EXPECT_EQ(config.limits.max_iterations, 13u);
  EXPECT_EQ(config.limits.max_option_bytes, 14u);
  EXPECT_EQ(config.max_unary_bytes, 65536u);
  EXPECT_EQ(config.max_streams, 16);
  EXPECT_TRUE(config.grpc_compression);
  EXPECT_EQ(config.max_connections, 17u);
  EXPECT_EQ(config.head_timeout.count(), 18);
  EXPECT_EQ(config.min_body_rate, 19u);
  EXPECT_EQ(config.cors_origins, (std::vector<std::string>{"https://a", "https://b:1"}));
  EXPECT_EQ(config.longest_run.count(), 20);
  EXPECT_EQ(config.grace.count(), 21);
  EXPECT_EQ(config.log_level, "debug");
}

TEST(Config, LetsFlagsWinOverTheEnvironmentAndThatOverTheFile) {
  const cli::TemporaryFolder folder;
  const std::string file =
      folder.write("c.json", R"({"workers": 1, "queue": 1, "threads": 1, "cors-origin": ["https://file"]})");
  const Variable config_file("BURNISH_CONFIG", file), queue("BURNISH_QUEUE", "2"),
      threads("BURNISH_THREADS", "2"), origins("BURNISH_CORS_ORIGIN", "https://a,https://b"),
      compression("BURNISH_GRPC_COMPRESSION", "true");
  const Config config = parsed({"--threads", "3"});
  EXPECT_EQ(config.workers, 1u);
  EXPECT_EQ(config.queue, 2u);
  EXPECT_EQ(config.threads, 3u);
  EXPECT_EQ(config.cors_origins, (std::vector<std::string>{"https://a", "https://b"}));
  EXPECT_TRUE(config.grpc_compression);
  EXPECT_EQ(config.max_connections, Config().max_connections);
}

TEST(Config, EndsWithAnExitCodeWhenThereIsNothingToServe) {
  const cli::TemporaryFolder folder;
  const std::string wrong = folder.write("wrong.json", R"({"queue": -1})");
  struct Row {
    std::vector<const char*> arguments;
    int exit_code;
    std::string printed;
  };
  for (const Row& row : {
           Row{{"--help"}, 0, "--queue 0 to 65536 [64] (BURNISH_QUEUE)"},
           Row{{"--version"}, 0, "burnishd "},
           Row{{"--print-config"}, 0, "\"max-bytes\": 268435456,"},
           Row{{"--print-config", "--queue", "5"}, 0, "\"queue\": 5,"},
           Row{{"--no-such-flag"}, 2, "--no-such-flag"},
           Row{{"extra"}, 2, "extra"},
           Row{{"--queue"}, 2, "--queue"},
           Row{{"--queue", "1", "--queue", "2"}, 2, "--queue"},
           Row{{"--workers", "-1"},
               2,
               "--workers (or BURNISH_WORKERS): '-1' is not a whole number from 0 to 1024"},
           Row{{"--workers", "010x"}, 2, "--workers"},
           Row{{"--max-bytes", "0"}, 2, "'0' is not a size such as 64MiB, from 1 to 1TiB"},
           Row{{"--max-bytes", "1.5GiB"}, 2, "--max-bytes"},
           Row{{"--max-bytes", "MiB"}, 2, "--max-bytes"},
           Row{{"--max-memory", "18446744073709551615KiB"}, 2, "--max-memory"},
           Row{{"--http-listen", "8080"}, 2, "HOST:PORT"},
           Row{{"--max-seconds", "0"}, 2, "--max-seconds"},
           Row{{"--grpc-compression=maybe"}, 2, "'maybe' is not true or false"},
           Row{{"--cors-origin", "a.example"}, 2, "--cors-origin"},
           Row{{"--log-level", "loud"}, 2, "--log-level"},
           Row{{"--replica", "Burnish_1"}, 2, "--replica"},
           Row{{"--replica", "-1"}, 2, "--replica"},
           Row{{"--config", "/no/such/file"}, 2, "/no/such/file: cannot be read"},
           Row{{"--config", wrong.c_str(), "--queue", "1"}, 2, wrong + ": settings.queue: '-1'"},
       }) {
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto result = parse(row.arguments);
    const std::string printed =
        ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
    const int* exit_code = std::get_if<int>(&result);
    ASSERT_NE(exit_code, nullptr) << row.arguments[0];
    EXPECT_EQ(*exit_code, row.exit_code) << row.arguments[0];
    EXPECT_NE(printed.find(row.printed), std::string::npos) << printed;
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
