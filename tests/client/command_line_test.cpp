#include "client/cli/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "core/smooth/registry.h"
#include "tests/client/cli_fixture.h"
#include "tests/client/fake_server.h"

namespace burnish::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST_F(CommandLine, SmoothsTheSampleTowardsItsReference) {
  const Outcome done =
      burnish({"smooth", noisy, smooth, "--reference", clean, "--report", folder / "r.json"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("errors against the reference"));
  const auto before = json_of(burnish({"compare", clean, noisy, "--json"}).out);
  const auto after = json_of(burnish({"compare", clean, smooth, "--json"}).out);
  const double ev = after["errors"]["ev"].get<double>();
  EXPECT_LT(ev, before["errors"]["ev"].get<double>());
  EXPECT_NEAR(json_of(folder.read("r.json"))["errors"]["ev"].get<double>(), ev, 1e-3 * ev);
}

TEST_F(CommandLine, PrintsOnlyJsonWhenTheReportGoesToStandardOutput) {
  const Outcome done = burnish({"smooth", noisy, smooth, "--report", "-"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(json_of(done.out)["method"], methods().front().name);
  EXPECT_THAT(done.err, HasSubstr("errors against the input"));
}

TEST_F(CommandLine, TakesParametersByName) {
  const Outcome done = burnish({"smooth", noisy, smooth, "--method", "taubin", "--iterations", "3", "--set",
                                "boundary=free", "--set", "lambda=0.25", "--report", "-"});
  ASSERT_EQ(done.code, 0) << done.err;
  const auto parameters = json_of(done.out)["parameters"];
  EXPECT_EQ(parameters["iterations"], 3);
  EXPECT_EQ(parameters["boundary"], "free");
  EXPECT_EQ(parameters["lambda"], 0.25);
}

TEST_F(CommandLine, PinsVerticesByNumberGroupAndAttribute) {
  const auto pinned = [&](const std::string& in, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"smooth", in, smooth, "--report", "-"});
    const Outcome done = burnish(arguments);
    EXPECT_EQ(done.code, 0) << done.err;
    return json_of(done.out)["pinnedVertices"].get<int>();
  };
  // A tetrahedron whose first two vertices are red and whose first face is in a group.
  const std::string obj = folder.write("small.obj",
                                       "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 0 0\nv 0 0 1 0 0 0\n"
                                       "g base\nf 1 3 2\ng\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const std::string drc = folder / "small.drc";
  EXPECT_EQ(pinned(obj, {}), 0);
  EXPECT_EQ(pinned(obj, {"--pin", "0,3"}), 2);
  EXPECT_EQ(pinned(obj, {"--pin", "0", "--pin", "3,2"}), 3);
  EXPECT_EQ(pinned(obj, {"--pin-group", "base"}), 3);
  EXPECT_EQ(pinned(obj, {"--pin-group", "base", "--pin", "3"}), 4);
  EXPECT_EQ(folder.read("smooth.obj"), folder.read("small.obj")) << "all four stay";
  ASSERT_EQ(burnish({"smooth", obj, drc, "--iterations", "0"}).code, 0);
  EXPECT_EQ(pinned(drc, {"--pin-attribute", "1"}), 2);
}

TEST_F(CommandLine, WritesTheFormatOfTheName) {
  const std::string drc = folder / "smooth.drc";
  ASSERT_EQ(burnish({"smooth", noisy, drc, "--position-bits", "14"}).code, 0);
  EXPECT_THAT(folder.read("smooth.drc"), StartsWith("DRACO"));
  ASSERT_EQ(burnish({"smooth", drc, smooth, "--output-format", "drc"}).code, 0);
  EXPECT_THAT(folder.read("smooth.obj"), StartsWith("DRACO"));
}

TEST_F(CommandLine, GivesTheSameNoiseForASeed) {
  const auto noise = [&](const std::string& name, const std::string& seed) {
    const Outcome done = burnish({"noise", clean, folder / name, "--amplitude", "0.4", "--kind", "uniform",
                                  "--direction", "random", "--seed", seed});
    EXPECT_EQ(done.code, 0) << done.err;
    return folder.read(name);
  };
  EXPECT_EQ(noise("a.obj", "5"), noise("b.obj", "5"));
  EXPECT_NE(noise("a.obj", "5"), noise("b.obj", "6"));
}

TEST_F(CommandLine, ExitsByCause) {
  const std::string bad = folder.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  struct Row {
    std::vector<std::string> arguments;
    int code;
    const char* start;
  };
  const Row rows[] = {
      {{}, 2, "burnish: bad_option: "},
      {{"polish"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--iterations", "many"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--server", "h:1", "--local"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--method", "sanding"}, 2, "burnish: unknown_method: "},
      {{"smooth", noisy, smooth, "--set", "colour=3"}, 2, "burnish: unknown_option: "},
      {{"smooth", noisy, smooth, "--set", "lambda"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--set", "boundary=3", "--set", "boundary=free"},
       2,
       "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--set", "boundary=open"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--pin", "1,-2"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--pin", "0,1000000"},
       2,
       "burnish: bad_option: pinned.vertices[1] is 1000000"},
      {{"smooth", noisy, smooth, "--pin-group", ""}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--pin-group", "a"}, 2, "burnish: bad_option: the mesh has no group \"a\""},
      {{"smooth", noisy, smooth, "--pin-attribute", "7"}, 2, "burnish: bad_option: an OBJ has no attributes"},
      {{"noise", noisy, smooth, "--kind", "pink"}, 2, "burnish: bad_option: "},
      {{"noise", noisy, smooth, "--amplitude", "1000"}, 2, "burnish: bad_option: "},
      {{"sample", smooth, "--resolution", "2"}, 2, "burnish: bad_option: "},
      {{"smooth", bad, smooth}, 3, "burnish: index_out_of_range: "},
      {{"noise", bad, smooth}, 3, "burnish: index_out_of_range: "},
      {{"compare", bad, noisy}, 3, "burnish: index_out_of_range: "},
      {{"smooth", noisy, smooth, "--reference", folder.write("none.obj", "")}, 3, "burnish: empty_mesh: "},
      {{"smooth", noisy, smooth, "--retries", "2"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--server", "h:1", "--retries", "-1"}, 2, "burnish: bad_option: "},
      {{"smooth", noisy, smooth, "--server", "127.0.0.1:1", "--retries", "0"}, 5, "burnish: unreachable: "},
      {{"compare", clean, noisy, "--server", "127.0.0.1:1", "--retries", "0"}, 5, "burnish: unreachable: "},
      {{"smooth", folder / "missing.obj", smooth}, 6, "burnish: file_error: "},
      {{"smooth", noisy, folder / "no/where.obj"}, 6, "burnish: file_error: "},
      {{"smooth", noisy, smooth, "--report", folder / "no/where.json"}, 6, "burnish: file_error: "},
  };
  for (const Row& row : rows) {
    const Outcome done = burnish(row.arguments);
    const std::string call = ::testing::PrintToString(row.arguments);
    EXPECT_EQ(done.code, row.code) << call << done.err;
    EXPECT_THAT(done.err, StartsWith(row.start)) << call;
    EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 1) << call << done.err;
    EXPECT_EQ(done.out, "") << call;
    EXPECT_FALSE(std::filesystem::exists(smooth)) << call;
  }
}

TEST_F(CommandLine, LeavesTheOldFileWhenItFails) {
  folder.write("smooth.obj", "old");
  std::stop_source stop;
  stop.request_stop();
  const Outcome stopped = burnish({"smooth", noisy, smooth}, stop.get_token());
  EXPECT_EQ(stopped.code, 4);
  EXPECT_THAT(stopped.err, StartsWith("burnish: cancelled: "));
  EXPECT_EQ(folder.read("smooth.obj"), "old");
  EXPECT_EQ(folder.entries(), 3u);
}

TEST_F(CommandLine, GivesUpAtItsTimeout) {
  const Outcome late = burnish(
      {"smooth", noisy, smooth, "--method", "laplacian", "--iterations", "100000", "--timeout", "0.05"});
  EXPECT_EQ(late.code, 4);
  EXPECT_THAT(late.err, StartsWith("burnish: deadline_exceeded: "));
}

TEST_F(CommandLine, ComparesMeshesOfAnyConnectivity) {
  const std::string coarse = folder / "coarse.obj";
  ASSERT_EQ(burnish({"sample", coarse, "--resolution", "8", "--amplitude", "0"}).code, 0);
  const Outcome table = burnish({"compare", clean, coarse});
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("1728 triangles"));
  EXPECT_THAT(table.out, HasSubstr("768 triangles"));
  EXPECT_THAT(table.out, HasSubstr("errors against the reference"));
  EXPECT_THAT(table.out, HasSubstr("connectivity_differs"));
  const auto json = json_of(burnish({"compare", clean, coarse, "--json"}).out);
  EXPECT_EQ(json["reference"]["triangles"], 1728);
  EXPECT_EQ(json["mesh"]["triangles"], 768);
}

TEST_F(CommandLine, ShowsTheServersProgressOnATerminal) {
  const client::FakeServer server({.smooth = client::echo, .smooth_stream = [](auto&, auto& stream) {
                                     client::receive(stream);
                                     client::send_progress(stream, v1::SMOOTH_STAGE_QUEUE);
                                     client::send_progress(stream, v1::SMOOTH_STAGE_SMOOTH, 0.42);
                                     client::send_chunk(stream, "smoothed");
                                     client::send_report(stream, "by stream");
                                     return grpc::Status::OK;
                                   }});
  const std::vector<std::string> call = {"smooth", noisy, smooth, "--server", server.address()};
  const Outcome shown = burnish(call, {}, true);
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.err, HasSubstr("waiting ..."));
  EXPECT_THAT(shown.err, HasSubstr("smoothing [################........................] 42%"));
  EXPECT_THAT(shown.err, ::testing::EndsWith("\r\x1b[K"));
  EXPECT_THAT(shown.out, HasSubstr("by stream"));
  EXPECT_EQ(folder.read("smooth.obj"), "smoothed");
  const Outcome silent = burnish(call);
  EXPECT_EQ(silent.err, "");
}

TEST_F(CommandLine, ShowsItsOwnProgressOnATerminal) {
  const Outcome shown = burnish({"smooth", noisy, smooth}, {}, true);
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.err, HasSubstr("smoothing ["));
  EXPECT_THAT(shown.err, HasSubstr("measuring ..."));
}

TEST_F(CommandLine, TriesAgainAsOftenAsItIsTold) {
  std::atomic<int> calls = 0;
  const client::FakeServer server({.compare = [&](const auto&, auto& response) {
    if (++calls < 3) return client::queue_full();
    response.set_request_id("third");
    return grpc::Status::OK;
  }});
  const auto compare = [&](const char* retries) {
    calls = 0;
    return burnish({"compare", clean, noisy, "--json", "--server", server.address(), "--retries", retries});
  };
  const Outcome early = compare("1");
  EXPECT_EQ(early.code, 4);
  EXPECT_THAT(early.err, StartsWith("burnish: queue_full: "));
  EXPECT_THAT(early.err, HasSubstr("2 attempts"));
  const Outcome done = compare("2");
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(json_of(done.out)["requestId"], "third");
}

TEST(CommandLineHelp, ListsEveryMethodAndParameter) {
  const std::string help = burnish({"smooth", "--help"}).out;
  const std::string list = burnish({"methods"}).out;
  for (const Method& method : methods()) {
    EXPECT_THAT(help, HasSubstr("\n" + method.name));
    EXPECT_THAT(list, HasSubstr(method.reference));
    for (const ParameterSpec& spec : method.parameters) {
      EXPECT_THAT(help, HasSubstr(spec.name + "="));
      EXPECT_THAT(list, HasSubstr(spec.text));
    }
  }
}

TEST(CommandLineHelp, ListsMethodsAsJsonAndMarkdown) {
  const auto list = json_of(burnish({"methods", "--json"}).out)["methods"];
  ASSERT_EQ(list.size(), methods().size());
  EXPECT_EQ(list[0]["name"], methods().front().name);
  EXPECT_EQ(burnish({"methods", "--markdown"}).out, methods_markdown());
}

TEST(CommandLineHelp, TellsItsVersion) {
  const Outcome done = burnish({"--version"});
  EXPECT_EQ(done.code, 0);
  EXPECT_THAT(done.out, StartsWith("burnish "));
}

}  // namespace
}  // namespace burnish::cli
