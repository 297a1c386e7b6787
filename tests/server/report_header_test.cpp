#include "server/http/report_header.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace burnish {
namespace {

using nlohmann::json;

TEST(ReportHeader, IsAsciiAndKeepsEverythingThatFits) {
  v1::SmoothReport report;
  report.set_method("adaptive");
  auto* warning = report.add_warnings();
  warning->set_code("non_manifold_edges");
  warning->set_message("group 'K\xc3\xbchler'");
  const std::string header = report_header(report);
  EXPECT_TRUE(std::ranges::all_of(header, [](char c) { return c >= ' ' && c <= '~'; })) << header;
  EXPECT_EQ(json::parse(header)["warnings"][0]["message"], warning->message());
  EXPECT_EQ(json::parse(header)["change"], nullptr) << "an unset message is not printed as zeros";
}

TEST(ReportHeader, CutsTheLastWarningsFirst) {
  v1::SmoothReport report;
  report.set_method("adaptive");
  (*report.mutable_parameters())["sigma"].set_number_value(0.2);
  for (int i = 0; i < 100; ++i) {
    report.add_warnings()->set_code("warning_" + std::to_string(i));
    report.mutable_warnings(i)->set_message(std::string(200, 'x'));
  }
  const std::string header = report_header(report);
  EXPECT_LE(header.size(), kLongestReportHeader);
  const json kept = json::parse(header);
  EXPECT_GT(kept["warnings"].size(), 5u);
  EXPECT_EQ(kept["warnings"][0]["code"], "warning_0");
  EXPECT_EQ(kept["parameters"]["sigma"], 0.2);
}

TEST(ReportHeader, CutsTheParametersWhenThatIsNotEnough) {
  v1::SmoothReport report;
  (*report.mutable_parameters())["name"].set_string_value(std::string(5000, 'x'));
  report.set_method("adaptive");
  EXPECT_LE(report_header(report).size(), kLongestReportHeader);
  EXPECT_EQ(json::parse(report_header(report))["method"], "adaptive");
}

}  // namespace
}  // namespace burnish
