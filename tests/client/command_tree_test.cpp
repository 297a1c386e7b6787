// Completion and manual, which are made from the commands as they are declared.
#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <set>

#include "core/smooth/registry.h"
#include "tests/client/cli_fixture.h"

namespace burnish::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::UnorderedElementsAre;

std::string output_of(const std::string& command) {
  std::string text;
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 4096> piece{};
  for (std::size_t got = 0; (got = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;)
    text.append(piece.data(), got);
  EXPECT_EQ(::pclose(pipe), 0) << command << text;
  return text;
}

class Completion : public CommandLine {
 protected:
  Completion() { script = folder.write("burnish.bash", burnish({"completion", "bash"}).out); }

  /// What bash offers for the last of the words, in a folder with the sample's files.
  std::set<std::string> offers(const std::vector<std::string>& words) {
    std::string line = "cd '" + (folder / "") + "' && bash -c 'source burnish.bash; COMP_WORDS=(burnish";
    for (const std::string& word : words) line += " \"" + word + "\"";
    line +=
        "); COMP_CWORD=" + std::to_string(words.size()) + "; _burnish; printf \"%s\\n\" \"${COMPREPLY[@]}\"'";
    std::istringstream out(output_of(line));
    std::set<std::string> result;
    for (std::string word; std::getline(out, word);) {
      if (!word.empty()) result.insert(word);
    }
    return result;
  }
  std::string script;
};

TEST_F(Completion, OffersCommandsOptionsAndValues) {
  EXPECT_THAT(offers({""}), IsSupersetOf({"smooth", "compare", "noise", "sample", "methods", "bench",
                                          "completion", "man", "--help"}));
  EXPECT_THAT(offers({"smo"}), UnorderedElementsAre("smooth"));
  EXPECT_THAT(offers({"smooth", "--output-fo"}), UnorderedElementsAre("--output-folder", "--output-format"));
  EXPECT_THAT(offers({"noise", "--kind", ""}), UnorderedElementsAre("gaussian", "uniform", "impulsive"));
  EXPECT_THAT(offers({"smooth", "--method", "tau"}), UnorderedElementsAre("taubin"));
  EXPECT_THAT(offers({"smooth", "--method", "taubin", "a.obj", "--set", "m"}),
              IsSupersetOf({"mu=", "max_displacement="}));
  EXPECT_THAT(offers({"smooth", "--set", "str"}), UnorderedElementsAre("strength=")) << "of the default";
  EXPECT_THAT(offers({"completion", ""}), UnorderedElementsAre("bash"));
  EXPECT_THAT(offers({"smooth", "--iterations", ""}), UnorderedElementsAre());
}

TEST_F(Completion, OffersFilesWhereFilesGo) {
  EXPECT_THAT(offers({"smooth", "n"}), UnorderedElementsAre("noisy.obj"));
  EXPECT_THAT(offers({"smooth", "noisy.obj", "--reference", "c"}), UnorderedElementsAre("clean.obj"));
  std::filesystem::create_directory(folder / "new folder");
  EXPECT_THAT(offers({"smooth", "noisy.obj", "--output-folder", "n"}), UnorderedElementsAre("new folder"));
}

TEST_F(CommandLine, RefusesShellsThatItDoesNotKnow) { EXPECT_EQ(burnish({"completion", "fish"}).code, 2); }

TEST_F(CommandLine, PrintsAManualOfEverything) {
  const Outcome done = burnish({"man"});
  ASSERT_EQ(done.code, 0) << done.err;
  for (const Method& method : methods())
    EXPECT_THAT(done.out, HasSubstr(".SS \\fB" + method.name + "\\fR\n"));
  for (const char* const part : {".SH NAME", ".SS \\fBburnish smooth\\fR", "\\-\\-output\\-folder",
                                 ".SH EXIT STATUS", "BURNISH_TOKEN", ".SH EXAMPLES"}) {
    EXPECT_THAT(done.out, HasSubstr(part));
  }
  // Requests are known ones: no sentence begins with a dot or a quote by accident.
  std::istringstream lines(done.out);
  const std::set<std::string> known = {".TH", ".SH", ".SS", ".TP", ".br", ".nf", ".fi"};
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(!line.starts_with('.') || known.contains(line.substr(0, line.find(' ')))) << line;
    EXPECT_FALSE(line.starts_with('\'')) << line;
  }
}

TEST_F(CommandLine, PrintsAManualThatMandocAccepts) {
  if (std::system("command -v mandoc >/dev/null") != 0) GTEST_SKIP() << "no mandoc";
  const std::string page = folder.write("burnish.1", burnish({"man"}).out);
  EXPECT_EQ(output_of("mandoc -T lint -W error '" + page + "' 2>&1"), "");
  EXPECT_THAT(output_of("mandoc -T html '" + page + "'"), HasSubstr("<b>--output-folder</b>"));
}

}  // namespace
}  // namespace burnish::cli
