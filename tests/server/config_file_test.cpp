#include "server/config_file.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/client/temporary_folder.h"

namespace burnish {
namespace {

Result<Config> read(const std::string& path) {
  Config config;
  const auto settings = settings_of(config);
  if (auto applied = apply_config_file(path, settings); !applied) return std::move(applied).error();
  return config;
}

TEST(ConfigFile, SetsWhatItNames) {
  const cli::TemporaryFolder folder;
  const auto config = read(folder.write("c.json", R"({
    "grpc-listen": "unix:/run/burnish.sock", "queue": 7, "max-bytes": "64MiB", "max-memory": 123456,
    "grpc-compression": true, "cors-origin": ["https://a.example", "http://localhost:3000"],
    "head-seconds": 3, "log-level": "warn", "spool-folder": "/var/spool/burnish", "max-vertices": 5
  })"));
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config->grpc_listen.path, "/run/burnish.sock");
  EXPECT_EQ(config->queue, 7u);
  EXPECT_EQ(config->limits.mesh.max_bytes, 64u << 20);
  EXPECT_EQ(config->limits.mesh.max_vertices, 5u);
  EXPECT_EQ(config->max_memory, 123456u);
  EXPECT_TRUE(config->grpc_compression);
  EXPECT_EQ(config->cors_origins, (std::vector<std::string>{"https://a.example", "http://localhost:3000"}));
  EXPECT_EQ(config->head_timeout.count(), 3);
  EXPECT_EQ(config->log_level, "warn");
  EXPECT_EQ(config->spool_folder, "/var/spool/burnish");
  EXPECT_EQ(config->workers, Config().workers) << "what it does not name keeps its default";
}

TEST(ConfigFile, NamesFileAndKeyOfWhatIsWrong) {
  struct Row {
    std::string text;
    const char* message;  ///< after the file's name
  };
  const std::string deep = std::string(500'000, '[') + std::string(500'000, ']');
  for (const Row& row : {
           Row{R"({"quota": 1})", "settings.quota is no setting"},
           Row{R"({"config": "other.json"})", "settings.config is no setting"},
           Row{R"({"queue": 1, "queue": 2})", "settings.queue is given twice"},
           Row{R"({"queue": "1"})", "settings.queue must be a number, not string"},
           Row{R"({"queue": null})", "settings.queue is null; leave it out instead"},
           Row{R"({"queue": 1.5})", "settings.queue: \'1.5' is not a whole number from 0 to 65536"},
           Row{R"({"queue": -1})", "settings.queue: \'-1' is not a whole number from 0 to 65536"},
           Row{R"({"queue": 65537})", "settings.queue: \'65537' is not a whole number from 0 to 65536"},
           Row{R"({"max-bytes": "64 apples"})",
               "settings.max-bytes: \'64 apples' is not a size such as 64MiB"},
           Row{R"({"max-bytes": true})",
               "settings.max-bytes must be a number or a string such as \"64MiB\", not boolean"},
           Row{R"({"grpc-compression": 1})", "settings.grpc-compression must be true or false, not number"},
           Row{R"({"http-listen": "8080"})", "settings.http-listen: \'8080' is not HOST:PORT"},
           Row{R"({"cors-origin": "https://a"})",
               "settings.cors-origin must be an array of strings, not string"},
           Row{R"({"cors-origin": ["https://a/path"]})",
               "settings.cors-origin: \'https://a/path' is not * or an origin"},
           Row{R"({"ports-file": "a\u0000b"})", "settings.ports-file: \'a?b' is not a path"},
           Row{R"({"log-level": "loud"})",
               "settings.log-level: \'loud' is not one of debug, info, warn, error, off"},
           Row{R"({"cors-origin": [["x"]]})", "settings.cors-origin must be an array of strings, not array"},
           Row{R"({"queue": )" + deep + "}", "settings.queue[0][0]"},
           Row{deep, "settings[0][0]"},
           Row{R"(["queue"])", "is no JSON object"},
           Row{"42", "is no JSON object"},
           Row{"", "settings is not valid: parse error at line 1"},
           Row{R"({"queue": 1} x)", "settings is not valid: parse error at line 1"},
           Row{"{\n\"queue\": 1", "settings is not valid: parse error at line 2"},
           Row{"{\"queue\xff\": 1}", "settings is not valid: parse error at line 1"},
           Row{std::string((1 << 20) + 1, ' '), "is longer than 1 MiB"},
       }) {
    const cli::TemporaryFolder folder;
    const std::string path = folder.write("c.json", row.text);
    const auto config = read(path);
    ASSERT_FALSE(config.ok()) << row.message;
    EXPECT_EQ(config.error().cause, Cause::BadOption) << row.message;
    EXPECT_TRUE(config.error().message.starts_with(path + ": " + row.message)) << config.error().message;
  }
}

TEST(ConfigFile, MustBeReadable) {
  const cli::TemporaryFolder folder;
  for (const std::string& path : {folder / "absent.json", folder / ""}) {
    const auto config = read(path);
    ASSERT_FALSE(config.ok()) << path;
    EXPECT_EQ(config.error().message, path + ": cannot be read");
  }
}

TEST(ConfigFile, TakesEverySettingBackAsItWasPrinted) {
  Config config;
  config.grpc_listen = {.host = {}, .port = 0, .path = "run/burnish.sock"};
  config.workers = 3;
  config.max_memory = 1 << 30;
  config.grpc_compression = true;
  config.cors_origins = {"*"};
  config.grace = std::chrono::seconds(5);
  config.limits.max_iterations = 9;
  const std::string printed = config_json(settings_of(config));
  const cli::TemporaryFolder folder;
  auto again = read(folder.write("c.json", printed));
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(config_json(settings_of(*again)), printed);
  EXPECT_EQ(again->limits.max_iterations, 9u);
}

TEST(ConfigFile, TheDocumentedExampleIsOne) {
  std::ifstream file(BURNISH_DOCS "/operations.md");
  std::string line, example;
  while (std::getline(file, line) && line != "```json") {
  }
  while (std::getline(file, line) && line != "```") example += line + "\n";
  ASSERT_FALSE(example.empty());
  const cli::TemporaryFolder folder;
  const auto config = read(folder.write("example.json", example));
  EXPECT_TRUE(config.ok()) << config.error().message;
}

TEST(Settings, AreDocumentedOneByOne) {
  std::ifstream file(BURNISH_DOCS "/operations.md");
  std::vector<std::string> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("| `--")) rows.push_back(line);
  }
  Config config;
  const auto settings = settings_of(config);
  EXPECT_EQ(rows.size(), settings.size());
  for (const Setting& setting : settings) {
    const std::string value = setting.value_text().empty() ? "none" : "`" + setting.value_text() + "`";
    const std::string row = "| `" + setting.flag() + "` | `" + setting.environment() + "` | " + value +
                            " | " + setting.range + " | ";
    EXPECT_EQ(std::ranges::count_if(rows, [&](const std::string& line) { return line.starts_with(row); }), 1)
        << row;
  }
}

}  // namespace
}  // namespace burnish
