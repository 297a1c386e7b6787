#include "client/cli/report_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "client/cli/progress_bar.h"

namespace burnish::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string table_of(const v1::SmoothReport& report) {
  std::ostringstream out;
  print_report(out, report);
  return out.str();
}

v1::SmoothReport sample_report() {
  v1::SmoothReport report;
  report.set_method("taubin");
  (*report.mutable_parameters())["lambda"].set_number_value(0.5);
  (*report.mutable_parameters())["boundary"].set_string_value("fixed");
  report.mutable_errors()->set_against("reference");
  report.mutable_errors()->set_ev_over_edge(0.1034);
  report.mutable_input()->set_vertices(6475);
  return report;
}

TEST(PrintReport, ShowsWhatWasMeasured) {
  const std::string table = table_of(sample_report());
  EXPECT_THAT(table, HasSubstr("taubin"));
  EXPECT_THAT(table, HasSubstr("boundary fixed, lambda 0.5"));
  EXPECT_THAT(table, HasSubstr("errors against the reference"));
  EXPECT_THAT(table, HasSubstr("0.1034 mean edges"));
  EXPECT_THAT(table, HasSubstr("6475 vertices"));
}

TEST(PrintReport, LeavesOutWhatWasNot) {
  EXPECT_THAT(table_of(sample_report()), Not(HasSubstr("normals")));
  EXPECT_THAT(table_of(sample_report()), Not(HasSubstr("warnings")));
}

TEST(PrintReport, SaysHowNoisyTheInputIs) {
  v1::SmoothReport report = sample_report();
  EXPECT_THAT(table_of(report), Not(HasSubstr("noise")));
  report.mutable_noise()->set_sigma_over_edge(0.21);
  report.mutable_noise()->set_kind("gaussian");
  EXPECT_THAT(table_of(report), HasSubstr("noise               gaussian, 0.21 mean edges\n"));
}

TEST(PrintReport, CountsPinnedVerticesWhenThereAreAny) {
  v1::SmoothReport report = sample_report();
  EXPECT_THAT(table_of(report), Not(HasSubstr("pinned")));
  report.set_pinned_vertices(12);
  EXPECT_THAT(table_of(report), HasSubstr("pinned              12 vertices\n"));
}

TEST(PrintReport, ShowsEveryWarning) {
  v1::SmoothReport report = sample_report();
  v1::ReportWarning* warning = report.add_warnings();
  warning->set_code("boundary");
  warning->set_message("the mesh is open at vertex 3");
  warning->set_count(12);
  EXPECT_THAT(table_of(report), HasSubstr("the mesh is open at vertex 3 (12)"));
}

TEST(PrintComparison, ShowsBothMeshesAndTheErrors) {
  v1::CompareResponse comparison;
  comparison.mutable_reference()->set_vertices(11);
  comparison.mutable_mesh()->set_triangles(22);
  comparison.mutable_errors()->set_against("reference");
  comparison.mutable_errors()->set_ev_over_edge(0.1034);
  comparison.add_warnings()->set_message("the connectivity differs");
  std::ostringstream out;
  print_comparison(out, comparison);
  for (const char* part : {"11 vertices", "22 triangles", "errors against the reference", "0.1034 mean edges",
                           "the connectivity differs"}) {
    EXPECT_THAT(out.str(), HasSubstr(part));
  }
}

TEST(ProgressBar, DrawsEachPercentOnceAndWipesItself) {
  std::ostringstream terminal;
  {
    ProgressBar bar(terminal);
    for (int i = 0; i <= 500; ++i) bar.show(v1::SMOOTH_STAGE_SMOOTH, i / 1000.0);
    EXPECT_THAT(terminal.str(), HasSubstr("smoothing [####################....................] 50%"));
    EXPECT_LT(terminal.str().size(), 70u * 51);
    bar.show(v1::SMOOTH_STAGE_SMOOTH, 2);
    EXPECT_THAT(terminal.str(), HasSubstr("100%"));
  }
  EXPECT_THAT(terminal.str(), testing::EndsWith("\r\x1b[K"));
}

TEST(ProgressBar, NamesTheStagesThatDoNotTell) {
  std::ostringstream terminal;
  ProgressBar bar(terminal);
  bar.show(v1::SMOOTH_STAGE_QUEUE, 0);
  bar.show(v1::SMOOTH_STAGE_QUEUE, 0);
  EXPECT_EQ(terminal.str(), "\r\x1b[Kwaiting ...");
  bar.show(v1::SMOOTH_STAGE_MEASURE, 0);
  EXPECT_THAT(terminal.str(), testing::EndsWith("\r\x1b[Kmeasuring ..."));
}

TEST(ProgressBar, StaysSilentWhenNothingWasShown) {
  std::ostringstream terminal;
  { const ProgressBar bar(terminal); }
  EXPECT_EQ(terminal.str(), "");
}

}  // namespace
}  // namespace burnish::cli
