// Answers on the wire: compression, connections that stay open, and the corners of HTTP.
#include <gtest/gtest.h>

#include <string>

#include "server/http/gzip.h"
#include "tests/server/http_house.h"

namespace burnish {
namespace {

using testing::code_of;
using testing::echo;
using testing::HttpHouse;
using testing::RawHttp;

constexpr std::string_view kGzip = "Accept-Encoding: gzip\r\n";

const std::string& mesh() {
  static const std::string text = [] {
    std::string lines;
    for (int i = 0; i < 5000; ++i) lines += "v " + std::to_string(i) + " 0 0\n";
    return lines;
  }();
  return text;
}

std::string plain(std::string_view packed) {
  Inflater inflater;
  std::string text;
  const auto fed = inflater.feed(packed, [&](std::string_view piece) {
    text.append(piece);
    return Result<>();
  });
  return fed && inflater.finish() ? text : "not whole";
}

bool has(const HttpResponse& response, const char* header) { return response.headers.contains(header); }

TEST(HttpAnswer, IsCompressedForWhoAcceptsIt) {
  HttpHouse house;
  const auto packed = house.call("POST", "/v1/smooth", mesh(), kGzip);
  ASSERT_EQ(packed.headers.at("Content-Encoding"), "gzip");
  EXPECT_EQ(packed.headers.at("Vary"), "Accept-Encoding");
  EXPECT_LT(packed.body.size(), mesh().size() / 2);
  EXPECT_EQ(plain(packed.body), mesh());
  for (const char* header : {"", "Accept-Encoding: br, deflate\r\n", "Accept-Encoding: gzip;q=0\r\n"}) {
    const auto whole = house.call("POST", "/v1/smooth", mesh(), header);
    EXPECT_FALSE(has(whole, "Content-Encoding")) << header;
    EXPECT_EQ(whole.headers.at("Vary"), "Accept-Encoding") << "caches must know all the same";
    EXPECT_EQ(whole.body, mesh()) << header;
  }
  for (const char* target : {"/v1/methods", "/metrics", "/openapi.json"}) {
    const auto response = house.call("GET", target, "", kGzip);
    EXPECT_EQ(response.headers.at("Content-Encoding"), "gzip") << target;
    EXPECT_GT(plain(response.body).size(), 1000u) << target;
  }
}

TEST(HttpAnswer, IsNotCompressedWhenThatGainsNothing) {
  HttpHouse house;
  EXPECT_FALSE(has(house.call("GET", "/livez", "", kGzip), "Content-Encoding"));
  HttpHouse draco({}, echo(Format::Draco));
  const auto response = draco.call("POST", "/v1/smooth", mesh(), kGzip);
  EXPECT_EQ(response.headers.at("Content-Type"), "model/vnd.draco");
  EXPECT_FALSE(has(response, "Content-Encoding"));
  EXPECT_EQ(response.body, mesh());
}

TEST(HttpAnswer, ToHeadIsTheHeadOfTheAnswerToGet) {
  HttpHouse house;
  for (const char* target : {"/livez", "/v1/methods", "/nowhere", "/v1/smooth"}) {
    for (const std::string_view headers : {std::string_view(), kGzip}) {
      const auto get = house.call("GET", target, "", headers);
      RawHttp client(house.port());
      client.send_request("HEAD", target, "", headers);
      auto head = client.read_head();
      EXPECT_EQ(head.status, get.status) << target;
      for (const char* name : {"Content-Type", "Content-Length"})
        EXPECT_EQ(head.headers.at(name), get.headers.at(name));
      EXPECT_EQ(has(head, "Content-Encoding"), has(get, "Content-Encoding")) << target;
      EXPECT_FALSE(has(head, "Accept-Ranges"));
      client.send_request("GET", "/livez");
      EXPECT_EQ(client.read_response().body, "alive\n") << target << ": a body after HEAD would come first";
    }
  }
}

TEST(HttpAnswer, IsWholeWhateverTheRange) {
  HttpHouse house;
  const auto methods = house.call("GET", "/v1/methods").body;
  for (const char* range :
       {"bytes=0-9", "bytes=5-2", "bytes=999999999-", "bytes=0-1,2-3", "lines=1-2", "nonsense", ""}) {
    const std::string header = "Range: " + std::string(range) + "\r\n";
    const auto post = house.call("POST", "/v1/smooth", mesh(), header);
    EXPECT_EQ(post.status, 200) << range;
    EXPECT_EQ(post.body, mesh()) << range;
    const auto get = house.call("GET", "/v1/methods", "", header);
    EXPECT_EQ(get.status, 200) << range;
    EXPECT_EQ(get.body, methods) << range;
  }
}

TEST(HttpAnswer, IsNoWebSocket) {
  HttpHouse house;
  const std::string upgrade =
      "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
      "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  EXPECT_EQ(house.call("GET", "/livez", "", upgrade).body, "alive\n");
  EXPECT_EQ(house.call("GET", "/nowhere", "", upgrade).status, 404);
}

TEST(HttpAnswer, ComesInTheOrderOfPipelinedRequests) {
  HttpHouse house;
  const std::string post = "POST /v1/smooth HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\n\r\n";
  RawHttp client(house.port());
  client.send("GET /livez HTTP/1.1\r\nHost: x\r\n\r\n" + post + "first\r\n" + post + "other" +
              "GET /nowhere HTTP/1.1\r\n\r\nGET /readyz HTTP/1.1\r\n\r\n");
  EXPECT_EQ(client.read_response().body, "alive\n");
  EXPECT_EQ(client.read_response().body, "first");
  EXPECT_EQ(client.read_response().body, "other");
  EXPECT_EQ(client.read_response().status, 404);
  EXPECT_EQ(client.read_response().body, "ready\n");
}

TEST(HttpAnswer, KeepsTheConnectionAfterErrorsWithSmallBodies) {
  HttpHouse house;
  RawHttp client(house.port());
  for (int i = 0; i < 3; ++i) {
    client.send_request("POST", "/v1/smooth?colour=1", std::string(90'000, ' '));
    auto refused = client.read_response();
    EXPECT_EQ(code_of(refused), "unknown_option");
    EXPECT_FALSE(has(refused, "Connection"));
    client.send_request("GET", "/livez", "a body that nobody asked for");
    EXPECT_EQ(client.read_response().status, 200);
  }
}

TEST(HttpAnswer, ClosesWhenTheClientWantsIt) {
  HttpHouse house;
  for (const char* request :
       {"GET /livez HTTP/1.1\r\nConnection: Close\r\n\r\n",
        "GET /livez HTTP/1.1\r\nConnection: x, close\r\n\r\n", "GET /livez HTTP/1.0\r\n\r\n"}) {
    RawHttp client(house.port());
    client.send(request);
    const auto response = client.read_response();
    EXPECT_EQ(response.body, "alive\n") << request;
    EXPECT_EQ(response.headers.at("Connection"), "close") << request;
    EXPECT_TRUE(client.at_end()) << request;
  }
  RawHttp old(house.port());
  for (int i = 0; i < 2; ++i) {
    old.send("GET /livez HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
    EXPECT_EQ(old.read_response().headers.at("Connection"), "keep-alive");
  }
}

TEST(HttpAnswer, AsksForTheBodyOrRefusesItBeforeItIsSent) {
  HttpHouse house;
  const auto head = [](std::size_t length) {
    return "POST /v1/smooth HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: " +
           std::to_string(length) + "\r\n\r\n";
  };
  RawHttp good(house.port());
  good.send(head(5));
  EXPECT_EQ(good.read_head().status, 100);
  good.send("bytes");
  EXPECT_EQ(good.read_response().body, "bytes");
  RawHttp large(house.port());
  large.send(head(200'000));
  const auto refused = large.read_response();
  EXPECT_EQ(code_of(refused), "too_large");
  EXPECT_EQ(refused.headers.at("Connection"), "close") << "nobody knows whether the body comes";
}

TEST(HttpAnswer, NamesWhatIsNoHttp) {
  HttpHouse house;
  struct Row {
    std::string request;
    int status;
  };
  std::string many_headers = "GET /livez HTTP/1.1\r\n";
  for (int i = 0; i < 101; ++i) many_headers += "a: b\r\n";
  const Row rows[] = {{"this is not HTTP\r\n\r\n", 400},
                      {std::string("\0\1\2\xff\r\n\r\n", 8), 400},
                      {"GET /livez HTTP/2.0\r\n\r\n", 400},
                      {"BREW /pot HTTP/1.1\r\n\r\n", 400},
                      {"GET /livez HTTP/1.1\r\nno colon\r\n\r\n", 400},
                      {many_headers + "\r\n", 400},
                      {"GET /" + std::string(9000, 'a') + " HTTP/1.1\r\n\r\n", 414},
                      {"GET /" + std::string(40'000, 'a') + " HTTP/1.1\r\n\r\n", 414},
                      {"GET " + std::string(40'000, ' ') + "/ HTTP/1.1\r\n\r\n", 414},
                      {"GET / HTTP/1.1\r\nx: " + std::string(9000, 'a') + "\r\n\r\n", 400},
                      {"GET / HTTP/1.1\r\nx: " + std::string(70'000, 'a') + "\r\n\r\n", 431}};
  for (const Row& row : rows) {
    RawHttp client(house.port());
    client.send(row.request);
    const auto response = client.read_response();
    EXPECT_EQ(response.status, row.status) << row.request.substr(0, 50);
    EXPECT_EQ(code_of(response), "bad_request") << row.request.substr(0, 50);
    EXPECT_TRUE(client.at_end()) << "what follows cannot be understood either";
  }
}

TEST(HttpAnswer, IsTheSameFromMemory) {
  HttpHouse house;
  const std::string requests =
      "GET /livez HTTP/1.1\r\nHost: x\r\n\r\nPOST /nowhere HTTP/1.1\r\nContent-Length: "
      "3\r\nBurnish-Request-Id: a\r\n\r\nabc"
      "POST /v1/smooth HTTP/1.1\r\nContent-Length: 5\r\nBurnish-Request-Id: b\r\n\r\nbytes"
      "GET /v1/methods HTTP/1.1\r\nAccept-Encoding: gzip\r\nBurnish-Request-Id: c\r\n\r\n"
      "GET /livez HTTP/1.1\r\nBurnish-Request-Id: d\r\nContent-";
  RawHttp client(house.port());
  client.send(requests);
  client.half_close();
  const auto without_ids = [](std::string answers) {  // of the first and last request, which gave none
    const std::string name = "Burnish-Request-Id: ";
    for (std::size_t at = 0; (at = answers.find(name, at)) != std::string::npos; ++at) {
      answers.erase(at + name.size(), answers.find("\r\n", at) - at - name.size());
    }
    for (std::size_t at = 0; (at = answers.find("\"requestId\":\"", at)) != std::string::npos; ++at) {
      answers.erase(at, answers.find('}', at) - at);
    }
    for (std::size_t at = 0; (at = answers.find("Burnish-Report: ", at)) != std::string::npos;) {
      answers.erase(at, answers.find("\r\n", at) - at);
    }
    return answers;
  };
  const std::string by_socket = without_ids(client.read_all());
  EXPECT_EQ(without_ids(house.server->answer(requests)), by_socket);
  EXPECT_NE(by_socket.find("HTTP/1.1 400 "), std::string::npos) << "the last one is cut";
  const auto closed = HttpServer::without_port({}, house.house.gateway, house.house.jobs);
  EXPECT_EQ(without_ids(closed->answer(requests)), by_socket);
}

}  // namespace
}  // namespace burnish
