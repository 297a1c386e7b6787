// /v1/jobs and /v1/uploads, from request to response and over a socket.
#include <gtest/gtest.h>

#include <string>

#include "server/http/byte_range.h"
#include "server/store/file_store.h"
#include "tests/server/gate.h"
#include "tests/server/http_house.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

using nlohmann::json;
using testing::chunked;
using testing::code_of;
using testing::echo;
using testing::eventually;
using testing::form_of;
using testing::Gate;
using testing::HttpHouse;
using testing::kFormType;
using testing::RawHttp;

const std::string kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

json body_of(const HttpResponse& response) { return json::parse(response.body); }

/// The id of a job that has ended.
std::string ended_job(HttpHouse& house, const std::string& mesh = kMesh) {
  const auto submitted = house.call("POST", "/v1/jobs", mesh);
  EXPECT_EQ(submitted.status, 202) << submitted.body;
  const std::string id = body_of(submitted)["id"];
  EXPECT_EQ(house.call("GET", "/v1/jobs/" + id, "", "Prefer: wait=60\r\n").status, 200);
  return id;
}

// ---- Jobs ----

TEST(JobsApi, AnswersWhereTheJobIsAndWhenToLookAgain) {
  HttpHouse house;
  const auto submitted = house.call("POST", "/v1/jobs?method=taubin&iterations=3", kMesh);
  EXPECT_EQ(submitted.status, 202);
  const json job = body_of(submitted);
  EXPECT_EQ(submitted.headers.at("Location"), "/v1/jobs/" + std::string(job["id"]));
  EXPECT_GE(std::stoi(submitted.headers.at("Retry-After")), 1);
  EXPECT_EQ(job["state"], "JOB_STATE_QUEUED");
  EXPECT_EQ(job["options"]["method"], "taubin");
  EXPECT_EQ(job["mesh"]["sha256"], sha256_of(kMesh));
  const auto waited = house.call("GET", submitted.headers.at("Location"), "", "Prefer: wait=60\r\n");
  EXPECT_EQ(waited.headers.at("Preference-Applied"), "wait=60");
  EXPECT_EQ(body_of(waited)["state"], "JOB_STATE_SUCCEEDED");
  EXPECT_EQ(waited.headers.count("Retry-After"), 0U);
  const auto mesh = house.call("GET", submitted.headers.at("Location") + "/mesh");
  EXPECT_EQ(mesh.body, kMesh);
  EXPECT_EQ(mesh.headers.at("Content-Type"), "model/obj");
  EXPECT_EQ(mesh.headers.count("Burnish-Report"), 1U);
  EXPECT_EQ(house.call("GET", submitted.headers.at("Location") + "/report").status, 200);
}

TEST(JobsApi, TakesMeshesByTheirHashAndFromForms) {
  HttpHouse house;
  ended_job(house);
  const std::string sha256 = sha256_of(kMesh);
  const auto by_query = house.call("POST", "/v1/jobs?method=laplacian&priority=low&mesh_sha256=" + sha256);
  EXPECT_EQ(by_query.status, 202) << by_query.body;
  EXPECT_EQ(body_of(by_query)["priority"], "JOB_PRIORITY_LOW");
  const auto by_part = house.call(
      "POST", "/v1/jobs",
      form_of({{"mesh_sha256", sha256}, {"options", R"({"method":"taubin"})"}, {"priority", "low"}}),
      kFormType);
  EXPECT_EQ(by_part.status, 202) << by_part.body;
  EXPECT_EQ(body_of(by_part)["options"]["method"], "taubin");
  const auto with_bytes =
      house.call("POST", "/v1/jobs", form_of({{"mesh", kMesh}, {"reference_sha256", sha256}}), kFormType);
  EXPECT_EQ(with_bytes.status, 202) << with_bytes.body;
  EXPECT_EQ(body_of(with_bytes)["reference"]["sha256"], sha256);
}

TEST(JobsApi, SaysWhatIsWrongWithASubmission) {
  HttpHouse house;
  const std::string sha256 = sha256_of(kMesh);
  struct Row {
    std::string target, body, headers, code;
  };
  for (const Row& row :
       {Row{"/v1/jobs", "", "", "empty_mesh"}, Row{"/v1/jobs?mesh_sha256=" + sha256, "", "", "not_found"},
        Row{"/v1/jobs?mesh_sha256=12", "", "", "bad_option"},
        Row{"/v1/jobs?mesh_sha256=" + sha256, kMesh, "", "bad_option"},
        Row{"/v1/jobs?priority=high", kMesh, "", "bad_option"},
        Row{"/v1/jobs?priority=low&priority=normal", kMesh, "", "unknown_option"},
        Row{"/v1/jobs?method=none", kMesh, "", "unknown_method"},
        Row{"/v1/jobs?colour=red", kMesh, "", "unknown_option"},
        Row{"/v1/jobs", kMesh, "Content-Type: image/png\r\n", "unsupported_format"},
        Row{"/v1/jobs", kMesh, "Idempotency-Key: a b\r\n", "bad_option"},
        Row{"/v1/jobs", std::string(100'001, ' '), "", "too_large"},
        Row{"/v1/jobs", form_of({{"mesh", kMesh}, {"colour", "red"}}), std::string(kFormType),
            "unknown_option"},
        Row{"/v1/jobs", form_of({{"mesh", kMesh}, {"mesh_sha256", sha256}}), std::string(kFormType),
            "bad_option"}}) {
    EXPECT_EQ(code_of(house.call("POST", row.target, row.body, row.headers)), row.code)
        << row.target << row.body;
  }
  EXPECT_EQ(code_of(house.call("GET", "/v1/jobs?page_size=0")), "bad_option");
  EXPECT_EQ(code_of(house.call("GET", "/v1/jobs?page_token=x")), "bad_option");
  EXPECT_EQ(code_of(house.call("GET", "/v1/jobs?colour=red")), "unknown_option");
  for (const char* path : {"/v1/jobs/0", "/v1/jobs/0/mesh", "/v1/jobs/0/report", "/v1/jobs/0/events"})
    EXPECT_EQ(code_of(house.call("GET", path)), "not_found") << path;
  EXPECT_EQ(code_of(house.call("DELETE", "/v1/jobs/0")), "not_found");
  EXPECT_EQ(body_of(house.call("GET", "/v1/jobs"))["jobs"].size(), 0U) << "what is refused is no job";
}

TEST(JobsApi, GivesTheSameJobForTheSameKey) {
  HttpHouse house;
  const auto submit = [&](const std::string& query) {
    return house.call("POST", "/v1/jobs" + query, kMesh, "Idempotency-Key: scan-7\r\n");
  };
  const auto first = submit(""), again = submit(""), other = submit("?method=taubin");
  EXPECT_EQ(body_of(again)["id"], body_of(first)["id"]);
  EXPECT_EQ(code_of(other), "idempotency_key_reused");
}

TEST(JobsApi, ServesPartsOfAMesh) {
  HttpHouse house;
  const std::string mesh = "/v1/jobs/" + ended_job(house) + "/mesh";
  const std::string size = std::to_string(kMesh.size());
  const auto whole = house.call("GET", mesh);
  const std::string etag = whole.headers.at("ETag");
  EXPECT_EQ(etag, '"' + sha256_of(kMesh) + '"');
  EXPECT_EQ(whole.headers.at("Accept-Ranges"), "bytes");
  const auto part = house.call("GET", mesh, "", "Range: bytes=2-5\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, kMesh.substr(2, 4));
  EXPECT_EQ(part.headers.at("Content-Range"), "bytes 2-5/" + size);
  EXPECT_EQ(house.call("GET", mesh, "", "Range: bytes=-3\r\n").body, kMesh.substr(kMesh.size() - 3));
  EXPECT_EQ(house.call("GET", mesh, "", "Range: bytes=5-\r\nIf-Range: " + etag + "\r\n").body,
            kMesh.substr(5));
  EXPECT_EQ(house.call("GET", mesh, "", "Range: bytes=5-\r\nIf-Range: \"old\"\r\n").body, kMesh);
  const auto beyond = house.call("GET", mesh, "", "Range: bytes=9999-\r\n");
  EXPECT_EQ(code_of(beyond), "range_not_satisfiable");
  EXPECT_EQ(beyond.headers.at("Content-Range"), "bytes */" + size);
  EXPECT_EQ(house.call("GET", mesh, "", "If-None-Match: \"x\", " + etag + "\r\n").status, 304);
  RawHttp head(house.port());
  head.send_request("HEAD", mesh);
  EXPECT_EQ(head.read_head().headers.at("Content-Length"), size);
}

TEST(JobsApi, SendsWhoWantsAMeshToIt) {
  HttpHouse house;
  const std::string job = "/v1/jobs/" + ended_job(house);
  const auto sent = house.call("GET", job, "", "Accept: model/obj\r\n");
  EXPECT_EQ(sent.status, 303);
  EXPECT_EQ(sent.headers.at("Location"), job + "/mesh");
  EXPECT_EQ(house.call("GET", job, "", "Accept: */*\r\n").status, 200);
}

TEST(JobsApi, CancelsFirstAndRemovesThen) {
  Gate gate;
  HttpHouse house({}, gate.smoother());
  const std::string job = "/v1/jobs/" + std::string(body_of(house.call("POST", "/v1/jobs", kMesh))["id"]);
  gate.wait_for(1);
  EXPECT_EQ(code_of(house.call("GET", job + "/mesh")), "not_ready");
  EXPECT_EQ(house.call("GET", job + "/mesh").headers.count("Retry-After"), 1U);
  const auto cancelled = house.call("DELETE", job);
  EXPECT_EQ(cancelled.status, 202);
  EXPECT_EQ(body_of(cancelled)["state"], "JOB_STATE_CANCELLED");
  EXPECT_EQ(body_of(house.call("GET", job))["error"]["code"], "CANCELLED");
  EXPECT_EQ(house.call("DELETE", job).status, 204);
  EXPECT_EQ(code_of(house.call("GET", job)), "not_found");
}

TEST(JobsApi, TellsEventsUntilTheJobHasEnded) {
  Gate gate;
  HttpHouse house({}, gate.smoother());
  const std::string job = "/v1/jobs/" + std::string(body_of(house.call("POST", "/v1/jobs", kMesh))["id"]);
  gate.wait_for(1);
  RawHttp listener(house.port());
  listener.send_request("GET", job + "/events");
  const auto head = listener.read_head();
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("Content-Type"), "text/event-stream");
  EXPECT_EQ(head.headers.count("Content-Length"), 0U);
  EXPECT_EQ(listener.read(19), "event: job\nid: 1\nda");
  gate.open();
  const std::string rest = listener.read_all();
  const std::size_t last = rest.rfind("data: ");
  ASSERT_NE(last, std::string::npos);
  EXPECT_EQ(json::parse(rest.substr(last + 6))["state"], "JOB_STATE_SUCCEEDED");
}

TEST(JobsApi, GivesTheEventsPlaceOfAClientThatLeft) {
  Gate gate;
  HttpHouse house({}, gate.smoother());
  const std::string job = "/v1/jobs/" + std::string(body_of(house.call("POST", "/v1/jobs", kMesh))["id"]);
  std::vector<std::unique_ptr<RawHttp>> listeners;
  for (int i = 0; i < 64; ++i) {
    listeners.push_back(std::make_unique<RawHttp>(house.port()));
    listeners.back()->send_request("GET", job + "/events");
    EXPECT_EQ(listeners.back()->read_head().status, 200);
  }
  EXPECT_EQ(code_of(house.call("GET", job + "/events")), "queue_full");
  listeners.front()->close();
  EXPECT_TRUE(eventually([&] {
    RawHttp one(house.port());
    one.send_request("GET", job + "/events");
    return one.read_head().status == 200;
  }));
  gate.open();
}

TEST(ByteRange, IsReadAsTheStandardHasIt) {
  const auto range = [](std::string_view header) { return parse_range(header, 100); };
  EXPECT_EQ(*range("bytes=0-0").value(), (ByteRange{0, 1}));
  EXPECT_EQ(*range("bytes=10-").value(), (ByteRange{10, 90}));
  EXPECT_EQ(*range("bytes=10-999").value(), (ByteRange{10, 90}));
  EXPECT_EQ(*range("bytes=-30").value(), (ByteRange{70, 30}));
  EXPECT_EQ(*range("bytes=-300").value(), (ByteRange{0, 100}));
  for (const char* all : {"", "bytes=", "bytes=5", "bytes=a-b", "bytes=5-4", "bytes=0-1,3-4", "lines=0-1",
                          "bytes=--1", "bytes=99999999999999999999-"})
    EXPECT_FALSE(range(all).value()) << all;
  for (const char* beyond : {"bytes=100-", "bytes=100-200", "bytes=-0"})
    EXPECT_EQ(range(beyond).error().cause, Cause::RangeNotSatisfiable) << beyond;
}

// ---- Uploads ----

constexpr std::string_view kPartial = "Content-Type: application/partial-upload\r\n";

std::string begun(HttpHouse& house, const std::string& headers) {
  const auto made = house.call("POST", "/v1/uploads", "", headers);
  EXPECT_EQ(made.status, 201) << made.body;
  return made.headers.at("Location");
}

TEST(UploadsApi, TakesAMeshInPieces) {
  HttpHouse house;
  const std::string upload = begun(house, "Upload-Length: " + std::to_string(kMesh.size()) + "\r\n");
  const auto patch = [&](std::size_t offset, std::string_view bytes) {
    return house.call("PATCH", upload, bytes,
                      std::string(kPartial) + "Upload-Offset: " + std::to_string(offset) + "\r\n");
  };
  EXPECT_EQ(patch(0, kMesh.substr(0, 10)).headers.at("Upload-Offset"), "10");
  const auto wrong = patch(9, "x");
  EXPECT_EQ(code_of(wrong), "upload_offset_mismatch");
  EXPECT_EQ(wrong.headers.at("Upload-Offset"), "10");
  RawHttp head(house.port());
  head.send_request("HEAD", upload);
  EXPECT_EQ(head.read_head().headers.at("Upload-Offset"), "10");
  const auto done = patch(10, kMesh.substr(10));
  EXPECT_EQ(done.headers.at("Upload-Complete"), "?1");
  EXPECT_EQ(body_of(done)["sha256"], sha256_of(kMesh));
  EXPECT_EQ(house.call("POST", "/v1/jobs?mesh_sha256=" + sha256_of(kMesh)).status, 202);
  EXPECT_EQ(house.call("DELETE", upload).status, 204);
  EXPECT_EQ(code_of(house.call("GET", upload)), "not_found");
}

TEST(UploadsApi, TakesAMeshAtOnceAndKnowsItAgain) {
  HttpHouse house;
  const auto whole = house.call("POST", "/v1/uploads", kMesh);
  EXPECT_EQ(whole.status, 201);
  EXPECT_EQ(whole.headers.at("Upload-Complete"), "?1");
  // The SHA-256 of "abc", as the header has it.
  const std::string digest = "Repr-Digest: sha-256=:ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=:\r\n";
  const std::string upload = begun(house, digest);
  const auto sent = house.call("PATCH", upload, "abc",
                               std::string(kPartial) + "Upload-Offset: 0\r\nUpload-Complete: ?1\r\n");
  EXPECT_EQ(sent.headers.at("Upload-Complete"), "?1") << sent.body;
  const auto again = house.call("POST", "/v1/uploads", "", digest);
  EXPECT_EQ(again.headers.at("Upload-Complete"), "?1") << "nothing was sent";
  EXPECT_EQ(again.headers.at("Upload-Offset"), "3");
}

/// What a phone does that loses its network in the middle of a piece.
TEST(UploadsApi, KeepsWhatCameBeforeTheConnectionBroke) {
  HttpHouse house;
  const std::string big(400'000, ' ');
  const std::string upload = begun(house, "Upload-Complete: ?0\r\n");
  {
    RawHttp client(house.port());
    client.send("PATCH " + upload + " HTTP/1.1\r\nHost: x\r\n" + std::string(kPartial) +
                "Upload-Offset: 0\r\nContent-Length: 90000\r\n\r\n" + big.substr(0, 70'000));
    EXPECT_TRUE(eventually([&] { return body_of(house.call("GET", upload))["offset"].get<int>() >= 65536; }))
        << "bytes are there before the piece is";
    client.reset();
  }
  EXPECT_TRUE(eventually([&] {
    return body_of(house.call("GET", upload))["offset"].get<int>() >= 65536 &&
           house.call("DELETE", upload).status == 204;
  })) << "nobody holds it any more";
}

TEST(UploadsApi, LeaveNothingBehindThatNobodyHeardOf) {
  HttpHouse house;
  EXPECT_EQ(code_of(house.call("POST", "/v1/uploads", std::string(100'001, ' '))), "too_large");
  EXPECT_EQ(code_of(house.call("POST", "/v1/uploads", "abc", "Upload-Length: 5\r\nUpload-Complete: ?1\r\n")),
            "bad_request");
  EXPECT_TRUE(eventually([&] { return house.house.store.files->bytes() == 0; }));
}

TEST(UploadsApi, SaysWhatIsWrong) {
  HttpHouse house;
  const std::string upload = begun(house, "");
  struct Row {
    const char *verb, *headers, *code;
  };
  for (const Row& row : {Row{"POST", "Upload-Length: many\r\n", "bad_request"},
                         Row{"POST", "Upload-Length: 100001\r\n", "too_large"},
                         Row{"POST", "Upload-Complete: yes\r\n", "bad_request"},
                         Row{"POST", "Repr-Digest: sha-256=abc\r\n", "bad_request"},
                         Row{"PATCH", "Upload-Offset: 0\r\n", "unsupported_format"},
                         Row{"PATCH", "Content-Type: application/partial-upload\r\n", "bad_request"},
                         Row{"PATCH", "Content-Type: application/partial-upload\r\nUpload-Offset: 1\r\n",
                             "upload_offset_mismatch"}}) {
    const std::string target = row.verb == std::string("POST") ? "/v1/uploads" : upload;
    EXPECT_EQ(code_of(house.call(row.verb, target, "x", row.headers)), row.code) << row.verb << row.headers;
  }
  EXPECT_EQ(code_of(house.call("PATCH", "/v1/uploads/0", "x", kPartial)), "not_found");
  EXPECT_EQ(code_of(house.call("DELETE", "/v1/uploads/0")), "not_found");
  EXPECT_EQ(code_of(house.call("PUT", upload)), "method_not_allowed");
}

}  // namespace
}  // namespace burnish
