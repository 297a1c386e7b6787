// Calls of the command line in this process.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "client/cli/command_line.h"
#include "tests/client/environment.h"
#include "tests/client/temporary_folder.h"

namespace burnish::cli {

struct Outcome {
  int code;
  std::string out, err;
};

inline Outcome burnish_with_input(const std::string& input, const std::vector<std::string>& arguments,
                                  const std::stop_token& stop = {}, bool terminal = false) {
  std::vector<const char*> argv = {"burnish"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::istringstream in(input);
  std::ostringstream out, err;
  const int code =
      run_command_line(static_cast<int>(argv.size()), argv.data(), {out, err, terminal, stop, in});
  return {code, out.str(), err.str()};
}

inline Outcome burnish(const std::vector<std::string>& arguments, const std::stop_token& stop = {},
                       bool terminal = false) {
  return burnish_with_input("", arguments, stop, terminal);
}

inline nlohmann::json json_of(const std::string& text) { return nlohmann::json::parse(text, nullptr, false); }

/// A folder with a small noisy sample and its reference; nobody's own settings count.
class CommandLine : public ::testing::Test {
 protected:
  CommandLine() {
    EXPECT_EQ(burnish({"sample", noisy, "--resolution", "12"}).code, 0);
    EXPECT_EQ(burnish({"sample", clean, "--resolution", "12", "--amplitude", "0"}).code, 0);
  }
  TemporaryFolder folder;
  Variable settings{"XDG_CONFIG_HOME", folder / "settings"};
  std::string noisy = folder / "noisy.obj", clean = folder / "clean.obj", smooth = folder / "smooth.obj";
};

}  // namespace burnish::cli
