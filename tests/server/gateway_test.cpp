#include "server/http/gateway.h"

#include <gtest/gtest.h>

#include <future>
#include <nlohmann/json.hpp>

#include "server/http/report_header.h"
#include "server/status_map.h"
#include "tests/server/gate.h"
#include "tests/support/eventually.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

const std::function<bool()> kClientStays = [] { return false; };

/// A gateway with everything behind it, and no socket.
struct House {
  explicit House(SmoothFunction smooth = {}, std::chrono::milliseconds longest_run = 60s)
      : runner({.workers = 1, .queue = 1}),
        jobs(service, runner, lifecycle, metrics, longest_run, std::move(smooth)) {
    lifecycle.move_to(LifecycleState::Serving);
  }
  ~House() { runner.drain(0ms); }  // workers use what is destroyed before the runner

  HttpResponse handle(const HttpRequest& request) { return gateway.handle(request, kClientStays); }
  HttpResponse get(const std::string& path) { return handle({.method = "GET", .path = path}); }

  Lifecycle lifecycle;
  Metrics metrics;
  SmoothService service{Limits{.max_bytes = 100'000}};
  JobRunner runner;
  SmoothJobs jobs;
  Gateway gateway{jobs};
};

HttpRequest smooth_request(std::string mesh, std::multimap<std::string, std::string> query = {}) {
  return {.method = "POST",
          .path = "/v1/smooth",
          .query = std::move(query),
          .body = std::make_shared<const std::string>(std::move(mesh))};
}

std::string small_mesh() { return testing::to_obj(testing::with_noise(testing::sphere(1), 0.05)); }

json body_of(const HttpResponse& response) { return json::parse(response.body); }

/// Every member of a problem, against the status map.
void expect_problem(const HttpResponse& response, Cause cause) {
  const StatusRow& row = status_of(cause);
  EXPECT_EQ(response.status, row.http_status) << response.body;
  ASSERT_EQ(response.headers.at("Content-Type"), "application/problem+json");
  const json problem = body_of(response);
  EXPECT_EQ(problem["code"], cause_code(cause)) << response.body;
  EXPECT_EQ(problem["status"], row.http_status);
  EXPECT_EQ(problem["title"], row.title);
  EXPECT_EQ(problem["type"], "urn:burnish:problem:" + std::string(cause_code(cause)));
  EXPECT_FALSE(problem["detail"].get<std::string>().empty());
  EXPECT_EQ(problem["requestId"].get<std::string>().size(), 16u);
  EXPECT_EQ(problem["requestId"], response.headers.at("Burnish-Request-Id"));
}

TEST(Gateway, AnswersWithTheMeshAndItsReport) {
  House house;
  const HttpResponse response =
      house.handle(smooth_request(small_mesh(), {{"method", "laplacian"}, {"iterations", "3"}}));
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.headers.at("Content-Type"), "model/obj");
  const json report = json::parse(response.headers.at("burnish-report"));
  EXPECT_EQ(report["method"], "laplacian");
  EXPECT_EQ(report["parameters"]["iterations"], 3);
  EXPECT_EQ(report["requestId"], response.headers.at("Burnish-Request-Id"));
  EXPECT_EQ(report["output"]["vertices"], 42);

  SmoothJob job;
  const std::string mesh = small_mesh();
  job.mesh = mesh;
  job.options.set_method("laplacian");
  job.options.set_iterations(3);
  const auto direct = house.service.smooth(job, RunControl());
  ASSERT_TRUE(direct.ok());
  EXPECT_EQ(response.body, direct.value().mesh) << "the transport must not change the mesh";
}

TEST(Gateway, WritesDracoWhenAsked) {
  House house;
  const HttpResponse response = house.handle(smooth_request(
      small_mesh(),
      {{"output", "drc"}, {"draco_method", "edgebreaker"}, {"position_bits", "12"}, {"speed", "3"}}));
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.headers.at("Content-Type"), "model/vnd.draco");
  EXPECT_EQ(response.body.substr(0, 5), "DRACO");
  const json report = json::parse(response.headers.at("Burnish-Report"));
  EXPECT_EQ(report["encoding"]["dracoMethod"], "DRACO_METHOD_EDGEBREAKER");
  EXPECT_EQ(report["encoding"]["positionBits"], 12);
}

TEST(Gateway, TellsTheFormatByContentTypeOrContent) {
  struct Row {
    const char* type;
    int status;
  };
  House house;
  for (const Row& row :
       {Row{"model/obj", 200}, Row{"Model/OBJ; charset=utf-8", 200}, Row{"application/octet-stream", 200},
        Row{"text/plain", 200}, Row{"application/x-www-form-urlencoded", 200}, Row{"model/vnd.draco", 422},
        Row{"application/json", 415}, Row{"multipart/form-data; boundary=x", 415}}) {
    HttpRequest request = smooth_request(small_mesh());
    request.headers["content-type"] = row.type;
    EXPECT_EQ(house.handle(request).status, row.status) << row.type;
  }
  HttpRequest zipped = smooth_request(small_mesh());
  zipped.headers["Content-Encoding"] = "gzip";
  expect_problem(house.handle(zipped), Cause::UnsupportedFormat);
}

TEST(Gateway, NamesTheQueryParameterThatIsWrong) {
  struct Row {
    std::multimap<std::string, std::string> query;
    Cause cause;
    const char* field;
  };
  const Row rows[] = {
      {{{"colour", "red"}}, Cause::UnknownOption, "colour"},
      {{{"method", "taubin"}, {"sigma", "1"}}, Cause::UnknownOption, "sigma"},
      {{{"iterations", "many"}}, Cause::BadOption, "iterations"},
      {{{"iterations", "-1"}}, Cause::BadOption, "iterations"},
      {{{"iterations", "3"}, {"iterations", "3"}}, Cause::BadOption, "iterations"},
      {{{"method", "taubin"}, {"method", "taubin"}}, Cause::BadOption, "method"},
      {{{"output", "stl"}}, Cause::BadOption, "output"},
      {{{"timeout_ms", "0"}}, Cause::BadOption, "timeout_ms"},
      {{{"timeout_ms", "5s"}}, Cause::BadOption, "timeout_ms"},
      {{{"timeout_ms", "99999999999"}}, Cause::BadOption, "timeout_ms"},
      {{{"draco_method", "best"}}, Cause::BadOption, "draco_method"},
      {{{"position_bits", "31"}}, Cause::BadOption, "position_bits"},
      {{{"speed", "11"}}, Cause::BadOption, "speed"},
      {{{"speed", ""}}, Cause::BadOption, "speed"},
  };
  House house;
  for (const Row& row : rows) {
    const HttpResponse response = house.handle(smooth_request(small_mesh(), row.query));
    expect_problem(response, row.cause);
    EXPECT_EQ(body_of(response)["field"], row.field);
  }
  expect_problem(house.handle(smooth_request(small_mesh(), {{"method", "magic"}})), Cause::UnknownMethod);
}

TEST(Gateway, AnswersEveryCauseByTheStatusMap) {
  for (const Cause cause : all_causes()) {
    House house([cause](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
      return Error{cause, "on purpose", "some_field"};
    });
    const HttpResponse response = house.handle(smooth_request("anything"));
    expect_problem(response, cause);
    EXPECT_EQ(body_of(response)["field"], "some_field");
    EXPECT_EQ(response.headers.contains("Retry-After"),
              cause == Cause::QueueFull || cause == Cause::ShuttingDown);
  }
}

TEST(Gateway, AnswersInternalAndOutOfMemoryForExceptions) {
  House throwing(
      [](const SmoothJob&, const RunControl&) -> Result<SmoothResult> { throw std::runtime_error("x"); });
  expect_problem(throwing.handle(smooth_request("anything")), Cause::Internal);
  House starving([](const SmoothJob&, const RunControl&) -> Result<SmoothResult> { throw std::bad_alloc(); });
  expect_problem(starving.handle(smooth_request("anything")), Cause::OutOfMemory);
}

TEST(Gateway, KeepsProblemsReadableWhateverTheBytes) {
  House house([](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
    return Error{Cause::MalformedMesh, "line 1: '\xff\x01\n" + std::string(10'000, 'x') + "'"};
  });
  const HttpResponse response = house.handle(smooth_request("anything"));
  expect_problem(response, Cause::MalformedMesh);
  EXPECT_LT(response.body.size(), 2000u);
  const HttpResponse bad_name = house.handle(smooth_request("anything", {{"\xff\xfe", "1"}}));
  expect_problem(bad_name, Cause::UnknownOption);
}

TEST(Gateway, ListsTheMethods) {
  House house;
  const HttpResponse response = house.get("/v1/methods");
  ASSERT_EQ(response.status, 200);
  EXPECT_EQ(response.headers.at("Content-Type"), "application/json");
  const json methods = body_of(response)["methods"];
  EXPECT_EQ(methods.size(), static_cast<std::size_t>(list_methods().methods_size()));
  EXPECT_EQ(methods[0]["name"], "adaptive");
}

TEST(Gateway, IsReadyOnlyWhileServingButAliveAlways) {
  House house;
  EXPECT_EQ(house.get("/livez").status, 200);
  EXPECT_EQ(house.get("/readyz").status, 200);
  house.lifecycle.move_to(LifecycleState::Draining);
  EXPECT_EQ(house.get("/livez").status, 200);
  expect_problem(house.get("/readyz"), Cause::ShuttingDown);
  expect_problem(house.handle(smooth_request(small_mesh())), Cause::ShuttingDown);
}

TEST(Gateway, AnswersUnknownPathsAndVerbs) {
  House house;
  for (const char* path : {"/", "/v1", "/v1/smooth/", "/v2/smooth", "//livez", ""}) {
    expect_problem(house.get(path), Cause::NotFound);
  }
  struct Row {
    const char *method, *path, *allow;
  };
  for (const Row& row : {Row{"GET", "/v1/smooth", "POST"}, Row{"PUT", "/v1/smooth", "POST"},
                         Row{"POST", "/v1/methods", "GET, HEAD"}, Row{"DELETE", "/livez", "GET, HEAD"},
                         Row{"OPTIONS", "/readyz", "GET, HEAD"}, Row{"G", "/metrics", "GET, HEAD"}}) {
    const HttpResponse response = house.handle({.method = row.method, .path = row.path});
    expect_problem(response, Cause::MethodNotAllowed);
    EXPECT_EQ(response.headers.at("Allow"), row.allow) << row.path;
  }
  EXPECT_EQ(house.handle({.method = "HEAD", .path = "/v1/methods"}).status, 200);
}

TEST(Gateway, RefusesALargeBodyByItsHeadAlone) {
  House house;
  HttpRequest head{.method = "POST", .path = "/v1/smooth", .headers = {{"Content-Length", "100001"}}};
  const auto refused = house.gateway.answer_head(head);
  ASSERT_TRUE(refused.has_value());
  expect_problem(*refused, Cause::TooLarge);
  EXPECT_NE(refused->body.find("100000"), std::string::npos) << "the limit is named";
  head.headers["Content-Length"] = "100000";
  EXPECT_FALSE(house.gateway.answer_head(head).has_value());
  expect_problem(house.handle(smooth_request(std::string(100'001, ' '))), Cause::TooLarge);
}

TEST(Gateway, RefusesAnEmptyBody) {
  House house;
  expect_problem(house.handle(smooth_request("")), Cause::EmptyMesh);
  expect_problem(house.handle({.method = "POST", .path = "/v1/smooth"}), Cause::EmptyMesh);
}

TEST(Gateway, RefusesAtOnceWhenTheQueueIsFull) {
  testing::Gate gate;
  House house(gate.smoother());
  const auto wait = [&] { return house.handle(smooth_request("mesh")); };
  auto running = std::async(std::launch::async, wait);
  gate.wait_for(1);
  auto waiting = std::async(std::launch::async, wait);
  ASSERT_TRUE(testing::eventually([&] { return house.runner.queued() == 1; }));
  const HttpResponse refused = wait();
  expect_problem(refused, Cause::QueueFull);
  EXPECT_EQ(refused.headers.at("Retry-After"), "1");
  gate.open();
  EXPECT_EQ(running.get().status, 200);
  EXPECT_EQ(waiting.get().status, 200);
}

TEST(Gateway, StopsTheJobOfAClientThatWentAway) {
  testing::Gate gate;
  House house(gate.smoother());
  std::atomic<bool> gone = false;
  auto answer = std::async(std::launch::async, [&] {
    return house.gateway.handle(smooth_request("mesh"), [&] { return gone.load(); });
  });
  gate.wait_for(1);
  gone = true;
  expect_problem(answer.get(), Cause::Cancelled);
  EXPECT_TRUE(testing::eventually([&] { return house.runner.running() == 0; }))
      << "the gate was never opened";
}

TEST(Gateway, AnswersAPassedDeadlineEvenWhenTheJobCannotBeInterrupted) {
  std::promise<void> release;
  auto released = release.get_future().share();
  House house([released](const SmoothJob& job, const RunControl&) -> Result<SmoothResult> {
    released.wait();  // like a library call: looks at no deadline
    EXPECT_EQ(job.mesh, "mesh") << "the body lives as long as the job";
    return Error{Cause::DeadlineExceeded, "late"};
  });
  const HttpResponse response = house.handle(smooth_request("mesh", {{"timeout_ms", "30"}}));
  expect_problem(response, Cause::DeadlineExceeded);
  EXPECT_EQ(house.runner.running(), 1u) << "the answer came while the job still runs";
  release.set_value();
}

TEST(Gateway, BoundsTheLongestRun) {
  testing::Gate gate;
  House house(gate.smoother(), 20ms);
  expect_problem(house.handle(smooth_request("mesh")), Cause::DeadlineExceeded);
}

TEST(Gateway, CountsRequestsAndOutcomes) {
  House house;
  house.handle(smooth_request(small_mesh(), {{"iterations", "1"}}));
  house.handle(smooth_request("no mesh at all"));
  house.handle(smooth_request(small_mesh(), {{"colour", "red"}}));
  ASSERT_TRUE(
      testing::eventually([&] { return house.runner.running() == 0; }));  // answers come a moment before
  const std::string text = house.get("/metrics").body;
  for (const char* line :
       {"burnish_requests_total{transport=\"http\"} 3", "burnish_requests_total{transport=\"grpc\"} 0",
        "burnish_outcomes_total{code=\"ok\",transport=\"http\"} 1",
        "burnish_outcomes_total{code=\"unknown_option\",transport=\"http\"} 1",
        "burnish_outcomes_total{code=\"queue_full\",transport=\"grpc\"} 0",
        "burnish_stage_seconds_count{stage=\"smooth\"} 1", "burnish_stage_seconds_count{stage=\"total\"} 1",
        "burnish_queue_depth 0", "burnish_jobs_running 0"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
  }
}

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
