#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "server/service/options.h"
#include "server/service/smooth_service.h"
#include "server/status_map.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using ::testing::HasSubstr;
using namespace burnish::testing;

const std::string& noisy() {
  static const std::string kMesh = to_obj(with_noise(sphere(3), 0.02));
  return kMesh;
}
const std::string& clean() {
  static const std::string kMesh = to_obj(sphere(3));
  return kMesh;
}

Result<SmoothResult> smooth(const SmoothJob& job, const RequestLimits& limits = {}) {
  return SmoothService(limits).smooth(job, {});
}

Result<v1::CompareResponse> compare(const CompareJob& job) { return SmoothService().compare(job, {}); }

std::vector<std::string> codes(const v1::SmoothReport& report) {
  std::vector<std::string> result;
  for (const auto& warning : report.warnings()) result.push_back(warning.code());
  return result;
}

TEST(SmoothService, ReportsWhatItDid) {
  const auto result = smooth({.mesh = noisy(), .request_id = "r1", .queue_ms = 12});
  ASSERT_TRUE(result);
  const v1::SmoothReport& report = result->report;
  EXPECT_EQ(report.version(), version());
  EXPECT_EQ(report.request_id(), "r1");
  EXPECT_EQ(report.method(), "auto");
  EXPECT_EQ(report.parameters().at("iterations").number_value(), 3);
  EXPECT_EQ(report.choice().method(), "learned_normals");
  EXPECT_EQ(report.choice().parameters().at("strength").number_value(), 1);
  EXPECT_THAT(report.choice().reason(), ::testing::HasSubstr("gaussian noise"));
  EXPECT_THAT(report.choice().reason(), ::testing::HasSubstr("free-form: 0% of its bending"));
  EXPECT_EQ(report.choice().sharp_bending(), 0);
  EXPECT_EQ(report.parameters().at("boundary").string_value(), "fixed");
  EXPECT_EQ(report.parameters().size(), methods().front().parameters.size());
  EXPECT_EQ(report.errors().against(), "input");
  EXPECT_GT(report.errors().ev(), 0);
  EXPECT_GT(report.change().rms_displacement(), 0);
  EXPECT_EQ(report.input().vertices(), 642U);
  EXPECT_EQ(report.input().triangles(), 1280U);
  EXPECT_EQ(report.input().components(), 1U);
  EXPECT_EQ(report.output().vertices(), 642U);
  EXPECT_EQ(report.encoding().format(), v1::MESH_FORMAT_OBJ);
  EXPECT_EQ(report.timings().queue_ms(), 12);
  const auto& t = report.timings();
  const double stages =
      t.queue_ms() + t.decode_ms() + t.prepare_ms() + t.smooth_ms() + t.measure_ms() + t.encode_ms();
  EXPECT_GE(t.total_ms(), stages);
  for (const double ms : {t.decode_ms(), t.prepare_ms(), t.smooth_ms(), t.measure_ms(), t.encode_ms()})
    EXPECT_GT(ms, 0);
  EXPECT_EQ(report.warnings_size(), 0);
}

TEST(SmoothService, MeasuresAgainstTheReferenceThatWasSent) {
  const auto result = smooth({.mesh = noisy(), .reference = clean()});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.errors().against(), "reference");
  EXPECT_TRUE(result->report.errors().has_mean_normal_degrees());
  const auto before = compare({.reference = clean(), .mesh = noisy()});
  const auto after = compare({.reference = clean(), .mesh = result->mesh});
  ASSERT_TRUE(before && after);
  EXPECT_LT(after->errors().ev(), 0.6 * before->errors().ev());
  EXPECT_NEAR(after->errors().ev(), result->report.errors().ev(), 1e-5 * after->errors().ev());
}

TEST(SmoothService, ComparesMeshesAndTellsWhatTheyAre) {
  const std::string coarse = to_obj(sphere(2));
  const auto same = compare({.reference = clean(), .mesh = noisy(), .request_id = "r2", .queue_ms = 3});
  ASSERT_TRUE(same);
  EXPECT_EQ(same->errors().against(), "reference");
  EXPECT_TRUE(same->errors().has_mean_normal_degrees());
  EXPECT_EQ(same->mesh().triangles(), 1280U);
  EXPECT_EQ(same->request_id(), "r2");
  EXPECT_GE(same->timings().total_ms(), 3 + same->timings().decode_ms() + same->timings().measure_ms());
  EXPECT_EQ(same->warnings_size(), 0);
  const auto other = compare({.reference = coarse, .mesh = noisy()});
  ASSERT_TRUE(other);
  EXPECT_FALSE(other->errors().has_flipped_triangles());
  EXPECT_GT(other->errors().ev(), 0);
  EXPECT_EQ(other->reference().triangles(), 320U);
  EXPECT_EQ(other->warnings(0).code(), "connectivity_differs");
}

TEST(SmoothService, SaysWhichOfTheComparedMeshesIsBad) {
  const auto bad_reference = compare({.reference = "v 0 0\n", .mesh = noisy()});
  ASSERT_FALSE(bad_reference);
  EXPECT_THAT(bad_reference.error().message, ::testing::StartsWith("reference: "));
  const auto bad_mesh = compare({.reference = clean(), .mesh = "v 0 0\n"});
  ASSERT_FALSE(bad_mesh);
  EXPECT_THAT(bad_mesh.error().message, ::testing::StartsWith("mesh: "));
  EXPECT_EQ(compare({.reference = "", .mesh = noisy()}).error().cause, Cause::EmptyMesh);
  EXPECT_EQ(compare({.reference = clean(), .mesh = ""}).error().cause, Cause::EmptyMesh);
}

TEST(SmoothService, HoldsTheLimitsOfIterationsAndOptions) {
  const SmoothService service({.max_iterations = 50, .max_option_bytes = 200});
  v1::SmoothOptions options;
  options.set_iterations(50);
  EXPECT_TRUE(service.check(options));
  options.set_iterations(51);
  const auto many = service.check(options);
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().field, "iterations");
  EXPECT_THAT(many.error().message, HasSubstr("(max-iterations)"));
  options.set_iterations(1);
  (*options.mutable_parameters())["boundary"].set_string_value(std::string(200, 'x'));
  const auto large = service.check(options);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().cause, Cause::TooLarge);
  EXPECT_THAT(large.error().message, HasSubstr("(max-option-bytes)"));
}

TEST(SmoothService, TellsItsProgressStageByStage) {
  std::vector<std::pair<v1::SmoothStage, double>> seen;
  const auto result = smooth({.mesh = noisy(), .progress = [&](v1::SmoothStage stage, double done) {
                                seen.emplace_back(stage, done);
                              }});
  ASSERT_TRUE(result);
  EXPECT_TRUE(std::ranges::is_sorted(seen)) << "stages in their order, each from 0 to 1";
  EXPECT_EQ(seen.front(), std::pair(v1::SMOOTH_STAGE_DECODE, 0.0));
  EXPECT_EQ(seen.back().first, v1::SMOOTH_STAGE_ENCODE);
  EXPECT_THAT(seen, ::testing::Contains(std::pair(v1::SMOOTH_STAGE_SMOOTH, 1.0)));
}

TEST(SmoothService, ComparesWithAReferenceOfOtherConnectivity) {
  const std::string coarse = to_obj(sphere(2));
  const auto result = smooth({.mesh = noisy(), .reference = coarse});
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->report.errors().has_flipped_triangles());
  EXPECT_THAT(codes(result->report), ::testing::ElementsAre("connectivity_differs"));
  EXPECT_THAT(to_json(result->report, true), ::testing::Not(HasSubstr("flippedTriangles")));
}

TEST(SmoothService, ReturnsTheInputByteForByteAfterNoIterations) {
  SmoothJob job{.mesh = noisy()};
  job.options.set_iterations(0);
  const auto result = smooth(job);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mesh, noisy());
  EXPECT_LT(result->report.errors().ev(), 1e-12);
}

TEST(SmoothService, GivesTheSameBytesForAnyNumberOfThreads) {
  const std::string mesh = to_obj(with_noise(sphere(5), 0.01));
  const auto one = SmoothService().smooth({.mesh = mesh}, {.threads = 1});
  const auto all = SmoothService().smooth({.mesh = mesh}, {.threads = 4});
  ASSERT_TRUE(one && all);
  EXPECT_EQ(one->mesh, all->mesh);
  EXPECT_EQ(one->report.errors().ev(), all->report.errors().ev());
}

TEST(SmoothService, ConvertsBetweenItsFormats) {
  SmoothJob to_draco{.mesh = noisy()};
  to_draco.options.mutable_output()->set_format(v1::MESH_FORMAT_DRACO);
  const auto draco = smooth(to_draco);
  ASSERT_TRUE(draco);
  EXPECT_EQ(draco->format, Format::Draco);
  EXPECT_EQ(draco->report.encoding().draco_method(), v1::DRACO_METHOD_SEQUENTIAL);
  EXPECT_EQ(draco->report.encoding().position_bits(), 0U);
  SmoothJob to_obj_again{.mesh = draco->mesh};
  to_obj_again.options.set_iterations(0);
  to_obj_again.options.mutable_output()->set_format(v1::MESH_FORMAT_OBJ);
  const auto obj = smooth(to_obj_again);
  ASSERT_TRUE(obj);
  const auto direct = smooth({.mesh = noisy()});
  const auto difference = compare({.reference = direct->mesh, .mesh = obj->mesh});
  ASSERT_TRUE(difference);
  EXPECT_LT(difference->errors().max_distance(), 2e-7);
}

TEST(SmoothService, StatesTheQuantisationErrorOfItsEncoding) {
  SmoothJob job{.mesh = noisy()};
  job.options.mutable_output()->set_format(v1::MESH_FORMAT_DRACO);
  job.options.mutable_output()->mutable_draco()->set_position_bits(10);
  const auto coarse = smooth(job);
  ASSERT_TRUE(coarse);
  EXPECT_EQ(coarse->report.encoding().position_bits(), 10U);
  const double cell = 2.1 / 1023;
  EXPECT_GT(coarse->report.encoding().quantisation_error(), 0.2 * cell);
  EXPECT_LT(coarse->report.encoding().quantisation_error(), cell);
}

/// noisy() with the faces from the 100th on in the group "rim".
std::string grouped() {
  std::string text = noisy();
  std::size_t at = 0;
  for (int face = 0; face < 100; ++face) at = text.find("\nf ", at + 1);
  return text.insert(at + 1, "g rim\n");
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(SmoothService, KeepsPinnedVerticesAndCountsThem) {
  const std::string mesh = grouped();
  SmoothJob job{.mesh = mesh};
  job.options.mutable_pinned()->set_group("rim");
  for (const std::uint32_t vertex : {0U, 17U, 0U}) job.options.mutable_pinned()->add_vertices(vertex);
  const auto result = smooth(job);
  ASSERT_TRUE(result) << result.error().message;
  const auto before = lines_of(mesh), after = lines_of(result->mesh);
  ASSERT_EQ(before.size(), after.size());
  std::set<std::size_t> pinned = {0, 17};
  for (auto line = std::ranges::find(before, "g rim") + 1; line != before.end(); ++line) {
    std::istringstream face(line->substr(2));
    for (std::size_t vertex = 0; face >> vertex;) pinned.insert(vertex - 1);
  }
  std::size_t v = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!before[i].starts_with("v ")) continue;
    EXPECT_EQ(before[i] == after[i], pinned.contains(v)) << v;
    ++v;
  }
  EXPECT_EQ(v, 642U);
  EXPECT_EQ(result->report.pinned_vertices(), pinned.size());
  EXPECT_EQ(smooth({.mesh = mesh})->report.pinned_vertices(), 0U);
}

TEST(SmoothService, SaysWhatKindOfSurfaceAutoFound) {
  const std::string rough = testing::to_obj(testing::with_noise(testing::cube(20), 0.03));
  const auto result = smooth({.mesh = rough});
  ASSERT_TRUE(result);
  EXPECT_GT(result->report.choice().sharp_bending(), 0.8);
}

TEST(SmoothService, ReportsTheNoiseOfTheInput) {
  const testing::Shape clean = testing::sphere(4);
  const double h = testing::surface_of(clean).mean_edge * testing::surface_of(clean).mesh.frame.scale();
  const auto noise_of = [](const testing::Shape& shape) {
    const std::string mesh = testing::to_obj(shape);
    return smooth({.mesh = mesh})->report.noise();
  };
  EXPECT_EQ(noise_of(clean).kind(), "none");
  // Uniform from -0.5 h to 0.5 h: a standard deviation of 0.29 h.
  const auto noisy = noise_of(testing::with_noise(clean, 0.5 * h));
  EXPECT_EQ(noisy.kind(), "gaussian");
  EXPECT_NEAR(noisy.sigma_over_edge(), 0.29, 0.06);
}

TEST(SmoothService, NamesThePinThatTheMeshDoesNotHave) {
  struct Row {
    std::function<void(v1::PinnedVertices&)> set;
    const char *field, *says;
  };
  const Row rows[] = {
      {[](auto& p) { p.add_vertices(0), p.add_vertices(642); }, "pinned.vertices[1]",
       "is 642 but the mesh has 642"},
      {[](auto& p) { p.set_group("Rim"); }, "pinned.group", R"(no group "Rim"; it has "default", "rim")"},
      {[](auto& p) { p.set_attribute("1"); }, "pinned.attribute", "OBJ"},
  };
  const std::string mesh = grouped();
  for (const Row& row : rows) {
    SmoothJob job{.mesh = mesh};
    row.set(*job.options.mutable_pinned());
    const auto result = smooth(job);
    ASSERT_FALSE(result) << row.field;
    EXPECT_EQ(result.error().cause, Cause::BadOption);
    EXPECT_EQ(result.error().field, row.field);
    EXPECT_THAT(result.error().message, HasSubstr(row.says));
  }
}

TEST(SmoothService, RefusesBadOptionsByNameBeforeItReadsTheMesh) {
  struct Row {
    std::function<void(v1::SmoothOptions&)> set;
    Cause cause;
    const char* field;
  };
  const auto parameter = [](const char* name, auto&& set) {
    return [name, set](v1::SmoothOptions& o) { set((*o.mutable_parameters())[name]); };
  };
  using google::protobuf::Value;
  const Row rows[] = {
      {[](auto& o) { o.set_method("laplace"); }, Cause::UnknownMethod, "method"},
      {[](auto& o) { o.set_iterations(100'001); }, Cause::BadOption, "iterations"},
      {parameter("lambda", [](Value& v) { v.set_number_value(0.5); }), Cause::UnknownOption, "lambda"},
      {parameter("sigma", [](Value& v) { v.set_number_value(-1); }), Cause::BadOption, "sigma"},
      {parameter("sigma", [](Value& v) { v.set_bool_value(true); }), Cause::BadOption, "sigma"},
      {parameter("normals", [](Value& v) { v.set_string_value("rough"); }), Cause::BadOption, "normals"},
      {[](auto& o) {
         o.set_iterations(3);
         (*o.mutable_parameters())["iterations"].set_number_value(4);
       },
       Cause::BadOption, "iterations"},
      {[](auto& o) { o.mutable_output()->mutable_draco()->set_position_bits(31); }, Cause::BadOption,
       "output.draco.position_bits"},
      {[](auto& o) { o.mutable_output()->mutable_draco()->set_normal_bits(1); }, Cause::BadOption,
       "output.draco.normal_bits"},
      {[](auto& o) { o.mutable_output()->mutable_draco()->set_speed(11); }, Cause::BadOption,
       "output.draco.speed"},
      {[](auto& o) { o.mutable_output()->set_format(static_cast<v1::MeshFormat>(9)); }, Cause::BadOption,
       "output.format"},
      {[](auto& o) { o.mutable_output()->mutable_draco()->set_method(static_cast<v1::DracoMethod>(9)); },
       Cause::BadOption, "output.draco.method"},
  };
  for (const Row& row : rows) {
    SmoothJob job{.mesh = "not a mesh"};
    job.options.set_method("adaptive");
    row.set(job.options);
    const auto checked = SmoothService().check(job);
    ASSERT_FALSE(checked) << row.field;
    EXPECT_EQ(cause_code(checked.error().cause), cause_code(row.cause)) << row.field;
    EXPECT_EQ(checked.error().field, row.field);
    EXPECT_EQ(smooth(job).error(), checked.error());
  }
}

TEST(SmoothService, HoldsItsLimitsForMeshAndReference) {
  const RequestLimits small{.mesh = {.max_bytes = 100}};
  EXPECT_EQ(smooth({.mesh = noisy()}, small).error().cause, Cause::TooLarge);
  EXPECT_THAT(smooth({.mesh = "v 0 0 0", .reference = noisy()}, small).error().message,
              HasSubstr("the reference has"));
  EXPECT_EQ(smooth({.mesh = ""}).error().cause, Cause::EmptyMesh);
}

TEST(SmoothService, SaysThatTheReferenceIsToBlame) {
  const auto result = smooth({.mesh = noisy(), .reference = "v 0 0\n"});
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("reference: vertex 1"));
}

TEST(SmoothService, StopsForTokenAndDeadline) {
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(SmoothService().smooth({.mesh = noisy()}, {.stop = source.get_token()}).error().cause,
            Cause::Cancelled);
  const RunControl late{.deadline = RunControl::Clock::now() - std::chrono::seconds(1)};
  EXPECT_EQ(SmoothService().smooth({.mesh = noisy()}, late).error().cause, Cause::DeadlineExceeded);
}

TEST(SetParameterFromText, TypesValuesByTheRegistry) {
  v1::SmoothOptions options;
  options.set_method("taubin");
  ASSERT_TRUE(set_parameter_from_text(options, "lambda", "0.25"));
  ASSERT_TRUE(set_parameter_from_text(options, "iterations", "7"));
  ASSERT_TRUE(set_parameter_from_text(options, "boundary", "free"));
  EXPECT_EQ(options.parameters().at("lambda").number_value(), 0.25);
  EXPECT_EQ(options.iterations(), 7U);
  EXPECT_EQ(options.parameters().at("boundary").string_value(), "free");
  EXPECT_EQ(set_parameter_from_text(options, "lambda", "much").error().cause, Cause::BadOption);
}

TEST(ListMethods, IsTheRegistry) {
  const auto response = list_methods();
  ASSERT_EQ(static_cast<std::size_t>(response.methods_size()), methods().size());
  for (std::size_t m = 0; m < methods().size(); ++m) {
    const auto& described = response.methods(static_cast<int>(m));
    EXPECT_EQ(described.name(), methods()[m].name);
    EXPECT_EQ(static_cast<std::size_t>(described.parameters_size()), methods()[m].parameters.size());
  }
  EXPECT_THAT(to_json(response, true), HasSubstr(R"("defaultValue":0.5)"));
}

TEST(Json, ListsParametersInAlphabeticalOrder) {
  v1::SmoothReport report;
  for (const char* name : {"mu", "boundary", "lambda", "iterations", "a", "z"}) {
    (*report.mutable_parameters())[name].set_number_value(0.1);
  }
  EXPECT_THAT(
      to_json(report, true),
      HasSubstr(R"("parameters":{"a":0.1,"boundary":0.1,"iterations":0.1,"lambda":0.1,"mu":0.1,"z":0.1})"));
}

TEST(Json, PrintsZerosAndNoUnsetMeasure) {
  const std::string json = to_json(v1::SmoothReport{}, true);
  EXPECT_THAT(json, HasSubstr(R"("requestId":"")"));
  v1::MeshErrors errors;
  EXPECT_THAT(to_json(errors, true), HasSubstr(R"("maxDistance":0)"));
}

TEST(ApiDocument, HoldsARowForEveryCause) {
  const std::string document = read_file(BURNISH_DOCS "/api.md");
  for (const Cause cause : all_causes()) {
    const StatusRow& row = status_of(cause);
    const bool on_http = cause != Cause::Unreachable && cause != Cause::FileError;
    const std::string start = "| `" + std::string(cause_code(cause)) + "` | ";
    const std::string end = (on_http ? " | " + std::to_string(row.http_status) : std::string(" | -")) +
                            " | " + std::to_string(row.exit_code) + " | ";
    const std::size_t at = document.find(start);
    ASSERT_NE(at, std::string::npos) << start;
    EXPECT_THAT(document.substr(at, document.find('\n', at) - at), HasSubstr(end)) << start;
  }
}

}  // namespace
}  // namespace burnish
