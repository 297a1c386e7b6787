#include "server/http/gateway.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <nlohmann/json.hpp>

#include "server/status_map.h"
#include "tests/server/gate.h"
#include "tests/server/gateway_house.h"
#include "tests/support/eventually.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using ::testing::HasSubstr;

using House = testing::GatewayHouse;
using testing::body_of;
using testing::expect_problem;
using testing::form_request;
using testing::smooth_request;

testing::GatewaySetting with(SmoothFunction smooth) { return {.smooth = std::move(smooth)}; }

std::string small_mesh() { return testing::to_obj(testing::with_noise(testing::sphere(1), 0.05)); }

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

TEST(Gateway, PinsWhatTheQueryNames) {
  House house;
  const std::string mesh = "g tip\n" + small_mesh() + "g other\n";
  const auto pinned = [&](std::multimap<std::string, std::string> query) {
    const HttpResponse response = house.handle(smooth_request(mesh, std::move(query)));
    EXPECT_EQ(response.status, 200) << response.body;
    return json::parse(response.headers.at("burnish-report"))["pinnedVertices"].get<int>();
  };
  EXPECT_EQ(pinned({}), 0);
  EXPECT_EQ(pinned({{"pinned_vertices", "7"}}), 1);
  EXPECT_EQ(pinned({{"pinned_vertices", "0,7,41"}}), 3);
  EXPECT_EQ(pinned({{"pinned_group", "tip"}}), 42);
  EXPECT_EQ(pinned({{"pinned_group", "other"}, {"pinned_vertices", "1,2"}}), 2);
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
        Row{"application/json", 415}, Row{"model/stl", 422}, Row{"application/ply", 422},
        Row{"model/3mf", 415}, Row{"multipart/form-data; boundary=x", 400}}) {
    HttpRequest request = smooth_request(small_mesh());
    request.headers["content-type"] = row.type;
    EXPECT_EQ(house.handle(request).status, row.status) << row.type;
  }
  HttpRequest squeezed = smooth_request(small_mesh());
  squeezed.headers["Content-Encoding"] = "br";
  expect_problem(house.handle(squeezed), Cause::UnsupportedFormat);
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
      {{{"output", "fbx"}}, Cause::BadOption, "output"},
      {{{"timeout_ms", "0"}}, Cause::BadOption, "timeout_ms"},
      {{{"timeout_ms", "5s"}}, Cause::BadOption, "timeout_ms"},
      {{{"timeout_ms", "99999999999"}}, Cause::BadOption, "timeout_ms"},
      {{{"draco_method", "best"}}, Cause::BadOption, "draco_method"},
      {{{"position_bits", "31"}}, Cause::BadOption, "position_bits"},
      {{{"speed", "11"}}, Cause::BadOption, "speed"},
      {{{"speed", ""}}, Cause::BadOption, "speed"},
      {{{"pinned_vertices", ""}}, Cause::BadOption, "pinned_vertices"},
      {{{"pinned_vertices", "1,2,"}}, Cause::BadOption, "pinned_vertices"},
      {{{"pinned_vertices", "1, 2"}}, Cause::BadOption, "pinned_vertices"},
      {{{"pinned_vertices", "4294967296"}}, Cause::BadOption, "pinned_vertices"},
      {{{"pinned_vertices", "1"}, {"pinned_vertices", "2"}}, Cause::BadOption, "pinned_vertices"},
      {{{"pinned_vertices", "0,99999"}}, Cause::BadOption, "pinned.vertices[1]"},
      {{{"pinned_group", ""}}, Cause::BadOption, "pinned_group"},
      {{{"pinned_group", "nobody"}}, Cause::BadOption, "pinned.group"},
      {{{"pinned_attribute", "31"}}, Cause::BadOption, "pinned.attribute"},
  };
  House house;
  for (const Row& row : rows) {
    const HttpResponse response = house.handle(smooth_request(small_mesh(), row.query));
    expect_problem(response, row.cause);
    EXPECT_EQ(body_of(response)["field"], row.field);
  }
  expect_problem(house.handle(smooth_request(small_mesh(), {{"method", "magic"}})), Cause::UnknownMethod);
}

TEST(Gateway, ListsTheNamesThatEveryQueryMayHave) {
  House house;
  for (const char* method : {"taubin", "auto"}) {
    const HttpResponse response =
        house.handle(smooth_request(small_mesh(), {{"method", method}, {"format", "off"}}));
    const std::string message = body_of(response)["detail"];
    EXPECT_THAT(message, HasSubstr("has no parameter format; it has "));
    EXPECT_THAT(message, HasSubstr("method, output, draco_method, position_bits, "));
    EXPECT_THAT(message, HasSubstr("pinned_vertices, pinned_group, pinned_attribute, timeout_ms"));
  }
}

TEST(Gateway, AnswersEveryCauseByTheStatusMap) {
  for (const Cause cause : all_causes()) {
    House house(with([cause](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
      return Error{cause, "on purpose", "some_field"};
    }));
    const HttpResponse response = house.handle(smooth_request("anything"));
    expect_problem(response, cause);
    EXPECT_EQ(body_of(response)["field"], "some_field");
    EXPECT_EQ(response.headers.contains("Retry-After"),
              cause == Cause::QueueFull || cause == Cause::MemoryFull || cause == Cause::ShuttingDown);
  }
}

TEST(Gateway, AnswersInternalAndOutOfMemoryForExceptions) {
  House throwing(with(
      [](const SmoothJob&, const RunControl&) -> Result<SmoothResult> { throw std::runtime_error("x"); }));
  expect_problem(throwing.handle(smooth_request("anything")), Cause::Internal);
  House starving(
      with([](const SmoothJob&, const RunControl&) -> Result<SmoothResult> { throw std::bad_alloc(); }));
  expect_problem(starving.handle(smooth_request("anything")), Cause::OutOfMemory);
}

TEST(Gateway, KeepsProblemsReadableWhateverTheBytes) {
  House house(with([](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
    return Error{Cause::MalformedMesh, "line 1: '\xff\x01\n" + std::string(10'000, 'x') + "'"};
  }));
  const HttpResponse response = house.handle(smooth_request("anything"));
  expect_problem(response, Cause::MalformedMesh);
  EXPECT_LT(response.body.size(), 2000u);
  const HttpResponse bad_name = house.handle(smooth_request("anything", {{"\xff\xfe", "1"}}));
  expect_problem(bad_name, Cause::UnknownOption);
}

TEST(Gateway, RefusesALargeBodyByItsHeadAlone) {
  House house;
  HttpRequest head{.method = "POST", .path = "/v1/smooth", .headers = {{"Content-Length", "100001"}}};
  const auto refused = house.gateway.answer_head(head);
  ASSERT_TRUE(refused.has_value());
  expect_problem(*refused, Cause::TooLarge);
  EXPECT_NE(refused->body.find("100000 (max-bytes)"), std::string::npos) << refused->body;
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
  House house(with(gate.smoother()));
  const auto wait = [&] { return house.handle(smooth_request("mesh")); };
  auto running = std::async(std::launch::async, wait);
  gate.wait_for(1);
  auto waiting = std::async(std::launch::async, wait);
  ASSERT_TRUE(testing::eventually([&] { return house.runner.queued() == 1; }));
  const HttpResponse refused = wait();
  expect_problem(refused, Cause::QueueFull);
  EXPECT_GE(std::stoi(refused.headers.at("Retry-After")), 1);
  gate.open();
  EXPECT_EQ(running.get().status, 200);
  EXPECT_EQ(waiting.get().status, 200);
}

TEST(Gateway, StopsTheJobOfAClientThatWentAway) {
  testing::Gate gate;
  House house(with(gate.smoother()));
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
  House house(with([released](const SmoothJob& job, const RunControl&) -> Result<SmoothResult> {
    released.wait();  // like a library call: looks at no deadline
    EXPECT_EQ(job.mesh, "mesh") << "the body lives as long as the job";
    return Error{Cause::DeadlineExceeded, "late"};
  }));
  const HttpResponse response = house.handle(smooth_request("mesh", {{"timeout_ms", "30"}}));
  expect_problem(response, Cause::DeadlineExceeded);
  EXPECT_EQ(house.runner.running(), 1u) << "the answer came while the job still runs";
  release.set_value();
}

TEST(Gateway, BoundsTheLongestRun) {
  testing::Gate gate;
  House house({.smooth = gate.smoother(), .longest_run = 20ms});
  expect_problem(house.handle(smooth_request("mesh")), Cause::DeadlineExceeded);
}

TEST(Gateway, CountsRequestsOnceEach) {
  House house;
  house.handle(smooth_request(small_mesh(), {{"iterations", "1"}}));
  house.handle(smooth_request("no mesh at all"));
  house.handle(smooth_request(small_mesh(), {{"colour", "red"}}));
  house.handle(form_request("/v1/compare", {{"mesh", small_mesh()}}));
  house.gateway.refuse(smooth_request(""), {Cause::TooLarge, "more than the limit"});
  house.gateway.bad_request(431, {Cause::BadRequest, "too many headers"});
  house.get("/v1/methods");
  house.get("/nowhere");
  house.handle({.method = "PUT", .path = "/v1/smooth"});
  ASSERT_TRUE(
      testing::eventually([&] { return house.runner.running() == 0; }));  // answers come a moment before
  const std::string text = house.get("/metrics").body;
  for (const char* line :
       {"burnish_requests_total{kind=\"smooth\",transport=\"http\"} 5",
        "burnish_requests_total{kind=\"compare\",transport=\"http\"} 1",
        "burnish_requests_total{kind=\"smooth\",transport=\"grpc\"} 0",
        "burnish_outcomes_total{code=\"ok\",kind=\"smooth\",transport=\"http\"} 1",
        "burnish_outcomes_total{code=\"unknown_option\",kind=\"smooth\",transport=\"http\"} 1",
        "burnish_outcomes_total{code=\"too_large\",kind=\"smooth\",transport=\"http\"} 1",
        "burnish_outcomes_total{code=\"bad_request\",kind=\"smooth\",transport=\"http\"} 1",
        "burnish_outcomes_total{code=\"bad_option\",kind=\"compare\",transport=\"http\"} 1",
        "burnish_outcomes_total{code=\"not_found\",kind=\"smooth\",transport=\"http\"} 0"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
  }
}

TEST(Gateway, SaysWhenToTryAgain) {
  struct Row {
    std::chrono::milliseconds after;
    const char* header;
  };
  for (const Row& row : {Row{0ms, "1"}, Row{1ms, "1"}, Row{1000ms, "1"}, Row{1001ms, "2"}, Row{90s, "90"}}) {
    House house(with([&row](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
      return Error{.cause = Cause::MemoryFull, .message = "full", .retry_after = row.after};
    }));
    const HttpResponse response = house.handle(smooth_request("anything"));
    expect_problem(response, Cause::MemoryFull);
    EXPECT_EQ(response.headers.at("Retry-After"), row.header) << row.after.count();
  }
}

}  // namespace
}  // namespace burnish
