// SmoothStream and CompareStream as honest callers see them.
#include <gtest/gtest.h>

#include <string>

#include "tests/server/gate.h"
#include "tests/server/running_grpc.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using testing::eventually;
using testing::Gate;
using testing::RunningGrpc;
using testing::SmoothCall;

std::string noisy_sphere() { return testing::to_obj(testing::with_noise(testing::sphere(3), 0.02)); }

v1::SmoothStart few_iterations() {
  v1::SmoothStart start;
  start.mutable_options()->set_iterations(3);
  return start;
}

v1::SmoothResponse unary(RunningGrpc& server, const std::string& mesh, const std::string& reference = "") {
  v1::SmoothRequest request;
  request.set_mesh(mesh);
  request.set_reference(reference);
  request.mutable_options()->set_iterations(3);
  grpc::ClientContext context;
  v1::SmoothResponse response;
  const grpc::Status status = server.stub().Smooth(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response;
}

/// What must be equal between two runs.
std::string lasting(v1::SmoothReport report) {
  report.clear_request_id();
  report.clear_timings();
  return to_json(report, true);
}

TEST(SmoothStream, GivesTheBytesAndTheReportOfSmooth) {
  RunningGrpc server;
  const std::string mesh = noisy_sphere();
  const std::string reference = testing::to_obj(testing::sphere(3));
  const v1::SmoothResponse expected = unary(server, mesh, reference);
  SmoothCall call(server);
  call.start(few_iterations());
  call.upload_reference(reference);
  call.upload(mesh);
  const grpc::Status status = call.finish();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(call.result, expected.mesh());
  EXPECT_EQ(lasting(call.report.value()), lasting(expected.report()));
  EXPECT_EQ(call.report->errors().against(), "reference");
}

TEST(SmoothStream, DoesNotCareHowTheBytesAreCut) {
  RunningGrpc server;
  const std::string mesh = testing::to_obj(testing::with_noise(testing::sphere(1), 0.02));
  const std::string expected = unary(server, mesh).mesh();
  for (const std::size_t chunk : {std::size_t{1}, std::size_t{1000}, std::size_t{1} << 20}) {
    SmoothCall call(server);
    auto start = few_iterations();
    start.set_mesh_bytes(mesh.size());
    call.start(start);
    call.upload(mesh, chunk);
    ASSERT_TRUE(call.finish().ok());
    EXPECT_EQ(call.result, expected) << "chunks of " << chunk;
  }
}

TEST(SmoothStream, TakesMeshesBeyondTheUnaryLimit) {
  RunningGrpc server;
  auto mesh = testing::to_obj(testing::with_noise(testing::grid(380), 0.001));
  ASSERT_GT(mesh.size(), Config().max_unary_bytes);
  SmoothCall call(server);
  v1::SmoothStart start;
  start.set_mesh_bytes(mesh.size());
  start.mutable_options()->set_iterations(1);
  call.start(start);
  call.upload(mesh);
  const grpc::Status status = call.finish();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(call.report->input().triangles(), 2u * 380 * 380);
  EXPECT_EQ(call.report->encoding().bytes(), call.result.size());
  EXPECT_TRUE(server.forgets_everything());
}

TEST(SmoothStream, SendsChunksOfAtMostOneMebibyte) {
  const std::string mesh(3'500'000, 'x');
  RunningGrpc server({.smooth = [&](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
    return SmoothResult{.mesh = mesh, .report = {}};
  }});
  SmoothCall call(server);
  call.start();
  call.upload("mesh");
  ASSERT_TRUE(call.finish().ok());
  EXPECT_EQ(call.chunks, (std::vector<std::size_t>{1 << 20, 1 << 20, 1 << 20, 3'500'000 - 3 * (1 << 20)}));
  EXPECT_EQ(call.result, mesh);
}

TEST(SmoothStream, TellsEveryStageInOrderAndEndsBeforeTheResult) {
  RunningGrpc server;
  SmoothCall call(server);
  v1::SmoothStart start;
  start.mutable_options()->set_method("adaptive");
  start.mutable_options()->set_iterations(4000);  // long enough for several messages
  call.start(start);
  call.upload(testing::to_obj(testing::with_noise(testing::grid(60), 0.001)));
  ASSERT_TRUE(call.finish().ok());
  EXPECT_TRUE(call.in_order);
  ASSERT_GE(call.progress.size(), 2u);
  for (std::size_t i = 1; i < call.progress.size(); ++i) {
    const auto &before = call.progress[i - 1], &now = call.progress[i];
    EXPECT_GE(now.stage(), before.stage());
    if (now.stage() == before.stage()) {
      EXPECT_GE(now.fraction(), before.fraction());
    }
  }
}

TEST(SmoothStream, SaysThatItWaitsForAWorker) {
  Gate gate;
  Config config;
  config.workers = 1;
  RunningGrpc server({.config = config, .smooth = gate.smoother()});
  SmoothCall first(server), second(server);
  first.start();
  first.upload("mesh");
  gate.wait_for(1);
  second.start();
  second.upload("mesh");
  EXPECT_TRUE(second.read_until(v1::SMOOTH_STAGE_QUEUE));
  EXPECT_EQ(second.progress.back().stage(), v1::SMOOTH_STAGE_QUEUE);
  gate.open();
  EXPECT_TRUE(first.finish().ok());
  EXPECT_TRUE(second.finish().ok());
}

TEST(SmoothStream, SendsTheLatestProgressOnlyAndNotMoreThanTwentyASecond) {
  Gate gate;
  RunningGrpc server({.smooth = [&](const SmoothJob& job, const RunControl& run) -> Result<SmoothResult> {
    for (int i = 0; i < 100'000; ++i) job.progress(v1::SMOOTH_STAGE_SMOOTH, i / 100'000.0);
    job.progress(v1::SMOOTH_STAGE_MEASURE, 0);
    gate.pass(run);
    return SmoothResult{};
  }});
  SmoothCall call(server);
  const auto begin = std::chrono::steady_clock::now();
  call.start();
  call.upload("mesh");
  EXPECT_TRUE(call.read_until(v1::SMOOTH_STAGE_MEASURE))
      << "the last state goes out although nothing follows";
  gate.open();
  ASSERT_TRUE(call.finish().ok());
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(call.progress.size(), 2 + static_cast<std::size_t>(took / 50ms));
}

TEST(SmoothStream, SendsTheRequestIdBeforeTheAnswer) {
  RunningGrpc server;
  SmoothCall call(server);
  call.start(few_iterations());
  call.upload(noisy_sphere());
  ASSERT_TRUE(call.finish().ok());
  const auto& metadata = call.context.GetServerInitialMetadata();
  const auto id = metadata.find("burnish-request-id");
  ASSERT_NE(id, metadata.end());
  EXPECT_EQ(std::string(id->second.data(), id->second.size()), call.report->request_id());
}

/// One CompareStream, chunk by chunk in turn.
grpc::Status compare_stream(RunningGrpc& server, const std::string& mesh, const std::string& reference,
                            v1::CompareResponse& response) {
  grpc::ClientContext context;
  const auto stream = server.stub().CompareStream(&context, &response);
  v1::CompareStreamRequest message;
  message.mutable_start()->set_mesh_bytes(mesh.size());
  message.mutable_start()->set_reference_bytes(reference.size());
  stream->Write(message);
  for (std::size_t at = 0; at < std::max(mesh.size(), reference.size()); at += 1000) {
    if (at < mesh.size()) message.set_mesh_chunk(mesh.substr(at, 1000)), stream->Write(message);
    if (at < reference.size())
      message.set_reference_chunk(reference.substr(at, 1000)), stream->Write(message);
  }
  stream->WritesDone();
  return stream->Finish();
}

TEST(CompareStream, GivesTheTableOfCompareForEqualAndOtherConnectivity) {
  RunningGrpc server;
  const std::string mesh = noisy_sphere();
  for (const int levels : {3, 2}) {
    v1::CompareRequest request;
    request.set_mesh(mesh);
    request.set_reference(testing::to_obj(testing::sphere(levels)));
    grpc::ClientContext context;
    v1::CompareResponse by_unary, by_stream;
    const grpc::Status status = server.stub().Compare(&context, request, &by_unary);
    ASSERT_TRUE(status.ok()) << status.error_message();
    const grpc::Status streamed = compare_stream(server, mesh, request.reference(), by_stream);
    ASSERT_TRUE(streamed.ok()) << streamed.error_message();
    EXPECT_GT(by_stream.errors().ev(), 0);
    EXPECT_EQ(by_stream.errors().has_mean_normal_degrees(), levels == 3);
    for (auto* response : {&by_unary, &by_stream}) response->clear_timings(), response->clear_request_id();
    EXPECT_EQ(to_json(by_stream, true), to_json(by_unary, true));
  }
  EXPECT_TRUE(server.forgets_everything());
}

}  // namespace
}  // namespace burnish
