// JobService and UploadService.
#include <gtest/gtest.h>

#include <string>

#include "burnish/v1/jobs.grpc.pb.h"
#include "server/jobs/job_states.h"
#include "tests/server/gate.h"
#include "tests/server/running_grpc.h"

namespace burnish {
namespace {

using testing::eventually;
using testing::Gate;
using testing::reason_of;
using testing::RunningGrpc;

const std::string kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// A server with the stubs of both services.
struct Server {
  explicit Server(SmoothFunction smooth = {}, Config config = {})
      : grpc({.config = std::move(config), .smooth = std::move(smooth)}),
        channel(testing::connect(grpc.server().address())),
        jobs(v1::JobService::NewStub(channel)),
        uploads(v1::UploadService::NewStub(channel)) {}

  /// The job, or the code of the error in `reason`.
  v1::Job submit(const v1::SubmitJobRequest& request) {
    grpc::ClientContext context;
    v1::Job job;
    const auto status = jobs->SubmitJob(&context, request, &job);
    reason = status.ok() ? "" : reason_of(status);
    return job;
  }
  v1::Job submit_mesh() {
    v1::SubmitJobRequest request;
    request.set_mesh(kMesh);
    return submit(request);
  }
  std::vector<v1::Job> watch(const std::string& id) {
    grpc::ClientContext context;
    v1::WatchJobRequest request;
    request.set_id(id);
    const auto stream = jobs->WatchJob(&context, request);
    std::vector<v1::Job> seen;
    for (v1::Job job; stream->Read(&job);) seen.push_back(job);
    const auto status = stream->Finish();
    reason = status.ok() ? "" : reason_of(status);
    return seen;
  }
  std::string download(const std::string& id, std::uint64_t offset, v1::MeshFile* file = nullptr) {
    grpc::ClientContext context;
    v1::DownloadResultRequest request;
    request.set_id(id);
    request.set_offset(offset);
    const auto stream = jobs->DownloadResult(&context, request);
    std::string bytes;
    for (v1::DownloadResultResponse part; stream->Read(&part);) {
      if (part.has_file() && file) *file = part.file();
      bytes += part.chunk();
    }
    const auto status = stream->Finish();
    reason = status.ok() ? "" : reason_of(status);
    return bytes;
  }
  template <class Request, class Response>
  Response call(grpc::Status (v1::JobService::Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                const std::string& id) {
    grpc::ClientContext context;
    Request request;
    request.set_id(id);
    Response response;
    const auto status = (jobs.get()->*method)(&context, request, &response);
    reason = status.ok() ? "" : reason_of(status);
    return response;
  }
  v1::Job get(const std::string& id) { return call(&v1::JobService::Stub::GetJob, id); }

  v1::Upload create(std::uint32_t bytes) {
    grpc::ClientContext context;
    v1::CreateUploadRequest request;
    request.set_bytes(bytes);
    v1::Upload upload;
    EXPECT_TRUE(uploads->CreateUpload(&context, request, &upload).ok());
    return upload;
  }
  v1::Upload append(const std::string& id, std::uint32_t offset, const std::vector<std::string>& chunks,
                    bool end = false) {
    grpc::ClientContext context;
    v1::Upload upload;
    const auto stream = uploads->AppendUpload(&context, &upload);
    v1::AppendUploadRequest message;
    message.mutable_start()->set_id(id);
    message.mutable_start()->set_offset(offset);
    stream->Write(message);
    for (const std::string& chunk : chunks) {
      message.set_chunk(chunk);
      stream->Write(message);
    }
    message.mutable_end();
    if (end) stream->Write(message);
    stream->WritesDone();
    const auto status = stream->Finish();
    reason = status.ok() ? "" : reason_of(status);
    return upload;
  }

  RunningGrpc grpc;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::JobService::Stub> jobs;
  std::unique_ptr<v1::UploadService::Stub> uploads;
  std::string reason;
};

TEST(JobService, SmoothsWhatItWasHandedToTheBytesThatSmoothGives) {
  Server server;
  const v1::Job job = server.submit_mesh();
  const auto seen = server.watch(job.id());
  EXPECT_EQ(server.reason, "");
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back().state(), v1::JOB_STATE_SUCCEEDED);
  v1::SmoothRequest request;
  v1::SmoothResponse direct;
  request.set_mesh(kMesh);
  grpc::ClientContext context;
  ASSERT_TRUE(server.grpc.stub().Smooth(&context, request, &direct).ok());
  v1::MeshFile file;
  EXPECT_EQ(server.download(job.id(), 0, &file), direct.mesh());
  EXPECT_EQ(file.bytes(), direct.mesh().size());
  EXPECT_EQ(server.download(job.id(), 10), direct.mesh().substr(10));
  EXPECT_EQ(server.download(job.id(), direct.mesh().size()), "");
  EXPECT_EQ(server.reason, "");
  server.download(job.id(), direct.mesh().size() + 1);
  EXPECT_EQ(server.reason, "RANGE_NOT_SATISFIABLE");
}

TEST(JobService, NamesWhatIsWrong) {
  Config config;
  config.max_unary_bytes = 1000;
  Server server({}, config);
  v1::SubmitJobRequest request;
  server.submit(request);
  EXPECT_EQ(server.reason, "EMPTY_MESH");
  request.set_mesh_sha256(std::string(64, '0'));
  server.submit(request);
  EXPECT_EQ(server.reason, "NOT_FOUND");
  request.set_mesh(kMesh);
  server.submit(request);
  EXPECT_EQ(server.reason, "BAD_OPTION");
  request.clear_mesh_sha256();
  request.set_format(static_cast<v1::MeshFormat>(77));
  server.submit(request);
  EXPECT_EQ(server.reason, "BAD_OPTION");
  request.clear_format();
  request.set_priority(static_cast<v1::JobPriority>(77));
  server.submit(request);
  EXPECT_EQ(server.reason, "BAD_OPTION");
  request.clear_priority();
  request.set_mesh(std::string(1001, ' '));
  server.submit(request);
  EXPECT_EQ(server.reason, "TOO_LARGE");
  server.get("none");
  EXPECT_EQ(server.reason, "NOT_FOUND");
  server.watch("none");
  EXPECT_EQ(server.reason, "NOT_FOUND");
  server.download("none", 0);
  EXPECT_EQ(server.reason, "NOT_FOUND");
}

TEST(JobService, CancelsAndDeletes) {
  Gate gate;
  Server server(gate.smoother());
  const v1::Job job = server.submit_mesh();
  gate.wait_for(1);
  server.download(job.id(), 0);
  EXPECT_EQ(server.reason, "NOT_READY");
  EXPECT_EQ(server.call(&v1::JobService::Stub::CancelJob, job.id()).state(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(server.get(job.id()).error().code(), "CANCELLED");
  server.call(&v1::JobService::Stub::DeleteJob, job.id());
  EXPECT_EQ(server.reason, "");
  server.get(job.id());
  EXPECT_EQ(server.reason, "NOT_FOUND");
}

TEST(JobService, ListsTheSameJobsAsHttpWould) {
  Server server;
  const v1::Job job = server.submit_mesh();
  server.watch(job.id());
  grpc::ClientContext context;
  v1::ListJobsResponse response;
  ASSERT_TRUE(server.jobs->ListJobs(&context, {}, &response).ok());
  ASSERT_EQ(response.jobs_size(), 1);
  EXPECT_EQ(response.jobs(0).id(), job.id());
  EXPECT_EQ(server.grpc.house().durable_jobs.get({}, job.id())->state(), v1::JOB_STATE_SUCCEEDED);
}

TEST(JobService, EndsTheWatchOfACallerThatLeft) {
  Gate gate;
  Server server(gate.smoother());
  const v1::Job job = server.submit_mesh();
  grpc::ClientContext context;
  v1::WatchJobRequest request;
  request.set_id(job.id());
  const auto stream = server.jobs->WatchJob(&context, request);
  v1::Job now;
  ASSERT_TRUE(stream->Read(&now));
  context.TryCancel();
  EXPECT_FALSE(stream->Finish().ok());
  EXPECT_TRUE(eventually([&] { return server.grpc.server().calls() == 0; }));
  gate.open();
}

TEST(JobService, EndsWatchesWhenTheServerDoes) {
  Gate gate;
  Server server(gate.smoother());
  const v1::Job job = server.submit_mesh();
  gate.wait_for(1);
  grpc::ClientContext context;
  v1::WatchJobRequest request;
  request.set_id(job.id());
  const auto stream = server.jobs->WatchJob(&context, request);
  v1::Job now;
  ASSERT_TRUE(stream->Read(&now));
  server.grpc.lifecycle().move_to(LifecycleState::Draining);
  while (stream->Read(&now)) {
  }
  EXPECT_EQ(reason_of(stream->Finish()), "SHUTTING_DOWN");
  gate.open();
}

TEST(UploadService, TakesAMeshInPiecesAndJobsNameIt) {
  Server server;
  const v1::Upload upload = server.create(0);
  EXPECT_EQ(server.append(upload.id(), 0, {kMesh.substr(0, 10), kMesh.substr(10, 5)}).offset(), 15U);
  EXPECT_FALSE(server.append(upload.id(), 15, {}).complete()) << "a stream without its end may have been cut";
  const v1::Upload done = server.append(upload.id(), 15, {kMesh.substr(15)}, true);
  EXPECT_EQ(server.reason, "");
  EXPECT_TRUE(done.complete());
  v1::SubmitJobRequest request;
  request.set_mesh_sha256(done.sha256());
  EXPECT_EQ(server.watch(server.submit(request).id()).back().state(), v1::JOB_STATE_SUCCEEDED);
}

TEST(UploadService, KeepsWhatCameBeforeTheCallBroke) {
  Server server;
  const v1::Upload upload = server.create(static_cast<std::uint32_t>(kMesh.size()));
  const auto offset = [&] {
    grpc::ClientContext context;
    v1::GetUploadRequest request;
    request.set_id(upload.id());
    v1::Upload now;
    EXPECT_TRUE(server.uploads->GetUpload(&context, request, &now).ok());
    return now.offset();
  };
  {
    grpc::ClientContext context;
    v1::Upload response;
    const auto stream = server.uploads->AppendUpload(&context, &response);
    v1::AppendUploadRequest message;
    message.mutable_start()->set_id(upload.id());
    stream->Write(message);
    message.set_chunk(kMesh.substr(0, 30));
    stream->Write(message);
    EXPECT_TRUE(eventually([&] { return offset() == 30; }));
    context.TryCancel();
    EXPECT_FALSE(stream->Finish().ok());
  }
  EXPECT_TRUE(eventually([&] {
    const v1::Upload now = server.append(upload.id(), 30, {kMesh.substr(30)});
    return server.reason.empty() && now.complete();
  })) << server.reason;
}

TEST(UploadService, NamesWhatIsWrong) {
  Server server;
  const v1::Upload upload = server.create(10);
  server.append(upload.id(), 3, {"x"});
  EXPECT_EQ(server.reason, "UPLOAD_OFFSET_MISMATCH");
  server.append(upload.id(), 0, {kMesh});
  EXPECT_EQ(server.reason, "TOO_LARGE");
  server.append("none", 0, {"x"});
  EXPECT_EQ(server.reason, "NOT_FOUND");
  server.append(upload.id(), 0, {"v 0"}, true);
  EXPECT_EQ(server.reason, "BAD_REQUEST");
  grpc::ClientContext context;
  v1::Upload response;
  const auto stream = server.uploads->AppendUpload(&context, &response);
  v1::AppendUploadRequest chunk;
  chunk.set_chunk("x");
  stream->Write(chunk);
  stream->WritesDone();
  EXPECT_EQ(reason_of(stream->Finish()), "BAD_REQUEST");
}

}  // namespace
}  // namespace burnish
