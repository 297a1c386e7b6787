#include "core/smooth/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace burnish {
namespace {

using ::testing::HasSubstr;

TEST(Registry, SaysRoughlyHowLongARunTakes) {
  for (const Method& method : methods()) EXPECT_GT(method.nanoseconds, 0) << method.name;
  EXPECT_DOUBLE_EQ(seconds_of("laplacian", 2000, 30.0), 30 * seconds_of("laplacian", 2000, 1.0));
  EXPECT_DOUBLE_EQ(seconds_of("laplacian", 2000, {}), seconds_of("laplacian", 2000, 20.0));
  EXPECT_DOUBLE_EQ(seconds_of("learned_normals", 2000, {}), seconds_of("learned_normals", 2000, 3.0));
  EXPECT_GT(seconds_of("", 2000, {}), seconds_of("laplacian", 2000, {}));
  EXPECT_EQ(seconds_of("no such method", 2000, {}), 0);
}

TEST(Registry, OffersAutoFirst) {
  EXPECT_EQ(methods().front().name, "auto");
  EXPECT_EQ((*find_method(""))->name, "auto");
  for (const char* name : {"adaptive", "laplacian", "taubin", "mean_curvature_flow"})
    EXPECT_TRUE(find_method(name)) << name;
}

TEST(Registry, DescribesEveryMethodAndParameterCompletely) {
  std::set<std::string> names;
  for (const Method& method : methods()) {
    EXPECT_TRUE(names.insert(method.name).second);
    EXPECT_FALSE(method.summary.empty() || method.reference.empty() || method.formula.empty()) << method.name;
    std::set<std::string> parameters;
    for (const ParameterSpec& spec : method.parameters) {
      EXPECT_TRUE(parameters.insert(spec.name).second) << method.name << ' ' << spec.name;
      EXPECT_FALSE(spec.text.empty()) << spec.name;
      if (spec.kind == ParameterKind::Choice) {
        EXPECT_GE(spec.choices.size(), 2U) << spec.name;
      } else {
        EXPECT_LT(spec.minimum, spec.maximum) << spec.name;
        EXPECT_FALSE(spec.unit.empty()) << spec.name;
      }
    }
    for (const char* common : {"iterations", "boundary", "max_displacement", "max_displacement_unit"}) {
      EXPECT_TRUE(parameters.contains(common)) << method.name << ' ' << common;
    }
    const auto defaults = resolve_parameters(method, {});
    ASSERT_TRUE(defaults);
    EXPECT_TRUE(resolve_parameters(method, defaults->values)) << "defaults must be in range";
    EXPECT_GE(defaults->integer("iterations"), 1);
    EXPECT_LE(defaults->integer("iterations"), 20);
  }
}

TEST(Registry, NamesTheMethodsThatExist) {
  const auto missing = find_method("laplace");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().cause, Cause::UnknownMethod);
  EXPECT_THAT(missing.error().message, HasSubstr("adaptive, laplacian, taubin, mean_curvature_flow"));
}

TEST(ResolveParameters, RefusesWhatIsWrongAndNamesIt) {
  const Method& taubin = **find_method("taubin");
  struct Row {
    const char* name;
    ParameterValue value;
    Cause cause;
  };
  for (const Row& row : {
           Row{"lambda", 1.01, Cause::BadOption},
           Row{"lambda", -0.1, Cause::BadOption},
           Row{"lambda", std::numeric_limits<double>::quiet_NaN(), Cause::BadOption},
           Row{"lambda", std::string("0.5"), Cause::BadOption},
           Row{"iterations", 2.5, Cause::BadOption},
           Row{"iterations", -1.0, Cause::BadOption},
           Row{"iterations", 1e18, Cause::BadOption},
           Row{"boundary", std::string("fixd"), Cause::BadOption},
           Row{"boundary", 1.0, Cause::BadOption},
           Row{"sigma", 1.0, Cause::UnknownOption},
       }) {
    const auto result = resolve_parameters(taubin, {{row.name, row.value}});
    ASSERT_FALSE(result) << row.name;
    EXPECT_EQ(result.error().cause, row.cause) << row.name;
    EXPECT_EQ(result.error().field, row.name);
    EXPECT_THAT(result.error().message, HasSubstr(row.name));
  }
}

TEST(ResolveParameters, TakesWholeDoublesAsIntegers) {
  const auto values =
      resolve_parameters(**find_method("taubin"), {{"iterations", 7.0}, {"lambda", std::int64_t{1}}});
  ASSERT_TRUE(values);
  EXPECT_EQ(values->integer("iterations"), 7);
  EXPECT_EQ(values->number("lambda"), 1.0);
  EXPECT_EQ(values->number("mu"), -0.53);
}

TEST(ParseParameter, ReadsTextByTheParametersKind) {
  const Method& taubin = **find_method("taubin");
  EXPECT_EQ(*parse_parameter(taubin, "lambda", "0.25"), ParameterValue(0.25));
  EXPECT_EQ(*parse_parameter(taubin, "iterations", "12"), ParameterValue(std::int64_t{12}));
  EXPECT_EQ(*parse_parameter(taubin, "boundary", "free"), ParameterValue(std::string("free")));
  for (const char* bad : {"", "x", "0.5x", " 0.5", "1e999", "nan", "inf", "2"}) {
    EXPECT_FALSE(parse_parameter(taubin, "lambda", bad)) << bad;
  }
  EXPECT_EQ(parse_parameter(taubin, "sigma", "1").error().cause, Cause::UnknownOption);
}

}  // namespace
}  // namespace burnish
