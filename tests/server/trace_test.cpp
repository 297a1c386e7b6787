#include "server/observe/trace.h"

#include <gtest/gtest.h>

namespace burnish {
namespace {

const std::string kTrace = "4bf92f3577b34da6a3ce929d0e0e4736", kParent = "00f067aa0ba902b7";

TEST(Trace, ReadsTheTraceId) {
  EXPECT_EQ(trace_id_of("00-" + kTrace + "-" + kParent + "-01"), kTrace);
  EXPECT_EQ(trace_id_of("00-" + kTrace + "-" + kParent + "-00"), kTrace);
  EXPECT_EQ(trace_id_of("cc-" + kTrace + "-" + kParent + "-01-from-the-future"), kTrace);
}

TEST(Trace, IgnoresWhatIsMalformed) {
  const std::string good = "00-" + kTrace + "-" + kParent + "-01";
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_EQ(trace_id_of(good.substr(0, length)), "");
    std::string mutant = good;
    mutant[length] = 'G';
    EXPECT_EQ(trace_id_of(mutant), "") << mutant;
  }
  for (const std::string& bad : {"ff" + good.substr(2), good + "-more", "cc" + good.substr(2) + "more",
                                 "00-" + std::string(32, '0') + "-" + kParent + "-01",
                                 "00-" + kTrace + "-" + std::string(16, '0') + "-01",
                                 "00-4BF92F3577B34DA6A3CE929D0E0E4736-" + kParent + "-01", " " + good}) {
    EXPECT_EQ(trace_id_of(bad), "") << bad;
  }
}

}  // namespace
}  // namespace burnish
