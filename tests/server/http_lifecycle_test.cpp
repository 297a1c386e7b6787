// Clients that leave, servers that end, and Unix sockets.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <memory>
#include <string>

#include "tests/server/gate.h"
#include "tests/server/http_house.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::answer_with;
using testing::code_of;
using testing::echo;
using testing::eventually;
using testing::Gate;
using testing::HttpHouse;
using testing::RawHttp;

Address unix_address() {
  return {.host = "", .port = 0, .path = fs::temp_directory_path() / ("burnish_" + new_request_id())};
}
HttpServerOptions on(const Address& address) { return {.listen = address}; }
std::string request_of(std::string_view version) {
  return "POST /v1/smooth HTTP/" + std::string(version) + "\r\nContent-Length: 5\r\n\r\nbytes";
}

/// A house whose only job waits at a gate, asked for by a client over TCP or a Unix socket.
struct WaitingClient {
  explicit WaitingClient(bool over_unix, std::string_view version = "1.1")
      : address(over_unix ? unix_address() : Address()), house(on(address), gate.smoother()) {
    client = over_unix ? std::make_unique<RawHttp>(address.path) : std::make_unique<RawHttp>(house.port());
    client->send(request_of(version));
    gate.wait_for(1);
  }
  bool job_ends() {
    return eventually([&] { return house.house.runner.running() == 0; });
  }

  Gate gate;
  Address address;
  HttpHouse house;
  std::unique_ptr<RawHttp> client;
};

TEST(HttpClientGone, EndsItsJob) {
  for (const bool over_unix : {false, true}) {
    for (const auto leave : {&RawHttp::close, &RawHttp::reset}) {
      WaitingClient waiting(over_unix);
      std::invoke(leave, *waiting.client);
      EXPECT_TRUE(waiting.job_ends()) << over_unix;
    }
  }
}

// An interim answer would be an error in HTTP/1.0, so there a closed sending side must do.
TEST(HttpClientGone, EndsItsJobInTheOldVersionToo) {
  WaitingClient waiting(false, "1.0");
  waiting.client->close();
  EXPECT_TRUE(waiting.job_ends());
}

// As "nc -N" does: it has said all it wants, and reads.
TEST(HttpClientGone, IsNotSaidOfOneWhoOnlyStoppedSending) {
  for (const bool over_unix : {false, true}) {
    WaitingClient waiting(over_unix);
    waiting.client->half_close();
    if (!over_unix) {
      EXPECT_EQ(waiting.client->read_head().status, 100) << "the question that tells the two apart";
    }
    EXPECT_EQ(waiting.house.house.runner.running(), 1u);
    waiting.gate.open();
    const auto response = waiting.client->read_response();
    EXPECT_EQ(response.status, 200) << over_unix;
    EXPECT_EQ(response.body, "bytes");
    EXPECT_TRUE(waiting.client->at_end());
  }
}

TEST(HttpStop, EndsConnectionsThatAskNothing) {
  HttpHouse house;
  RawHttp silent(house.port()), idle(house.port());
  idle.send_request("GET", "/livez");
  EXPECT_EQ(idle.read_response().status, 200);
  const auto begun = std::chrono::steady_clock::now();
  house.server->stop(seconds(60));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, seconds(2));
  EXPECT_EQ(idle.read_all(), "");
  EXPECT_EQ(silent.read_all(), "");
  house.server->stop(seconds(60));
}

TEST(HttpStop, RefusesWhatIsStillComing) {
  HttpHouse house;
  RawHttp head(house.port()), body(house.port());
  head.send("GET /livez HT");
  body.send("POST /v1/smooth HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 90\r\n\r\n");
  EXPECT_EQ(body.read_head().status, 100) << "its body is awaited";
  // A head gives no sign of having arrived, so its connection is told or closed.
  auto stopping = std::async(std::launch::async, [&] { house.server->stop(seconds(60)); });
  EXPECT_EQ(code_of(body.read_response()), "shutting_down");
  EXPECT_TRUE(body.at_end());
  const auto told = head.read_response();
  EXPECT_TRUE(told.status == 0 || code_of(told) == "shutting_down") << told.body;
  head.close();
  body.close();
  stopping.get();
}

TEST(HttpStop, WritesTheAnswerToAcceptedRequests) {
  const std::string large(32 << 20, 'x');
  HttpHouse house({}, answer_with(large));
  RawHttp client(house.port());
  client.send_request("POST", "/v1/smooth", "bytes");
  EXPECT_EQ(client.read_head().status, 200);
  auto stopping = std::async(std::launch::async, [&] { house.server->stop(seconds(60)); });
  EXPECT_EQ(client.read_all().size(), large.size());
  stopping.get();
}

TEST(HttpStop, EndsWithinItsPatienceWhateverClientsDo) {
  const std::string large(64 << 20, 'x');
  HttpHouse house({}, answer_with(large));
  RawHttp stalled(house.port()), sending(house.port()), head(house.port());
  stalled.send_request("POST", "/v1/smooth", "bytes");
  EXPECT_EQ(stalled.read_head().status, 200);
  sending.send("POST /v1/smooth HTTP/1.1\r\nContent-Length: 900000000\r\n\r\n");
  EXPECT_EQ(sending.read_response().status, 413);
  head.send("GET");
  const auto begun = std::chrono::steady_clock::now();
  house.server->stop(milliseconds(200));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, seconds(5));
}

TEST(HttpStop, CancelsJobsThatOutlastItsPatience) {
  WaitingClient waiting(false);
  waiting.house.server->stop(milliseconds(50));
  EXPECT_TRUE(waiting.job_ends());
}

TEST(HttpAddress, MayBeIPv6) {
  HttpServerOptions options;
  options.listen = {.host = "::1", .port = 0};
  testing::GatewayHouse house;
  const auto server = HttpServer::start(options, house.gateway, house.jobs);
  if (!server) GTEST_SKIP() << "no IPv6 here: " << server.error().message;
  EXPECT_GT(server.value()->address().port, 0);
}

TEST(HttpAddress, ThatIsTakenIsAnError) {
  HttpHouse house;
  HttpServerOptions options;
  options.listen = house.server->address();
  const auto second = HttpServer::start(options, house.house.gateway, house.house.jobs);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().cause, Cause::BadOption);
  EXPECT_NE(second.error().message.find(options.listen.text()), std::string::npos) << second.error().message;
  options.listen = {.host = "no such host.invalid", .port = 0};
  EXPECT_FALSE(HttpServer::start(options, house.house.gateway, house.house.jobs).ok());
}

TEST(HttpUnixSocket, ServesAndLeavesNoFile) {
  const Address address = unix_address();
  {
    HttpHouse house(on(address));
    EXPECT_EQ(house.server->address(), address);
    RawHttp client(address.path);
    client.send_request("POST", "/v1/smooth", "bytes");
    EXPECT_EQ(client.read_response().body, "bytes");
    const auto second = HttpServer::start(on(address), house.house.gateway, house.house.jobs);
    EXPECT_FALSE(second.ok()) << "it is in use";
    RawHttp again(address.path);
    again.send_request("GET", "/livez");
    EXPECT_EQ(again.read_response().status, 200) << "and stays so";
  }
  EXPECT_FALSE(fs::exists(address.path));
}

TEST(HttpUnixSocket, SparesAFileThatIsAnothersByNow) {
  const Address address = unix_address();
  HttpHouse house(on(address));
  fs::rename(address.path, address.path + ".old");
  std::ofstream(address.path) << "another's";
  house.server->stop(seconds(1));
  EXPECT_TRUE(fs::exists(address.path));
  fs::remove(address.path);
  fs::remove(address.path + ".old");
}

}  // namespace
}  // namespace burnish
