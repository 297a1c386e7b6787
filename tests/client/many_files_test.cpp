// Many files, standard input and output, dry runs: what scripts and people do beside one file in, one out.
#include <gmock/gmock.h>

#include <algorithm>

#include "client/cli/console.h"
#include "client/cli/file_pairs.h"
#include "tests/client/cli_fixture.h"

namespace burnish::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

const std::string kBad = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";

TEST_F(CommandLine, SmoothsAFolderOfFilesAndNamesWhatFails) {
  const std::string bad = folder.write("bad.obj", kBad), out = folder / "new/out";
  const Outcome done = burnish(
      {"smooth", noisy, bad, clean, folder / "none.obj", "--output-folder", out, "--method", "taubin"});
  EXPECT_EQ(done.code, 3) << "the cause of the first that failed";
  EXPECT_THAT(done.err,
              HasSubstr("burnish: " + bad + ": index_out_of_range: face 1 uses vertex 9 of 3 (line 4)\n"));
  EXPECT_THAT(done.err, HasSubstr("burnish: " + (folder / "none.obj") + ": file_error: "));
  EXPECT_THAT(done.err, HasSubstr("burnish: index_out_of_range: 2 of 4 files failed\n"));
  EXPECT_EQ(std::count(done.out.begin(), done.out.end(), '\n'), 5) << done.out;
  EXPECT_THAT(done.out, HasSubstr("index_out_of_range\n"));
  ASSERT_EQ(burnish({"smooth", noisy, smooth, "--method", "taubin"}).code, 0);
  EXPECT_EQ(folder.read("new/out/noisy.obj"), folder.read("smooth.obj")) << "as alone";
  EXPECT_TRUE(std::filesystem::exists(out + "/clean.obj"));
  EXPECT_FALSE(std::filesystem::exists(out + "/bad.obj"));
}

TEST_F(CommandLine, SmoothsWhatAPatternMatches) {
  const Outcome done = burnish({"smooth", folder / "*.obj", "--output-folder", folder / "out", "--json",
                                "--method", "laplacian", "--output-format", "drc"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(done.err, "");
  const auto json = json_of(done.out);
  EXPECT_EQ(json["failed"], 0);
  ASSERT_EQ(json["files"].size(), 2u);
  EXPECT_EQ(json["files"][0]["in"], clean) << "by name";
  EXPECT_EQ(json["files"][1]["out"], folder / "out/noisy.drc");
  EXPECT_EQ(json["files"][1]["report"]["method"], "laplacian");
  EXPECT_THAT(folder.read("out/noisy.drc"), StartsWith("DRACO"));
}

TEST_F(CommandLine, ShowsOneLineOfProgressForManyFiles) {
  const Outcome done =
      burnish({"smooth", noisy, clean, "--output-folder", folder / "out", "--method", "laplacian"}, {}, true);
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.err, HasSubstr("[1/2] " + noisy + " smoothing"));
  EXPECT_THAT(done.err, HasSubstr("[2/2] " + clean + " "));
  EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 0) << "over itself";
}

TEST_F(CommandLine, LeavesTheRestWhenItIsStopped) {
  std::stop_source stop;
  stop.request_stop();
  const Outcome done = burnish({"smooth", noisy, clean, "--output-folder", folder / "out"}, stop.get_token());
  EXPECT_EQ(done.code, 4);
  EXPECT_THAT(done.err, HasSubstr("burnish: cancelled: 2 of 2 files were not begun\n"));
}

TEST_F(CommandLine, RefusesFoldersThatWouldLoseFiles) {
  std::filesystem::create_directory(folder / "sub");
  std::filesystem::copy_file(noisy, folder / "sub/noisy.obj");
  const std::string file = folder.write("plain", "");
  struct Row {
    std::vector<std::string> arguments;
    int code;
    std::string start;
  };
  const Row rows[] = {
      {{"smooth", noisy, folder / "sub/noisy.obj", "--output-folder", folder / "out"},
       2,
       "burnish: bad_option: '"},
      {{"smooth", noisy, "--output-folder", folder / "sub/.."}, 2, "burnish: bad_option: the result of '"},
      {{"smooth", "-", "--output-folder", folder / "out"},
       2,
       "burnish: bad_option: standard input has no name"},
      {{"smooth", noisy, "--output-folder", file}, 6, "burnish: file_error: cannot make the folder"},
      {{"smooth", folder / "*.stl", "--output-folder", folder / "out"},
       6,
       "burnish: file_error: no file matches"},
      {{"smooth", noisy, clean, "--output-folder", folder / "out", "--reference", clean},
       2,
       "burnish: bad_option: --reference"},
      {{"smooth", noisy, clean, "--output-folder", folder / "out", "--method", "sanding"},
       2,
       "burnish: " + noisy + ": unknown_method: "},
      {{"smooth", noisy, clean, smooth}, 2, "burnish: bad_option: smooth takes IN and OUT"},
      {{"smooth", noisy, "-", "--json"},
       2,
       "burnish: bad_option: standard output takes the mesh or the report"},
  };
  const std::string before = folder.read("noisy.obj");
  for (const Row& row : rows) {
    const Outcome done = burnish(row.arguments);
    const std::string call = ::testing::PrintToString(row.arguments);
    EXPECT_EQ(done.code, row.code) << call << done.err;
    EXPECT_THAT(done.err, StartsWith(row.start)) << call;
    EXPECT_EQ(folder.read("noisy.obj"), before) << call;
  }
}

TEST_F(CommandLine, ReadsAPipeAndWritesOne) {
  ASSERT_EQ(burnish({"smooth", noisy, smooth}).code, 0);
  const Outcome piped = burnish_with_input(folder.read("noisy.obj"), {"smooth", "-", "-"});
  ASSERT_EQ(piped.code, 0) << piped.err;
  EXPECT_EQ(piped.out, folder.read("smooth.obj"));
  EXPECT_THAT(piped.err, HasSubstr("errors against the input")) << "the table makes room";
  const Outcome noise = burnish_with_input(folder.read("clean.obj"), {"noise", "-", "-", "--json"});
  ASSERT_EQ(noise.code, 0) << noise.err;
  EXPECT_THAT(noise.out, StartsWith("v "));
  EXPECT_EQ(json_of(noise.err)["file"], "-");
  EXPECT_EQ(burnish_with_input("", {"smooth", "-", smooth}).code, 3) << "nothing came";
}

TEST_F(CommandLine, HasAMachineReadableFormOfEverything) {
  const auto json = [&](std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const Outcome done = burnish(arguments);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    return json_of(done.out);
  };
  EXPECT_EQ(json({"smooth", noisy, smooth})["input"]["triangles"], 1728);
  const auto written = json({"noise", clean, smooth});
  EXPECT_EQ(written["bytes"], folder.read("smooth.obj").size());
  EXPECT_EQ(json({"sample", folder / "s.drc", "--resolution", "8"})["triangles"], 768);
  EXPECT_EQ(json({"sample", folder / "s.drc", "--resolution", "8"})["format"], "drc");
  EXPECT_TRUE(json({"compare", clean, noisy}).contains("errors"));
  EXPECT_TRUE(json({"methods"}).contains("methods"));
  EXPECT_EQ(json({"smooth", noisy, "--dry-run"})["in"], noisy);
}

TEST_F(CommandLine, TellsWhatItWouldDoAndDoesNothing) {
  const std::size_t files = folder.entries();
  const Outcome table = burnish({"smooth", noisy, smooth, "--dry-run"});
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("dry run: nothing is written"));
  EXPECT_THAT(table.out, HasSubstr("would choose        learned_normals"));
  EXPECT_EQ(folder.entries(), files);
  // What it says is what the run then does.
  const auto forecast = json_of(burnish({"smooth", noisy, "--dry-run", "--json"}).out);
  const auto report = json_of(burnish({"smooth", noisy, smooth, "--json"}).out);
  EXPECT_EQ(forecast["choice"]["method"], report["choice"]["method"]);
  EXPECT_EQ(forecast["choice"]["parameters"], report["choice"]["parameters"]);
  EXPECT_EQ(forecast["noise"], report["noise"]);
  EXPECT_EQ(forecast["input"], report["input"]);
  EXPECT_THAT(report["choice"]["reason"].get<std::string>(),
              StartsWith(forecast["choice"]["reason"].get<std::string>()));
  EXPECT_GT(forecast["estimate"]["smoothSeconds"].get<double>(), 0);
  EXPECT_GT(forecast["estimate"]["memoryBytes"].get<double>(), 1e5);
  const auto taubin = json_of(
      burnish({"smooth", noisy, "--dry-run", "--json", "--method", "taubin", "--iterations", "7"}).out);
  EXPECT_EQ(taubin["parameters"]["iterations"], 7);
  EXPECT_FALSE(taubin.contains("choice"));
  const std::string fine = folder / "fine.obj";
  ASSERT_EQ(burnish({"sample", fine, "--amplitude", "0"}).code, 0);
  const auto still = json_of(burnish({"smooth", fine, "--dry-run", "--json"}).out);
  EXPECT_EQ(still["choice"]["parameters"]["iterations"], 0);
  EXPECT_EQ(
      json_of(burnish({"smooth", noisy, clean, "--output-folder", folder / "o", "--dry-run", "--json"}).out)
          .size(),
      2u);
  EXPECT_EQ(burnish({"smooth", folder / "none.obj", "--dry-run"}).code, 6);
  EXPECT_EQ(burnish({"smooth", noisy, "--dry-run", "--set", "strength=9"}).code, 2);
}

TEST(PrintError, IsRedOnlyWhereColoursAre) {
  std::ostringstream out, plain, red;
  print_error({.out = out, .err = plain}, {Cause::EmptyMesh, "no bytes"}, "a.obj: ");
  EXPECT_EQ(plain.str(), "burnish: a.obj: empty_mesh: no bytes\n");
  print_error({.out = out, .err = red, .colors = true}, {Cause::EmptyMesh, "no bytes"});
  EXPECT_EQ(red.str(), "\x1b[31mburnish:\x1b[0m empty_mesh: no bytes\n");
}

TEST(ProcessConsole, IsPlainWhereNobodyLooks) {
  const Variable no_color("NO_COLOR", "1");
  EXPECT_FALSE(process_console({}).colors);
  const Variable dumb("TERM", "dumb");
  EXPECT_FALSE(process_console({}).err_is_terminal);
}

}  // namespace
}  // namespace burnish::cli
