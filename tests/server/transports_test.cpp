// What a client sees over both transports, against the real server.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "server/status_map.h"
#include "tests/server/running_server.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using nlohmann::json;
using testing::any_port;
using testing::detail_of;
using testing::RawHttp;
using testing::reason_of;
using testing::RunningServer;

constexpr std::string_view kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

std::string upper_case(std::string_view code) {
  std::string result(code);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return std::toupper(c); });
  return result;
}

void expect_grpc(const grpc::Status& status, Cause cause, const std::string& what) {
  EXPECT_EQ(static_cast<int>(status.error_code()), status_of(cause).grpc_code)
      << what << status.error_message();
  const auto info = detail_of<google::rpc::ErrorInfo>(status);
  ASSERT_TRUE(info.has_value()) << what;
  EXPECT_EQ(info->reason(), upper_case(cause_code(cause))) << what;
  EXPECT_EQ(info->domain(), "burnish");
  EXPECT_EQ(info->metadata().at("request_id").size(), 16u);
  EXPECT_FALSE(status.error_message().empty());
}

void expect_http(const HttpResponse& response, Cause cause, const std::string& what) {
  EXPECT_EQ(response.status, status_of(cause).http_status) << what << response.body;
  ASSERT_EQ(response.headers.at("Content-Type"), "application/problem+json") << what;
  EXPECT_EQ(json::parse(response.body)["code"], cause_code(cause)) << what;
}

TEST(Transports, MapEveryCauseByTheSameTable) {
  for (const Cause cause : all_causes()) {
    RunningServer server(any_port(), [cause](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
      return Error{cause, "on purpose", "some_field"};
    });
    const std::string what = std::string(cause_code(cause)) + ": ";
    const grpc::Status status = server.smooth_mesh("anything");
    expect_grpc(status, cause, what);
    EXPECT_EQ(status.error_message(), "on purpose");
    const auto bad_request = detail_of<google::rpc::BadRequest>(status);
    ASSERT_TRUE(bad_request.has_value()) << what;
    EXPECT_EQ(bad_request->field_violations(0).field(), "some_field");
    const bool passes =
        cause == Cause::QueueFull || cause == Cause::MemoryFull || cause == Cause::ShuttingDown;
    EXPECT_EQ(detail_of<google::rpc::RetryInfo>(status).has_value(), passes) << what;
    expect_http(server.http("POST", "/v1/smooth", "anything"), cause, what);
  }
}

// The real service's own reasons, provoked from outside.
TEST(Transports, NameWhatIsWrongWithARealRequest) {
  struct Row {
    const char* name;
    std::string mesh;
    std::string query;
    void (*set)(v1::SmoothOptions&);
    Cause cause;
  };
  const auto nothing = [](v1::SmoothOptions&) {};
  const std::string good(kTetrahedron);
  const Row rows[] = {
      {"bad value", good, "?iterations=100001", [](v1::SmoothOptions& o) { o.set_iterations(100'001); },
       Cause::BadOption},
      {"unknown option", good, "?colour=1",
       [](v1::SmoothOptions& o) { (*o.mutable_parameters())["colour"].set_number_value(1); },
       Cause::UnknownOption},
      {"unknown method", good, "?method=magic", [](v1::SmoothOptions& o) { o.set_method("magic"); },
       Cause::UnknownMethod},
      {"neither OBJ nor Draco", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16), "", nothing,
       Cause::UnsupportedFormat},
      {"half a number", "v 0 0 0\nv 1 x 0\nv 0 1 0\nf 1 2 3\n", "", nothing, Cause::MalformedMesh},
      {"missing vertex", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "", nothing, Cause::IndexOutOfRange},
      {"not a number", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "", nothing, Cause::NonFinitePosition},
      {"no face", "v 0 0 0\nv 1 0 0\n", "", nothing, Cause::EmptyMesh},
      {"no bytes", "", "", nothing, Cause::EmptyMesh},
      {"point cloud", std::string("DRACO\2\2\0\0\0\0\0\0\0\0", 15), "", nothing, Cause::NotATriangleMesh},
      {"too large", good + std::string(70'000, '#'), "", nothing, Cause::TooLarge},
  };
  Config config = any_port();
  config.limits.mesh.max_bytes = 64'000;
  RunningServer server(config);
  for (const Row& row : rows) {
    const std::string what = std::string(row.name) + ": ";
    v1::SmoothRequest request;
    v1::SmoothResponse response;
    request.set_mesh(row.mesh);
    row.set(*request.mutable_options());
    expect_grpc(server.smooth(request, response), row.cause, what);
    expect_http(server.http("POST", "/v1/smooth" + row.query, row.mesh), row.cause, what);
  }
}

TEST(Transports, GiveTheSameBytesAndTheSameReport) {
  const std::string mesh = testing::to_obj(testing::with_noise(testing::sphere(3), 0.02));
  RunningServer server;
  v1::SmoothRequest request;
  v1::SmoothResponse response;
  request.set_mesh(mesh);
  request.mutable_options()->set_method("taubin");
  request.mutable_options()->set_iterations(7);
  const grpc::Status status = server.smooth(request, response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  const HttpResponse http = server.http("POST", "/v1/smooth?method=taubin&iterations=7", mesh);
  ASSERT_EQ(http.status, 200) << http.body;
  EXPECT_EQ(http.body, response.mesh());
  EXPECT_NE(http.body, mesh);
  json by_http = json::parse(http.headers.at("Burnish-Report"));
  json by_grpc = json::parse(to_json(response.report(), true));
  EXPECT_NE(by_http["requestId"], by_grpc["requestId"]);
  for (const char* own : {"requestId", "timings"}) {
    by_http.erase(own);
    by_grpc.erase(own);
  }
  EXPECT_EQ(by_http, by_grpc);
}

TEST(Transports, MeasureAgainstTheReferenceThatWasSent) {
  const auto original = testing::sphere(2);
  RunningServer server;
  v1::SmoothRequest request;
  v1::SmoothResponse response;
  request.set_mesh(testing::to_obj(testing::with_noise(original, 0.02)));
  request.set_reference(testing::to_obj(original));
  ASSERT_TRUE(server.smooth(request, response).ok());
  EXPECT_EQ(response.report().errors().against(), "reference");
  EXPECT_GT(response.report().timings().total_ms(), 0);
}

TEST(Transports, ListTheSameMethods) {
  RunningServer server;
  grpc::ClientContext context;
  v1::ListMethodsResponse response;
  ASSERT_TRUE(server.stub().ListMethods(&context, {}, &response).ok());
  EXPECT_EQ(response.SerializeAsString(), list_methods().SerializeAsString());
  const HttpResponse http = server.http("GET", "/v1/methods");
  EXPECT_EQ(json::parse(http.body), json::parse(to_json(response, true)));
}

TEST(Grpc, LivesOnAfterAMessageBeyondItsLimit) {
  RunningServer server;
  const grpc::Status status = server.smooth_mesh(std::string(20'000'000, ' '));
  expect_grpc(status, Cause::TooLarge, "unary: ");
  EXPECT_TRUE(server.smooth_mesh(std::string(kTetrahedron)).ok()) << "the connection lives on";
}

TEST(Http, AnswersHeadWithoutABody) {
  RunningServer server;
  for (const char* path : {"/v1/methods", "/livez", "/readyz", "/metrics"}) {
    RawHttp connection(server->http_address().port);
    connection.send_request("HEAD", path);
    const HttpResponse head = connection.read_head();
    EXPECT_EQ(head.status, 200) << path;
    EXPECT_NE(head.headers.at("Content-Length"), "0") << path;
    connection.send_request("GET", "/livez");
    EXPECT_EQ(connection.read_response().body, "alive\n") << path << ": a body after HEAD would come first";
  }
}

TEST(Http, AnswersUnknownPathsVerbsAndNoise) {
  RunningServer server;
  expect_http(server.http("GET", "/nowhere"), Cause::NotFound, "path: ");
  expect_http(server.http("POST", "/nowhere", "body"), Cause::NotFound, "path with body: ");
  expect_http(server.http("GET", "/v1/smooth"), Cause::MethodNotAllowed, "verb: ");
  EXPECT_EQ(server.http("PUT", "/v1/smooth", "body").headers.at("Allow"), "POST, OPTIONS");
  EXPECT_EQ(server.http("GET", "/livez", "a body that nobody asked for").status, 200);
  RawHttp connection(server->http_address().port);
  connection.send("this is not HTTP\r\n\r\n");
  const HttpResponse response = connection.read_response();
  EXPECT_EQ(response.status, 400);
  EXPECT_EQ(json::parse(response.body)["code"], "bad_request");
}

TEST(Http, TakesChunkedBodies) {
  RunningServer server;
  RawHttp connection(server->http_address().port);
  connection.send("POST /v1/smooth HTTP/1.1\r\nHost: test\r\nTransfer-Encoding: chunked\r\n\r\n");
  for (std::size_t at = 0; at < kTetrahedron.size(); at += 10) {
    const std::string_view chunk = kTetrahedron.substr(at, 10);
    std::array<char, 8> size{};
    std::snprintf(size.data(), size.size(), "%zx\r\n", chunk.size());
    connection.send(size.data());
    connection.send(chunk);
    connection.send("\r\n");
  }
  connection.send("0\r\n\r\n");
  EXPECT_EQ(connection.read_response().status, 200);
}

TEST(Http, CountsTheBytesOfAChunkedBodyAndStillAnswers) {
  Config config = any_port();
  config.limits.mesh.max_bytes = 100'000;
  RunningServer server(config);
  RawHttp connection(server->http_address().port);
  connection.send("POST /v1/smooth HTTP/1.1\r\nHost: test\r\nTransfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "10000\r\n" + std::string(0x10000, ' ') + "\r\n";
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(connection.send(chunk)) << "the rest must be drained, not reset";
  connection.send("0\r\n\r\n");
  expect_http(connection.read_response(), Cause::TooLarge, "chunked: ");
}

TEST(Http, AnswersATooLargeBodyThatIsSentAnyway) {
  Config config = any_port();
  config.limits.mesh.max_bytes = 1000;
  RunningServer server(config);
  const HttpResponse response = server.http("POST", "/v1/smooth", std::string(8'000'000, ' '));
  expect_http(response, Cause::TooLarge, "with a length: ");
  EXPECT_NE(response.body.find("1000 (max-bytes)"), std::string::npos) << response.body;
}

TEST(Http, AsksForTheBodyOrRefusesItBeforeItIsSent) {
  RunningServer server;
  const auto head = [](std::size_t length) {
    return "POST /v1/smooth HTTP/1.1\r\nHost: test\r\nExpect: 100-continue\r\nContent-Length: " +
           std::to_string(length) + "\r\n\r\n";
  };
  RawHttp good(server->http_address().port);
  good.send(head(kTetrahedron.size()));
  EXPECT_EQ(good.read_head().status, 100);
  good.send(kTetrahedron);
  EXPECT_EQ(good.read_response().status, 200);

  RawHttp large(server->http_address().port);
  large.send(head(std::size_t{1} << 40));
  expect_http(large.read_response(), Cause::TooLarge, "before the body: ");
}

}  // namespace
}  // namespace burnish
