// Clients that send too much, too slowly or nonsense, and what honest ones notice of it.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/http/gzip.h"
#include "tests/client/temporary_folder.h"
#include "tests/server/gate.h"
#include "tests/server/http_house.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::answer_with;
using testing::code_of;
using testing::eventually;
using testing::HttpHouse;
using testing::RawHttp;

constexpr std::string_view kChunked =
    "POST /v1/smooth HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n";
constexpr std::uint64_t kLittle = 30 << 20;  ///< of memory

HttpServerOptions with(const HttpPatience& patience) { return {.patience = patience}; }

/// What the process grew by, at most `kLittle`; nothing is told under a sanitizer.
void expect_little_growth(std::uint64_t before) {
  if (!testing::kMemoryIsTelling) return;
  EXPECT_LT(testing::resident_memory(), before + kLittle);
}

TEST(HttpHostile, ChunkedBodyWithoutEndIsRefusedWithoutBeingKept) {
  HttpHouse house;
  const auto before = testing::resident_memory();
  RawHttp client(house.port());
  client.send(kChunked);
  const std::string chunk = "100000\r\n" + std::string(0x100000, ' ') + "\r\n";
  for (int i = 0; i < 300; ++i) ASSERT_TRUE(client.send(chunk)) << i << ": a reset could hide the answer";
  EXPECT_EQ(code_of(client.read_response()), "too_large");
  expect_little_growth(before);
}

TEST(HttpHostile, GzipBombIsNotInflated) {
  HttpHouse house;
  const std::string bomb = *gzip(std::string(64 << 20, '\0'), [] { return false; });
  const auto before = testing::resident_memory();
  RawHttp client(house.port());
  client.send_request("POST", "/v1/smooth", bomb, "Content-Encoding: gzip\r\n");
  EXPECT_EQ(code_of(client.read_response()), "too_large");
  client.send_request("GET", "/livez");
  EXPECT_EQ(client.read_response().status, 200) << "its few bytes are skipped";
  expect_little_growth(before);
}

TEST(HttpHostile, EndlessHeadsAreCutOff) {
  HttpHouse house;
  const auto before = testing::resident_memory();
  std::string headers;
  for (int i = 0; i < 50'000; ++i) headers += "a" + std::to_string(i) + ": b\r\n";
  for (const std::string& endless : {headers, std::string(10 << 20, 'a'), std::string(1 << 20, '\n')}) {
    RawHttp client(house.port());
    client.send("GET / HTTP/1.1\r\n" + endless);
    const auto response = client.read_response();
    EXPECT_EQ(response.status, 431);
    EXPECT_EQ(code_of(response), "bad_request");
  }
  expect_little_growth(before);
}

TEST(HttpHostile, HeadThatComesTooSlowlyIsTimedOut) {
  HttpHouse house(with({.head = milliseconds(50)}));
  for (const char* part : {"G", "GET / HTTP/1.1\r\n", "GET / HTTP/1.1\r\nHost: x\r\n"}) {
    RawHttp client(house.port());
    client.send(part);
    const auto response = client.read_response();
    EXPECT_EQ(response.status, 408) << part;
    EXPECT_EQ(code_of(response), "request_timeout") << part;
    EXPECT_TRUE(client.at_end()) << part;
  }
}

TEST(HttpHostile, SecondHeadThatComesTooSlowlyIsTimedOut) {
  HttpHouse house(with({.head = milliseconds(50), .idle = seconds(50)}));
  RawHttp client(house.port());
  client.send("GET /livez HTTP/1.1\r\n\r\nGET");
  EXPECT_EQ(client.read_response().status, 200);
  EXPECT_EQ(client.read_response().status, 408);
}

TEST(HttpHostile, ConnectionThatAsksNothingIsClosed) {
  HttpHouse house(with({.head = milliseconds(50), .idle = milliseconds(50)}));
  RawHttp silent(house.port()), satisfied(house.port());
  satisfied.send_request("GET", "/livez");
  EXPECT_EQ(satisfied.read_response().status, 200);
  EXPECT_EQ(silent.read_all(), "");
  EXPECT_EQ(satisfied.read_all(), "");
}

TEST(HttpHostile, BodyThatComesTooSlowlyIsTimedOut) {
  HttpHouse house(with({.body = milliseconds(50), .min_body_rate = 1000}));
  const std::string length = "POST /v1/smooth HTTP/1.1\r\nHost: x\r\nContent-Length: 90000\r\n\r\n";
  for (const std::string& request : {length, length + "v 0 0 0\n", std::string(kChunked) + "10\r\nv 0"}) {
    RawHttp client(house.port());
    client.send(request);
    const auto response = client.read_response();
    EXPECT_EQ(response.status, 408) << request;
    EXPECT_NE(testing::detail_of(response).find("(min-body-rate)"), std::string::npos) << response.body;
    EXPECT_TRUE(client.at_end());
  }
}

TEST(HttpHostile, SlowConnectionsDoNotSlowAnHonestOne) {
  HttpHouse house(with({.head = seconds(60), .body = seconds(60)}));
  std::vector<std::unique_ptr<RawHttp>> slow;
  for (int i = 0; i < 200; ++i) {
    slow.push_back(std::make_unique<RawHttp>(house.port()));
    slow.back()->send(i % 2 == 0 ? "POST /v1/smo" : std::string(kChunked) + "1\r\nv\r\n");
  }
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_EQ(house.call("POST", "/v1/smooth", "bytes").body, "bytes");
  EXPECT_EQ(house.call("GET", "/livez").status, 200);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, seconds(30)) << "none of them had timed out yet";
}

TEST(HttpHostile, ReaderWhoStallsLosesItsConnection) {
  const std::string large(64 << 20, 'x');
  HttpHouse house(with({.stall = milliseconds(100)}), answer_with(large));
  RawHttp client(house.port());
  client.send_request("POST", "/v1/smooth", "bytes");
  EXPECT_EQ(client.read_head().status, 200);
  const auto begun = std::chrono::steady_clock::now();
  house.server->stop(seconds(60));  // waits for answers that are being read
  EXPECT_LT(std::chrono::steady_clock::now() - begun, seconds(30));
  EXPECT_LT(client.read_all().size(), large.size()) << "nobody waited for a reader who takes nothing";
}

TEST(HttpHostile, ConnectionBeyondTheLimitIsToldSoAndOthersGoOn) {
  HttpServerOptions options;
  options.max_connections = 2;
  HttpHouse house(options);
  RawHttp first(house.port()), second(house.port());
  for (RawHttp* each : {&first, &second}) {
    each->send_request("GET", "/livez");
    EXPECT_EQ(each->read_response().status, 200);
  }
  for (int i = 0; i < 300; ++i) {
    RawHttp third(house.port());
    third.send_request("POST", "/v1/smooth", "bytes");
    const auto refused = third.read_response();
    ASSERT_EQ(refused.status, 429) << i;
    EXPECT_EQ(code_of(refused), "queue_full");
    EXPECT_EQ(refused.headers.at("Retry-After"), "1");
  }
  first.send_request("GET", "/livez");
  EXPECT_EQ(first.read_response().status, 200);
  first.close();
  EXPECT_TRUE(eventually([&] { return house.call("GET", "/livez").status == 200; }))
      << "its place is free again";
}

TEST(HttpHostile, RefusedBodyIsDroppedAndTheConnectionGoesOn) {
  const cli::TemporaryFolder folder;
  std::array<Address, 2> addresses;
  addresses[1].path = folder / "socket";
  for (const Address& listen : addresses) {
    HttpHouse house({.listen = listen});
    RawHttp client = listen.is_unix() ? RawHttp(listen.path) : RawHttp(house.port());
    for (const std::size_t size : {0, 1, 20'000, 1'000'000}) {
      ASSERT_TRUE(client.send_request("POST", "/v1/smooth?colour=red", std::string(size, ' ')));
      EXPECT_NE(code_of(client.read_response()), "") << size;
      client.send_request("GET", "/livez");
      EXPECT_EQ(client.read_response().status, 200) << size;
    }
  }
}

TEST(HttpHostile, LargeRefusedBodyDoesNotHideItsAnswer) {
  HttpHouse house;
  for (const char* headers :
       {"", "Content-Type: multipart/form-data; boundary=x\r\n", "Content-Encoding: br\r\n"}) {
    RawHttp client(house.port());
    ASSERT_TRUE(client.send_request("POST", "/v1/smooth", std::string(20 << 20, ' '), headers)) << headers;
    const auto response = client.read_response();
    EXPECT_NE(code_of(response), "") << headers;
    EXPECT_EQ(response.headers.at("Connection"), "close") << headers;
    const auto answered = std::chrono::steady_clock::now();
    EXPECT_TRUE(client.at_end());
    EXPECT_LT(std::chrono::steady_clock::now() - answered, seconds(1)) << "told at once, closed later";
  }
}

}  // namespace
}  // namespace burnish
