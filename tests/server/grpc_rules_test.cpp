// What is refused over gRPC, with which words, and when.
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <string>
#include <vector>

#include "tests/server/gate.h"
#include "tests/server/running_grpc.h"

namespace burnish {
namespace {

using testing::detail_of;
using testing::Gate;
using testing::reason_of;
using testing::RunningGrpc;
using testing::SmoothCall;

constexpr std::string_view kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

v1::SmoothStart declares(std::uint64_t mesh, std::uint64_t reference = 0) {
  v1::SmoothStart start;
  start.set_mesh_bytes(mesh);
  start.set_reference_bytes(reference);
  return start;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(GrpcRules, OfAStreamAreNamedWhenBroken) {
  struct Row {
    const char* name;
    std::function<void(SmoothCall&)> misbehave;
    const char* sentence;
    bool before_the_end;  ///< answered although the caller has not ended its writes
  };
  const Row rows[] = {
      {"nothing", [](SmoothCall& call) { call.stream->WritesDone(); }, "ended before its start", false},
      {"no start", [](SmoothCall& call) { call.mesh("v"); }, "mesh came before the start", true},
      {"reference first", [](SmoothCall& call) { call.reference("v"); }, "reference came before", true},
      {"two starts", [](SmoothCall& call) { call.start(), call.start(); }, "a second start", true},
      {"late start", [](SmoothCall& call) { call.start(), call.mesh("v"), call.start(); }, "second start",
       true},
      {"no part", [](SmoothCall& call) { call.start(), call.stream->Write({}); }, "neither a start", true},
      {"empty chunk", [](SmoothCall& call) { call.start(), call.mesh(""); }, "mesh is empty", true},
      {"no mesh", [](SmoothCall& call) { call.start(), call.stream->WritesDone(); }, "without a mesh", false},
      {"reference only", [](SmoothCall& call) { call.start(), call.reference("v"), call.upload(""); },
       "without a mesh", false},
      {"too many", [](SmoothCall& call) { call.start(declares(3)), call.mesh("1234"); }, "than the 3", true},
      {"too few", [](SmoothCall& call) { call.start(declares(5)), call.upload("1234"); }, "after 4 of the 5",
       false},
      {"chunk after all", [](SmoothCall& call) { call.start(declares(1)), call.mesh("1"), call.mesh("2"); },
       "than the 1", true},
      {"half a reference",
       [](SmoothCall& call) { call.start(declares(4, 9)), call.reference("12"), call.upload("1234"); },
       "after 2 of the 9 bytes of the reference", false},
      {"missing reference", [](SmoothCall& call) { call.start(declares(4, 9)), call.upload("1234"); },
       "after 0 of the 9 bytes of the reference", false},
  };
  RunningGrpc server;
  for (const Row& row : rows) {
    SmoothCall call(server);
    row.misbehave(call);
    const grpc::Status status = call.finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << row.name;
    EXPECT_EQ(reason_of(status), "BAD_REQUEST") << row.name;
    EXPECT_TRUE(contains(status.error_message(), row.sentence)) << row.name << ": " << status.error_message();
  }
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcRules, OfCompareStreamAreTheSameAndItNeedsAReference) {
  RunningGrpc server;
  for (const bool started : {false, true}) {
    grpc::ClientContext context;
    v1::CompareResponse response;
    const auto stream = server.stub().CompareStream(&context, &response);
    v1::CompareStreamRequest message;
    message.mutable_start();
    if (started) stream->Write(message);
    message.set_mesh_chunk("v");
    stream->Write(message);
    stream->WritesDone();
    const grpc::Status status = stream->Finish();
    EXPECT_EQ(reason_of(status), "BAD_REQUEST");
    EXPECT_TRUE(contains(status.error_message(), started ? "without a reference" : "before the start"))
        << status.error_message();
  }
}

TEST(GrpcRules, OfSizeHoldWhileTheBytesArrive) {
  Config config;
  config.limits.mesh.max_bytes = 1000;
  RunningGrpc server({.config = config});
  for (const bool of_mesh : {true, false}) {
    SmoothCall call(server);
    call.start();
    for (int i = 0; i < 11; ++i)
      of_mesh ? call.mesh(std::string(100, '#')) : call.reference(std::string(100, '#'));
    const grpc::Status status = call.finish();
    EXPECT_EQ(reason_of(status), "TOO_LARGE");
    EXPECT_TRUE(contains(status.error_message(), "1000 bytes (max-bytes)")) << status.error_message();
  }
}

TEST(GrpcRules, RefuseAStartBeforeTheFirstByte) {
  struct Row {
    const char* reason;
    const char* field;
    std::function<void(v1::SmoothStart&)> set;
  };
  const Row rows[] = {
      {"UNKNOWN_METHOD", "method", [](auto& start) { start.mutable_options()->set_method("magic"); }},
      {"BAD_OPTION", "iterations", [](auto& start) { start.mutable_options()->set_iterations(100'001); }},
      {"BAD_OPTION", "format", [](auto& start) { start.set_format(static_cast<v1::MeshFormat>(7)); }},
      {"BAD_OPTION", "reference_format",
       [](auto& start) { start.set_reference_format(static_cast<v1::MeshFormat>(-1)); }},
      {"TOO_LARGE", "", [](auto& start) { start.set_mesh_bytes(std::uint64_t{1} << 60); }},
      {"TOO_LARGE", "", [](auto& start) { start.set_reference_bytes(std::uint64_t{1} << 60); }},
  };
  RunningGrpc server;
  for (const Row& row : rows) {
    SmoothCall call(server);
    v1::SmoothStart start;
    row.set(start);
    call.start(start);
    const grpc::Status status = call.finish();
    EXPECT_EQ(reason_of(status), row.reason) << status.error_message();
    const auto blamed = detail_of<google::rpc::BadRequest>(status);
    EXPECT_EQ(blamed ? blamed->field_violations(0).field() : "", row.field);
  }
}

TEST(GrpcRules, RefuseAStreamBeforeItsStartWhenTheQueueIsFull) {
  Gate gate;
  Config config;
  config.workers = 1;
  config.queue = 0;
  RunningGrpc server({.config = config, .smooth = gate.smoother()});
  SmoothCall first(server);
  first.start();
  first.upload("mesh");
  gate.wait_for(1);
  const grpc::Status status = SmoothCall(server).finish();
  EXPECT_EQ(reason_of(status), "QUEUE_FULL");
  EXPECT_TRUE(detail_of<google::rpc::RetryInfo>(status).has_value());
  gate.open();
  EXPECT_TRUE(first.finish().ok());
}

TEST(GrpcRules, NameTheStreamForUnaryCallsOverTheLimit) {
  RunningGrpc server;
  const std::string large(9'000'000, '#');
  grpc::ClientContext smooth_context, compare_context;
  v1::SmoothRequest smooth;
  v1::SmoothResponse smoothed;
  smooth.set_mesh(large);
  const grpc::Status status = server.stub().Smooth(&smooth_context, smooth, &smoothed);
  EXPECT_EQ(reason_of(status), "TOO_LARGE");
  EXPECT_EQ(status.error_message(),
            "the request has " + std::to_string(smooth.ByteSizeLong()) +
                " bytes, a unary call carries 8388608 (max-unary-bytes); use SmoothStream");
  v1::CompareRequest compare;
  v1::CompareResponse compared;
  compare.set_mesh(large);
  const grpc::Status other = server.stub().Compare(&compare_context, compare, &compared);
  EXPECT_EQ(reason_of(other), "TOO_LARGE");
  EXPECT_TRUE(contains(other.error_message(), "use CompareStream")) << other.error_message();
}

TEST(GrpcRules, RefuseAFormatThatDoesNotExist) {
  RunningGrpc server;
  grpc::ClientContext context;
  v1::SmoothRequest request;
  v1::SmoothResponse response;
  request.set_mesh(std::string(kTetrahedron));
  request.set_format(static_cast<v1::MeshFormat>(9));
  const grpc::Status status = server.stub().Smooth(&context, request, &response);
  EXPECT_EQ(reason_of(status), "BAD_OPTION");
  EXPECT_EQ(detail_of<google::rpc::BadRequest>(status)->field_violations(0).field(), "format");
}

enum class Then : std::uint8_t { Ends, Waits };

/// One call with messages of one's own choice.
grpc::Status send(RunningGrpc& server, const std::string& method, const std::vector<std::string>& messages,
                  Then then, grpc::ByteBuffer* answer = nullptr,
                  const grpc::ChannelArguments& arguments = {}) {
  grpc::GenericStub stub(testing::connect(server.server().address(), arguments));
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  grpc::ByteBuffer received;
  const auto call = stub.PrepareCall(&context, "/burnish.v1.SmoothingService/" + method, &queue);
  call->StartCall(nullptr);
  wait();
  for (const std::string& message : messages) {
    const grpc::Slice slice(message);
    call->Write(grpc::ByteBuffer(&slice, 1), nullptr);
    wait();
  }
  if (then == Then::Ends) {
    call->WritesDone(nullptr);
    wait();
  }
  call->Read(&received, nullptr);
  if (wait() && answer) *answer = received;
  grpc::Status status;
  call->Finish(&status, nullptr);
  wait();
  return status;
}

grpc::Status send_bytes(RunningGrpc& server, const std::string& method, const std::string& bytes,
                        grpc::ByteBuffer* answer = nullptr, const grpc::ChannelArguments& arguments = {}) {
  return send(server, method, {bytes}, Then::Ends, answer, arguments);
}

TEST(GrpcRules, AskOneMessageOfAUnaryCall) {
  RunningGrpc server;
  for (const char* method : {"Smooth", "Compare"}) {
    const grpc::Status none = send(server, method, {}, Then::Ends);
    EXPECT_EQ(reason_of(none), "BAD_REQUEST");
    EXPECT_EQ(none.error_message(), "the call ended before its message");
    const grpc::Status two = send(server, method, {"", ""}, Then::Ends);
    EXPECT_EQ(reason_of(two), "BAD_REQUEST");
    EXPECT_EQ(two.error_message(), "a unary call has one message, and a second one came");
  }
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcRules, RefuseAUnaryCallBeforeItsMessageWhenTheQueueIsFull) {
  Gate gate;
  Config config;
  config.workers = 1;
  config.queue = 0;
  RunningGrpc server({.config = config, .smooth = gate.smoother()});
  v1::SmoothRequest request;
  request.set_mesh(std::string(kTetrahedron));
  auto running = std::async(std::launch::async, [&] {
    grpc::ClientContext context;
    v1::SmoothResponse response;
    return server.stub().Smooth(&context, request, &response);
  });
  gate.wait_for(1);
  for (const char* method : {"Smooth", "Compare"})
    EXPECT_EQ(reason_of(send(server, method, {}, Then::Waits)), "QUEUE_FULL") << method;
  // The client still sends what nobody will read, more than one window of it.
  for (const char* method : {"Smooth", "Compare"})
    EXPECT_EQ(reason_of(send_bytes(server, method, std::string(4 << 20, 'x'))), "QUEUE_FULL") << method;
  gate.open();
  EXPECT_TRUE(running.get().ok());
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcRules, NameAMethodThatThereIsNot) {
  RunningGrpc server;
  const grpc::Status status = send_bytes(server, "Polish", "");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(status.error_message(), "there is no method /burnish.v1.SmoothingService/Polish");
}

TEST(GrpcRules, CallBytesThatAreNoMessageABadRequest) {
  RunningGrpc server;
  // A field of wire type 7; half a field; what looks like gzip.
  for (const std::string& noise :
       {std::string("\xff\xff\xff"), std::string("\x0a\x05xyz"), std::string("\x1f\x8b\x08 zip")}) {
    for (const char* method : {"Smooth", "SmoothStream", "Compare", "CompareStream", "ListMethods"}) {
      const grpc::Status status = send_bytes(server, method, noise);
      EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << method;
      EXPECT_EQ(reason_of(status), "BAD_REQUEST") << method;
    }
  }
  EXPECT_TRUE(server.forgets_everything());
}

grpc::Status smooth_gzipped(RunningGrpc& server, const std::string& mesh, v1::SmoothResponse& response) {
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  v1::SmoothRequest request;
  request.set_mesh(mesh);
  return server.stub().Smooth(&context, request, &response);
}

TEST(GrpcRules, TakeGzipWithinTheLimitAndNoBombs) {
  Config config;
  config.max_unary_bytes = 1'000'000;
  RunningGrpc server({.config = config});
  v1::SmoothResponse response;
  const std::string mesh = std::string(kTetrahedron) + std::string(500'000, '#');
  EXPECT_TRUE(smooth_gzipped(server, mesh, response).ok());
  EXPECT_TRUE(contains(response.mesh(), std::string(500'000, '#')));
  const grpc::Status bomb = smooth_gzipped(server, std::string(300'000'000, '#'), response);
  EXPECT_EQ(reason_of(bomb), "TOO_LARGE");
  EXPECT_TRUE(contains(bomb.error_message(), "more than 1000000 bytes")) << bomb.error_message();
}

/// The first byte of the answer as it was sent: 0x1f when it is gzip.
int first_byte_sent(RunningGrpc& server, const grpc::ChannelArguments& accepted) {
  grpc::ChannelArguments arguments(accepted);
  arguments.SetInt(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  grpc::ByteBuffer answer;
  EXPECT_TRUE(send_bytes(server, "ListMethods", "", &answer, arguments).ok());
  std::vector<grpc::Slice> slices;
  return answer.Dump(&slices).ok() && !slices.empty() && slices[0].size() > 0 ? *slices[0].begin() : -1;
}

TEST(GrpcRules, CompressAnswersOnlyWhenAskedToAndForCallersThatAccept) {
  grpc::ChannelArguments everything, identity;
  identity.SetInt(GRPC_COMPRESSION_CHANNEL_ENABLED_ALGORITHMS_BITSET, 1 << GRPC_COMPRESS_NONE);
  for (const bool compress : {false, true}) {
    Config config;
    config.grpc_compression = compress;
    RunningGrpc server({.config = config});
    EXPECT_EQ(first_byte_sent(server, everything) == 0x1f, compress);
    EXPECT_NE(first_byte_sent(server, identity), 0x1f);
  }
}

TEST(GrpcRules, GiveEveryErrorItsRequestIdInTheMetadataToo) {
  RunningGrpc server;
  grpc::ClientContext context;
  v1::SmoothResponse response;
  const grpc::Status status = server.stub().Smooth(&context, {}, &response);
  const auto info = detail_of<google::rpc::ErrorInfo>(status);
  ASSERT_TRUE(info.has_value());
  const auto& metadata = context.GetServerInitialMetadata();
  const auto id = metadata.find("burnish-request-id");
  ASSERT_NE(id, metadata.end());
  EXPECT_EQ(std::string(id->second.data(), id->second.size()), info->metadata().at("request_id"));
}

}  // namespace
}  // namespace burnish
