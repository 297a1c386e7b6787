// The page's files out of the program: how they are sent, and to whom.
#include <gtest/gtest.h>

#include <array>

#include "server/http/gzip.h"
#include "tests/server/gateway_house.h"

namespace burnish {
namespace {

using House = testing::GatewayHouse;
using testing::body_of;
using testing::expect_problem;

const std::string kHtml = "<!doctype html><title>page</title>" + std::string(3000, ' ');
const std::string kScript = "console.log('" + std::string(2000, 'x') + "')";

std::string packed(const std::string& content) {
  return *gzip(content, [] { return false; });
}

struct PageHouse : House {
  PageHouse() : House({.gateway = {.page = files()}}) {}

  static std::span<const PageFile> files() {
    static const std::string kPackedHtml = packed(kHtml), kPackedScript = packed(kScript);
    static const std::array kFiles{
        PageFile{"/", "text/html; charset=utf-8", "0a1b", kPackedHtml, kHtml.size()},
        PageFile{"/assets/main-5e.js", "text/javascript; charset=utf-8", "2c3d", kPackedScript,
                 kScript.size()}};
    return kFiles;
  }

  HttpResponse ask(const std::string& path, HttpHeaders headers, const std::string& method = "GET") {
    return handle({.method = method, .path = path, .headers = std::move(headers)});
  }
};

std::string unpacked(std::string_view bytes) {
  std::string content;
  Inflater inflater;
  const auto fed = inflater.feed(bytes, [&](std::string_view piece) {
    content += piece;
    return Result<>();
  });
  EXPECT_TRUE(fed.ok() && inflater.finish().ok());
  return content;
}

TEST(Page, SendsItsFilesAsTheyWereCompressedToWhoAcceptsThat) {
  PageHouse house;
  const HttpResponse response = house.ask("/", {{"Accept-Encoding", "br, gzip"}});
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.headers.at("Content-Encoding"), "gzip");
  EXPECT_EQ(response.headers.at("Vary"), "Accept-Encoding");
  EXPECT_EQ(response.headers.at("Content-Type"), "text/html; charset=utf-8");
  ASSERT_TRUE(response.file.owner);
  EXPECT_EQ(unpacked(response.file.bytes), kHtml);
}

TEST(Page, SendsThemPlainToWhoDoesNot) {
  PageHouse house;
  for (const HttpHeaders& headers : {HttpHeaders{}, HttpHeaders{{"Accept-Encoding", "gzip;q=0"}}}) {
    const HttpResponse response = house.ask("/assets/main-5e.js", headers);
    EXPECT_EQ(response.status, 200);
    EXPECT_FALSE(response.headers.contains("Content-Encoding"));
    EXPECT_EQ(response.headers.at("Vary"), "Accept-Encoding");
    EXPECT_EQ(response.file.bytes, kScript);
  }
}

TEST(Page, LetsBrowsersKeepWhatNeverChangesAndAskForWhatMay) {
  PageHouse house;
  EXPECT_EQ(house.get("/assets/main-5e.js").headers.at("Cache-Control"),
            "public, max-age=31536000, immutable");
  EXPECT_EQ(house.get("/").headers.at("Cache-Control"), "no-cache");
  const std::string etag = house.get("/").headers.at("ETag");
  for (const std::string& known : {etag, std::string("\"0a1b\""), "\"else\", " + etag, std::string("*")}) {
    const HttpResponse response = house.ask("/", {{"If-None-Match", known}});
    EXPECT_EQ(response.status, 304) << known;
    EXPECT_FALSE(response.file.owner);
    EXPECT_EQ(response.headers.at("ETag"), etag);
  }
  EXPECT_EQ(house.ask("/", {{"If-None-Match", "W/\"2c3d\""}}).status, 200);
}

TEST(Page, ForbidsInlineCodeFramesAndOtherServersInEveryFile) {
  PageHouse house;
  for (const char* path : {"/", "/assets/main-5e.js"}) {
    const HttpHeaders headers = house.get(path).headers;
    const std::string& policy = headers.at("Content-Security-Policy");
    EXPECT_TRUE(policy.starts_with("default-src 'self';")) << policy;
    EXPECT_NE(policy.find("frame-ancestors 'none'"), std::string::npos);
    for (const char* never : {"unsafe-inline", "'unsafe-eval'", "http:", "https:", "*"})
      EXPECT_EQ(policy.find(never), std::string::npos) << never;
    EXPECT_EQ(headers.at("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(headers.at("Referrer-Policy"), "no-referrer");
  }
}

TEST(Page, AnswersReadingVerbsOnly) {
  PageHouse house;
  for (const char* path : {"/", "/assets/main-5e.js"}) {
    EXPECT_EQ(house.ask(path, {}, "HEAD").headers.at("ETag"), house.get(path).headers.at("ETag"));
    const HttpResponse options = house.ask(path, {}, "OPTIONS");
    EXPECT_EQ(options.status, 204);
    EXPECT_EQ(options.headers.at("Allow"), "GET, HEAD, OPTIONS");
    for (const char* verb : {"POST", "PUT", "DELETE", "PATCH"}) {
      const HttpResponse refusal = house.ask(path, {}, verb);
      expect_problem(refusal, Cause::MethodNotAllowed);
      EXPECT_EQ(refusal.headers.at("Allow"), "GET, HEAD, OPTIONS");
    }
  }
}

TEST(Page, HasNothingElse) {
  PageHouse house;
  for (const char* path :
       {"/assets/", "/assets/main-5e", "/assets/../assets/main-5e.js", "/index.html", "/assets"}) {
    expect_problem(house.get(path), Cause::NotFound);
  }
}

TEST(Page, SaysThatItWasNotBuilt) {
  House house;
  const HttpResponse response = house.get("/");
  expect_problem(response, Cause::NotFound);
  EXPECT_NE(body_of(response)["detail"].get<std::string>().find("built without its page"), std::string::npos);
}

TEST(Page, IsDamagedRatherThanWrong) {
  static const std::string kCut = packed(kHtml).substr(0, 20);
  static const std::array kFiles{PageFile{"/", "text/html", "0a", kCut, kHtml.size()}};
  House house({.gateway = {.page = kFiles}});
  expect_problem(house.get("/"), Cause::Internal);
}

TEST(Page, IsCachedByOriginToo) {
  House house({.gateway = {.cors_origins = {"https://scans.example"}, .page = PageHouse::files()}});
  EXPECT_EQ(house.get("/").headers.at("Vary"), "Accept-Encoding, Origin");
}

}  // namespace
}  // namespace burnish
