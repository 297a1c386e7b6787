// Who may call, and how much.
#include "server/security/tokens.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "burnish/v1/jobs.grpc.pb.h"
#include "server/store/file_store.h"
#include "tests/client/temporary_folder.h"
#include "tests/server/running_server.h"
#include "tests/support/eventually.h"

namespace burnish {
namespace {

using cli::TemporaryFolder;
using nlohmann::json;
using std::chrono::seconds;
using testing::any_port;
using testing::eventually;
using testing::reason_of;
using testing::RunningServer;

const std::string kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

json entry(const std::string& name, const std::string& token, const json& quota = json::object()) {
  json result = {{"name", name}, {"sha256", sha256_of(token)}};
  result.update(quota);
  return result;
}
std::string file_of(const json& entries) { return json{{"tokens", entries}}.dump(); }

TEST(TokensFile, IsReadStrictly) {
  const std::string hash(64, 'a');
  const auto holders =
      parse_tokens(R"({"tokens": [{"name": "a.b-1", "sha256": ")" + hash +
                   R"(", "requestsPerSecond": 2.5, "bytesPerSecond": 10, "maxBytes": 7, "jobs": 3}]})");
  ASSERT_TRUE(holders) << holders.error().message;
  EXPECT_EQ(holders->front().quota.requests_per_second, 2.5);
  EXPECT_EQ(holders->front().quota.max_bytes, 7U);
  EXPECT_EQ(holders->front().quota.jobs, 3U);
  struct Row {
    std::string text, field;
  };
  for (const Row& row :
       {Row{"[]", "file"}, Row{"{}", "file"}, Row{R"({"tokens": [], "x": 1})", "file"},
        Row{R"({"tokens": [3]})", "tokens[0]"}, Row{R"({"tokens": [{"name": 3}]})", "tokens[0].name"},
        Row{R"({"tokens": [{"name": "a b", "sha256": ")" + hash + R"("}]})", "tokens[0].name"},
        Row{R"({"tokens": [{"name": "a", "sha256": "12"}]})", "tokens[0].sha256"},
        Row{R"({"tokens": [{"name": "a", "sha256": ")" + hash + R"(", "jobs": -1}]})", "tokens[0].jobs"},
        Row{R"({"tokens": [{"name": "a", "sha256": ")" + hash + R"(", "job": 1}]})", "tokens[0].job"},
        Row{R"({"tokens": [{"name": "a", "sha256": ")" + hash + R"("}, {"name": "b", "sha256": ")" + hash +
                R"("}]})",
            "tokens[1].sha256"}}) {
    const auto wrong = parse_tokens(row.text);
    ASSERT_FALSE(wrong) << row.text;
    EXPECT_EQ(wrong.error().field, row.field) << row.text;
  }
  EXPECT_FALSE(parse_tokens("{"));
}

TEST(Tokens, TellWhoCalls) {
  const TemporaryFolder folder;
  const auto tokens = std::move(
      Tokens::load(folder.write("tokens", file_of({entry("one", "first"), entry("two", "second")}))).value());
  EXPECT_EQ(tokens->identify("Bearer first", true)->owner, "one");
  EXPECT_EQ(tokens->identify("Bearer second", true)->owner, "two");
  for (const char* wrong :
       {"", "first", "Bearer ", "Bearer firs", "Bearer first ", "bearer first", "Basic first"})
    EXPECT_EQ(tokens->identify(wrong, true).error().cause, Cause::Unauthenticated) << wrong;
  EXPECT_FALSE(Tokens::load(folder / "none"));
}

TEST(Tokens, RunOutAndComeBack) {
  const TemporaryFolder folder;
  const auto tokens = std::move(
      Tokens::load(folder.write("tokens", file_of({entry("slow", "t",
                                                         {{"requestsPerSecond", 2}, {"bytesPerSecond", 10}}),
                                                   entry("free", "u")})))
          .value());
  const auto now = Tokens::Clock::now();
  EXPECT_TRUE(tokens->identify("Bearer t", true, now));
  EXPECT_TRUE(tokens->identify("Bearer t", true, now));
  const auto refused = tokens->identify("Bearer t", true, now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::QuotaExceeded);
  EXPECT_EQ(refused.error().retry_after, std::chrono::milliseconds(500));
  EXPECT_TRUE(tokens->identify("Bearer t", false, now)) << "the same request again";
  EXPECT_TRUE(tokens->identify("Bearer t", true, now + std::chrono::milliseconds(500)));
  EXPECT_TRUE(tokens->charge("slow", 600, now)) << "a minute's worth at once";
  EXPECT_EQ(tokens->charge("slow", 10, now).error().retry_after, seconds(1));
  EXPECT_TRUE(tokens->charge("slow", 10, now + seconds(1)));
  EXPECT_TRUE(tokens->charge("slow", 1'000'000, now + seconds(100))) << "a large mesh only waits longer";
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(tokens->identify("Bearer u", true, now));
    EXPECT_TRUE(tokens->charge("free", 1'000'000'000, now));
  }
}

TEST(Tokens, AreReadAgainWhenTheFileChanges) {
  const TemporaryFolder folder;
  const std::string path = folder.write("tokens", file_of(json::array({entry("one", "first")})));
  const auto tokens = std::move(Tokens::load(path).value());
  folder.write("tokens", file_of({entry("two", "second"), entry("three", "third")}));
  tokens->reload_if_changed();
  EXPECT_FALSE(tokens->identify("Bearer first", true));
  EXPECT_EQ(tokens->identify("Bearer second", true)->owner, "two");
  folder.write("tokens", "half a fi");
  tokens->reload_if_changed();
  EXPECT_TRUE(tokens->identify("Bearer second", true)) << "what was known stays";
}

// ---- The whole server ----

struct Guarded {
  Guarded()
      : config(any_port()),
        path(folder.write("tokens", file_of({entry("one", "first"), entry("two", "second"),
                                             entry("small", "third", {{"maxBytes", 10}, {"jobs", 1}})}))) {
    config.tokens_file = path;
  }
  static std::string as(const std::string& token) { return "Authorization: Bearer " + token + "\r\n"; }

  TemporaryFolder folder;
  Config config;
  std::string path;
};

TEST(GuardedServer, AnswersNobodyWithoutAToken) {
  Guarded guarded;
  RunningServer server(guarded.config);
  for (const char* path :
       {"/v1/methods", "/v1/jobs", "/v1/jobs/1", "/v1/uploads/1", "/metrics", "/openapi.json"}) {
    EXPECT_EQ(server.http("GET", path).status, 401) << path;
    EXPECT_EQ(server.http("GET", path, "", Guarded::as("wrong")).status, 401) << path;
  }
  for (const char* path : {"/v1/smooth", "/v1/compare", "/v1/jobs", "/v1/uploads"})
    EXPECT_EQ(server.http("POST", path, kMesh).status, 401) << path;
  EXPECT_EQ(server.http("POST", "/v1/smooth", kMesh).headers.at("WWW-Authenticate"), "Bearer");
  EXPECT_EQ(server.http("GET", "/livez").status, 200);
  EXPECT_EQ(server.http("GET", "/readyz").status, 200);
  EXPECT_EQ(server.http("POST", "/v1/smooth", kMesh, Guarded::as("first")).status, 200);

  EXPECT_EQ(reason_of(server.smooth_mesh(kMesh)), "UNAUTHENTICATED");
  const auto jobs = v1::JobService::NewStub(server.channel());
  const auto uploads = v1::UploadService::NewStub(server.channel());
  const auto reason = [&](auto call) {
    grpc::ClientContext context;
    return reason_of(call(context));
  };
  v1::Job job;
  v1::Upload upload;
  v1::ListMethodsResponse methods;
  EXPECT_EQ(reason([&](auto& context) { return jobs->SubmitJob(&context, {}, &job); }), "UNAUTHENTICATED");
  EXPECT_EQ(reason([&](auto& context) { return jobs->GetJob(&context, {}, &job); }), "UNAUTHENTICATED");
  EXPECT_EQ(reason([&](auto& context) { return uploads->CreateUpload(&context, {}, &upload); }),
            "UNAUTHENTICATED");
  EXPECT_EQ(reason([&](auto& context) { return server.stub().ListMethods(&context, {}, &methods); }),
            "UNAUTHENTICATED");
  EXPECT_EQ(reason([&](auto& context) {
              context.AddMetadata("authorization", "Bearer first");
              return server.stub().ListMethods(&context, {}, &methods);
            }),
            "");
}

TEST(GuardedServer, ShowsEachTokenOnlyItsOwn) {
  Guarded guarded;
  RunningServer server(guarded.config);
  const auto submitted = server.http("POST", "/v1/jobs", kMesh, Guarded::as("first"));
  ASSERT_EQ(submitted.status, 202) << submitted.body;
  const std::string job = submitted.headers.at("Location");
  const std::string upload =
      server.http("POST", "/v1/uploads", "", Guarded::as("first")).headers.at("Location");
  EXPECT_EQ(server.http("GET", job, "", Guarded::as("first") + "Prefer: wait=60\r\n").status, 200);
  for (const std::string& path : {job, job + "/mesh", job + "/report", job + "/events", upload}) {
    EXPECT_EQ(server.http("GET", path, "", Guarded::as("second")).status, 404) << path;
  }
  EXPECT_EQ(server.http("DELETE", job, "", Guarded::as("second")).status, 404);
  EXPECT_EQ(server.http("DELETE", upload, "", Guarded::as("second")).status, 404);
  EXPECT_EQ(
      server
          .http("PATCH", upload, "x",
                Guarded::as("second") + "Content-Type: application/partial-upload\r\nUpload-Offset: 0\r\n")
          .status,
      404);
  EXPECT_EQ(server.http("POST", "/v1/jobs?mesh_sha256=" + sha256_of(kMesh), "", Guarded::as("second")).status,
            404);
  EXPECT_EQ(json::parse(server.http("GET", "/v1/jobs", "", Guarded::as("second")).body)["jobs"].size(), 0U);
  const auto jobs = v1::JobService::NewStub(server.channel());
  const std::string id = job.substr(job.rfind('/') + 1);
  const auto as_second = [&](auto call) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer second");
    return reason_of(call(context));
  };
  v1::GetJobRequest get;
  get.set_id(id);
  v1::WatchJobRequest watch;
  watch.set_id(id);
  v1::DownloadResultRequest download;
  download.set_id(id);
  v1::Job answer;
  EXPECT_EQ(as_second([&](auto& context) { return jobs->GetJob(&context, get, &answer); }), "NOT_FOUND");
  EXPECT_EQ(as_second([&](auto& context) {
              const auto stream = jobs->WatchJob(&context, watch);
              while (stream->Read(&answer)) {
              }
              return stream->Finish();
            }),
            "NOT_FOUND");
  EXPECT_EQ(as_second([&](auto& context) {
              const auto stream = jobs->DownloadResult(&context, download);
              v1::DownloadResultResponse part;
              while (stream->Read(&part)) {
              }
              return stream->Finish();
            }),
            "NOT_FOUND");
}

TEST(GuardedServer, KeepsTheQuotas) {
  Guarded guarded;
  RunningServer server(guarded.config);
  const auto code = [](const HttpResponse& response) {
    return std::string(json::parse(response.body)["code"]);
  };
  EXPECT_EQ(code(server.http("POST", "/v1/smooth", kMesh, Guarded::as("third"))), "quota_exceeded");
  EXPECT_EQ(code(server.http("POST", "/v1/jobs", kMesh, Guarded::as("third"))), "quota_exceeded");
  EXPECT_EQ(code(server.http("POST", "/v1/uploads", kMesh, Guarded::as("third"))), "quota_exceeded");
  EXPECT_EQ(code(server.http("POST", "/v1/uploads", "", Guarded::as("third") + "Upload-Length: 11\r\n")),
            "quota_exceeded");
}

TEST(GuardedServer, ReadsItsTokensAgain) {
  Guarded guarded;
  RunningServer server(guarded.config);
  guarded.folder.write("tokens", file_of(json::array({entry("new", "a newer one")})));
  EXPECT_TRUE(eventually(
      [&] { return server.http("GET", "/v1/methods", "", Guarded::as("a newer one")).status == 200; }));
  EXPECT_EQ(server.http("GET", "/v1/methods", "", Guarded::as("first")).status, 401);
}

TEST(Server, ListensBeyondTheMachineOnlyWithTokensOrWhenToldSo) {
  Config config = any_port();
  config.http_listen.host = "0.0.0.0";
  const auto open = Server::start(config);
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().message.find("http-listen"), std::string::npos);
  config.insecure = true;
  EXPECT_TRUE(Server::start(config));
  config.insecure = false;
  Guarded guarded;
  config.tokens_file = guarded.path;
  EXPECT_TRUE(Server::start(config));
}

}  // namespace
}  // namespace burnish
