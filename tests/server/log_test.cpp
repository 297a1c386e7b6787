#include "server/observe/log.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <algorithm>

namespace burnish {
namespace {

/// What the log writes during `act`.
template <class Act>
std::string logged(const std::string& level, Act act) {
  const auto before = spdlog::default_logger();
  ::testing::internal::CaptureStderr();
  set_up_log(level);
  act();
  spdlog::default_logger()->flush();
  std::string text = ::testing::internal::GetCapturedStderr();
  spdlog::set_default_logger(before);
  return text;
}

TEST(Log, StaysOneLineOfPrintableText) {
  const std::string text = logged("info", [] {
    spdlog::info("detail={}", "one\ntwo\r\x1b[31m\xc3\xa9 end");
    spdlog::warn("{}", std::string(100'000, 'x'));
  });
  EXPECT_EQ(std::ranges::count(text, '\n'), 2) << text;
  EXPECT_TRUE(std::ranges::all_of(text, [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); })) << text;
  EXPECT_NE(text.find("Z info detail=one?two??[31m?? end\n"), std::string::npos) << text;
  EXPECT_LT(text.size(), 10'000u);
}

TEST(Log, KeepsWhatIsBelowItsLevelToItself) {
  const std::string text = logged("warn", [] {
    spdlog::info("quiet");
    spdlog::warn("loud");
  });
  EXPECT_EQ(text.find("quiet"), std::string::npos);
  EXPECT_NE(text.find("Z warning loud\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace burnish
