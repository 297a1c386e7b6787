#include "client/cli/preferences.h"

#include <gmock/gmock.h>

#include <mutex>
#include <utility>

#include "tests/client/cli_fixture.h"
#include "tests/client/fake_server.h"

namespace burnish::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Settings where the program looks for them.
class Preferences : public CommandLine {
 protected:
  Preferences() { std::filesystem::create_directories(folder / "settings/burnish"); }
  std::string usual(const std::string& json) { return folder.write("settings/burnish/config.json", json); }
  /// The method and iterations of a call with these words more.
  std::string method(std::vector<std::string> more) {
    more.insert(more.begin(), {"smooth", noisy, smooth, "--json"});
    const Outcome done = burnish(more);
    return done.code == 0 ? json_of(done.out)["method"].get<std::string>() : done.err;
  }
};

TEST_F(Preferences, StandBelowEnvironmentAndFlags) {
  EXPECT_EQ(method({}), "auto");
  usual(R"({"method": "taubin"})");
  EXPECT_EQ(method({}), "taubin");
  const std::string other = folder.write("other.json", R"({"method": "adaptive"})");
  EXPECT_EQ(method({"--config", other}), "adaptive");
  {
    const Variable config("BURNISH_CONFIG", other);
    EXPECT_EQ(method({}), "adaptive");
    const Variable name("BURNISH_METHOD", "hc_laplacian");
    EXPECT_EQ(method({}), "hc_laplacian");
    EXPECT_EQ(method({"--method", "laplacian"}), "laplacian");
  }
  EXPECT_EQ(burnish({"--config", other, "smooth", noisy, smooth}).code, 0) << "before the command as well";
}

TEST_F(Preferences, AreStrict) {
  struct Row {
    const char* json;
    const char* message;
  };
  const Row rows[] = {
      {"", "settings"},
      {"[]", "is no JSON object"},
      {R"({"method": "taubin")", "settings"},
      {R"({"colour": "red"})", "settings.colour is no setting"},
      {R"({"method": 3})", "settings.method must be a string, not number"},
      {R"({"threads": "2"})", "settings.threads must be a number, not string"},
      {R"({"method": "taubin", "method": "auto"})", "settings.method"},
      {R"({"timeout": -1})", "settings.timeout"},
      {R"({"threads": 1.5})", "settings.threads"},
      {R"({"method": null})", "settings.method"},
  };
  for (const Row& row : rows) {
    const std::string path = usual(row.json);
    const Outcome done = burnish({"smooth", noisy, smooth});
    EXPECT_EQ(done.code, 2) << row.json << done.err;
    EXPECT_THAT(done.err, StartsWith("burnish: bad_option: " + path + ": ")) << row.json;
    EXPECT_THAT(done.err, HasSubstr(row.message)) << row.json;
  }
  std::filesystem::remove(folder / "settings/burnish/config.json");
  EXPECT_THAT(method({"--config", folder / "none.json"}), HasSubstr("none.json: is no file"));
  const Variable wrong("BURNISH_TIMEOUT", "soon");
  EXPECT_THAT(method({}), StartsWith("burnish: bad_option: BURNISH_TIMEOUT: "));
}

TEST_F(Preferences, NameTheServerAndItsToken) {
  std::mutex mutex;
  std::string last = "nobody asked";
  const auto token = [&] {
    const std::lock_guard lock(mutex);
    return std::exchange(last, "nobody asked");
  };
  const client::FakeServer server(
      {.smooth = [&](grpc::ServerContext& context, const auto& request, auto& response) {
        const std::lock_guard lock(mutex);
        const auto found = context.client_metadata().find("authorization");
        if (found != context.client_metadata().end()) last.assign(found->second.data(), found->second.size());
        response.set_mesh(request.mesh());
        response.mutable_report()->set_method(request.options().method());
        return grpc::Status::OK;
      }});
  const std::string file = folder.write("token", "first-token\n");
  usual(R"({"server": ")" + server.address() + R"(", "method": "taubin", "threads": 2, "token-file": ")" +
        file + R"("})");
  EXPECT_EQ(method({}), "taubin");
  EXPECT_EQ(token(), "Bearer first-token");
  const Variable variable("BURNISH_TOKEN", "second-token");
  EXPECT_EQ(method({}), "taubin");
  EXPECT_EQ(token(), "Bearer second-token") << "the environment goes before the file";
  EXPECT_EQ(method({"--token-file", folder.write("other", "third-token")}), "taubin");
  EXPECT_EQ(token(), "Bearer third-token");
  EXPECT_EQ(method({"--local"}), "taubin");
  EXPECT_EQ(method({"--threads", "1"}), "taubin") << "threads are of the local mode";
  EXPECT_EQ(token(), "nobody asked");
  EXPECT_THAT(method({"--token-file", folder.write("two", "a b")}), HasSubstr("must hold one token"));
}

TEST(DefaultPreferencesFile, IsWhereOthersAre) {
  const Variable home("HOME", "/home/somebody"), folder("XDG_CONFIG_HOME", "");
  EXPECT_EQ(default_preferences_file(), "/home/somebody/.config/burnish/config.json");
  const Variable elsewhere("XDG_CONFIG_HOME", "/etc/somebody");
  EXPECT_EQ(default_preferences_file(), "/etc/somebody/burnish/config.json");
}

}  // namespace
}  // namespace burnish::cli
