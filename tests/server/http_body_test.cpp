// What requests carry and how: forms, compression, chunks, and their limits.
#include <gtest/gtest.h>

#include <string>

#include "server/http/gzip.h"
#include "tests/server/http_house.h"

namespace burnish {
namespace {

using testing::chunked;
using testing::code_of;
using testing::detail_of;
using testing::form_of;
using testing::HttpHouse;
using testing::kFormType;
using testing::RawHttp;

constexpr std::string_view kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
constexpr std::size_t kLimit = 100'000;  // of a HttpHouse's meshes

std::string packed(std::string_view text) {
  return *gzip(text, [] { return false; });
}

/// A mesh of exactly that size.
std::string mesh_of(std::size_t size) { return std::string(kMesh) + std::string(size - kMesh.size(), '#'); }

TEST(HttpBody, ComesPlainCompressedChunkedAndInForms) {
  HttpHouse house;
  const std::string mesh = mesh_of(50'000), form = form_of({{"options", "{}"}, {"mesh", mesh, "model/obj"}});
  struct Row {
    const char* name;
    std::string headers, body;
  };
  const std::string type(kFormType), gzip_encoding = "Content-Encoding: gzip\r\n";
  const Row rows[] = {
      {"plain", "", mesh},
      {"gzip", gzip_encoding, packed(mesh)},
      {"gzip in two files", gzip_encoding, packed(mesh.substr(0, 20)) + packed(mesh.substr(20))},
      {"form", type, form},
      {"form with text around", type, "preamble\r\n" + form + "epilogue"},
      {"gzip form", type + gzip_encoding, packed(form)}};
  for (const Row& row : rows) {
    EXPECT_EQ(house.call("POST", "/v1/smooth", row.body, row.headers).body, mesh) << row.name;
    for (const std::size_t size : {std::size_t{1}, std::size_t{1000}, std::size_t{70'000}}) {
      RawHttp client(house.port());
      client.send("POST /v1/smooth HTTP/1.1\r\nHost: test\r\nTransfer-Encoding: chunked\r\n" + row.headers +
                  "\r\n" + chunked(row.body, size) + "0\r\n\r\n");
      EXPECT_EQ(client.read_response().body, mesh) << row.name << " in chunks of " << size;
      client.send_request("GET", "/livez");
      EXPECT_EQ(client.read_response().status, 200) << row.name << ": the body was read to its end";
    }
  }
}

TEST(HttpBody, MayBeAsLargeAsTheLimit) {
  HttpHouse house;
  EXPECT_EQ(house.call("POST", "/v1/smooth", mesh_of(kLimit)).status, 200);
  EXPECT_EQ(house.call("POST", "/v1/smooth", packed(mesh_of(kLimit)), "Content-Encoding: gzip\r\n").status,
            200);
  const std::string form = form_of({{"mesh", mesh_of(kLimit)}, {"reference", mesh_of(kLimit)}});
  EXPECT_EQ(house.call("POST", "/v1/smooth", form, kFormType).status, 200);
}

TEST(HttpBody, TellsWhatIsTooLarge) {
  HttpHouse house;
  struct Row {
    const char* name;
    std::string headers, body, blames, flag;
  };
  const std::string type(kFormType);
  const Row rows[] = {
      {"body", "", mesh_of(kLimit + 1), "100001", "(max-bytes)"},
      {"gzip", "Content-Encoding: gzip\r\n", packed(mesh_of(kLimit + 1)), "the body", "(max-bytes)"},
      {"mesh", type, form_of({{"mesh", mesh_of(kLimit + 1)}}), "'mesh'", "(max-bytes)"},
      {"reference", type, form_of({{"mesh", "v"}, {"reference", mesh_of(kLimit + 1)}}), "'reference'",
       "(max-bytes)"},
      {"options", type, form_of({{"options", std::string(66'000, ' ')}}), "'options'", "(max-option-bytes)"},
  };
  for (const Row& row : rows) {
    const auto response = house.call("POST", "/v1/smooth", row.body, row.headers);
    EXPECT_EQ(response.status, 413) << row.name;
    EXPECT_EQ(code_of(response), "too_large") << row.name;
    EXPECT_NE(detail_of(response).find(row.blames), std::string::npos)
        << row.name << ": " << detail_of(response);
    EXPECT_NE(detail_of(response).find(row.flag), std::string::npos)
        << row.name << ": " << detail_of(response);
  }
}

TEST(HttpBody, IsRefusedWhenItBreaksTheRules) {
  HttpHouse house;
  std::string nine_parts, endless_head = "--x\r\n";
  for (int i = 0; i < 9; ++i) nine_parts += "--x\r\nContent-Disposition: form-data; name=\"n\"\r\n\r\n1\r\n";
  while (endless_head.size() < 90'000) endless_head += "a: b\r\n";
  const std::string half = packed(kMesh).substr(0, 30);
  struct Row {
    const char* name;
    std::string headers, body;
  };
  const std::string type(kFormType), gzip_encoding = "Content-Encoding: gzip\r\n";
  const Row rows[] = {
      {"cut gzip", gzip_encoding, half},
      {"no gzip", gzip_encoding, std::string(kMesh)},
      {"no boundary", "Content-Type: multipart/form-data\r\n", form_of({{"mesh", "v"}})},
      {"long boundary", "Content-Type: multipart/form-data; boundary=" + std::string(71, 'x') + "\r\n", "v"},
      {"another boundary", type, std::string(90'000, '-')},
      {"short and another boundary", type, "--y--\r\n"},
      {"endless part head", type, endless_head},
      {"too many parts", type, nine_parts + "--x--\r\n"},
      {"no name", type, "--x\r\nContent-Disposition: form-data; x=y\r\n\r\n1\r\n--x--\r\n"},
      {"noise after a boundary", type, "--x\r\n\r\n1\r\n--x" + std::string(90'000, 'y')},
  };
  for (const Row& row : rows) {
    const auto response = house.call("POST", "/v1/smooth", row.body, row.headers);
    EXPECT_EQ(response.status, 400) << row.name << ": " << response.body;
    EXPECT_EQ(code_of(response), "bad_request") << row.name << ": " << response.body;
  }
}

TEST(HttpBody, IsRefusedByItsHead) {
  HttpHouse house;
  struct Row {
    std::string headers;
    int status;
  };
  const Row rows[] = {{"Content-Encoding: br\r\nContent-Length: 5\r\n", 415},
                      {"Content-Encoding: gzip, gzip\r\nContent-Length: 5\r\n", 415},
                      {"Content-Encoding: gzip\r\nContent-Encoding: gzip\r\nContent-Length: 5\r\n", 415},
                      {"Transfer-Encoding: gzip, chunked\r\n", 400},
                      {"Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n", 400},
                      {"Transfer-Encoding: chunked\r\nContent-Length: 5\r\n", 400},
                      {"Content-Length: 5\r\nContent-Length: 6\r\n", 400},
                      {"Content-Length: -1\r\n", 400},
                      {"Content-Length: 0x5\r\n", 400},
                      {"Content-Length: \r\n", 400},
                      {"Content-Length: 99999999999999999999\r\n", 400},
                      {"Content-Length: 1099511627776\r\n", 413}};
  for (const Row& row : rows) {
    RawHttp client(house.port());
    client.send("POST /v1/smooth HTTP/1.1\r\nHost: test\r\n" + row.headers + "\r\nv 0 0");
    const auto response = client.read_response();
    EXPECT_EQ(response.status, row.status) << row.headers << response.body;
    EXPECT_NE(code_of(response), "") << row.headers;
  }
  const auto known = house.call("POST", "/v1/smooth", "v", "Content-Encoding: br\r\n");
  EXPECT_NE(detail_of(known).find("gzip"), std::string::npos) << detail_of(known);
}

TEST(HttpBody, IsRefusedWhenItsChunksAreBroken) {
  HttpHouse house;
  for (const char* chunks :
       {"xyz\r\n", "3\r\nabcd\r\n", "\r\n", "3\r\nabc0\r\n\r\n", "ffffffffffffffffff\r\n"}) {
    RawHttp client(house.port());
    client.send("POST /v1/smooth HTTP/1.1\r\nHost: test\r\nTransfer-Encoding: chunked\r\n\r\n" +
                std::string(chunks));
    const auto response = client.read_response();
    EXPECT_EQ(code_of(response), "bad_request") << chunks;
    EXPECT_NE(detail_of(response).find("chunked"), std::string::npos) << chunks << detail_of(response);
  }
}

// RFC 9112: without a length there is no body, so what follows is the next request.
TEST(HttpBody, IsEmptyWithoutALength) {
  HttpHouse house;
  RawHttp client(house.port());
  client.send("POST /v1/smooth HTTP/1.1\r\nHost: test\r\n\r\nGET /livez HTTP/1.1\r\nHost: test\r\n\r\n");
  EXPECT_EQ(code_of(client.read_response()), "empty_mesh");
  EXPECT_EQ(client.read_response().body, "alive\n");
}

TEST(HttpBody, CutAnywhereIsRefusedAndCounted) {
  HttpHouse house;
  const std::string form = form_of({{"options", "{}"}, {"mesh", std::string(kMesh), "model/obj"}});
  const std::string whole = "POST /v1/smooth HTTP/1.1\r\nHost: test\r\n" + std::string(kFormType);
  const std::string requests[] = {
      whole + "Content-Length: " + std::to_string(form.size()) + "\r\n\r\n" + form,
      whole + "Transfer-Encoding: chunked\r\n\r\n" + chunked(form, 20) + "0\r\n\r\n"};
  for (const std::string& request : requests) {
    EXPECT_TRUE(house.server->answer(request).starts_with("HTTP/1.1 200 ")) << house.server->answer(request);
    EXPECT_EQ(house.server->answer(""), "");
    for (std::size_t size = 1; size < request.size(); ++size) {
      const std::string answer = house.server->answer(request.substr(0, size));
      ASSERT_TRUE(answer.starts_with("HTTP/1.1 400 ")) << size << ": " << answer;
      ASSERT_NE(answer.find("\"bad_request\""), std::string::npos) << answer;
    }
  }
  const std::string count =
      "burnish_outcomes_total{code=\"bad_request\",kind=\"smooth\",transport=\"http\"} ";
  const std::string metrics = house.house.jobs.metrics_text();
  const std::size_t at = metrics.find(count);
  ASSERT_NE(at, std::string::npos) << metrics;
  EXPECT_EQ(std::stoul(metrics.substr(at + count.size())), requests[0].size() + requests[1].size() - 2);
}

}  // namespace
}  // namespace burnish
