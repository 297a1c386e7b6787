// The gRPC server in process with its jobs at hand, and a client's side of the streams.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/grpc/grpc_server.h"
#include "tests/server/jobs_house.h"
#include "tests/support/eventually.h"

namespace burnish::testing {

/// The detail of type `Detail` in a failed status.
template <class Detail>
std::optional<Detail> detail_of(const grpc::Status& status) {
  google::rpc::Status rich;
  if (!rich.ParseFromString(status.error_details())) return {};
  for (const auto& any : rich.details()) {
    Detail detail;
    if (any.UnpackTo(&detail)) return detail;
  }
  return {};
}

/// "QUEUE_FULL", or empty.
inline std::string reason_of(const grpc::Status& status) {
  const auto info = detail_of<google::rpc::ErrorInfo>(status);
  return info ? info->reason() : "";
}

/// Each client its own connection, which takes messages of any size.
inline std::shared_ptr<grpc::Channel> connect(const Address& address, grpc::ChannelArguments arguments = {}) {
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address.text(), grpc::InsecureChannelCredentials(), arguments);
}

struct GrpcSetup {
  Config config = {};
  SmoothFunction smooth = {};
  std::chrono::milliseconds idle = CallLimits().idle;
};

/// What Server wires up, without HTTP. Serving from the start.
class RunningGrpc {
 public:
  explicit RunningGrpc(GrpcSetup setup = {})
      : house_({.limits = setup.config.limits,
                .runner = {.workers = setup.config.workers, .queue = setup.config.queue, .threads = 1},
                .smooth = std::move(setup.smooth)}) {
    if (!setup.config.grpc_listen.is_unix()) setup.config.grpc_listen = {"127.0.0.1", 0};
    server_ = std::move(
        GrpcServer::start(setup.config, house_.jobs, house_.durable_jobs, house_.uploads, setup.idle)
            .value());
    stub_ = v1::SmoothingService::NewStub(connect(server_->address()));
  }
  ~RunningGrpc() { house_.runner.drain(std::chrono::milliseconds::zero()); }  // their answers use the server

  v1::SmoothingService::Stub& stub() { return *stub_; }
  GrpcServer& server() { return *server_; }
  JobRunner& runner() { return house_.runner; }
  Lifecycle& lifecycle() { return house_.lifecycle; }
  Jobs& jobs() { return house_.jobs; }
  JobsHouse& house() { return house_; }

  /// Nothing of any call is left: no job, no bytes, no call under way.
  bool forgets_everything() {
    if (!eventually([&] {
          return house_.runner.queued() + house_.runner.running() == 0 && house_.spool.bytes() == 0;
        })) {
      return false;
    }
    const auto begin = std::chrono::steady_clock::now();
    server_->stop(std::chrono::seconds(60));  // waits for the calls
    return std::chrono::steady_clock::now() - begin < std::chrono::seconds(30);
  }

 private:
  JobsHouse house_;
  std::unique_ptr<GrpcServer> server_;
  std::unique_ptr<v1::SmoothingService::Stub> stub_;
};

/// One SmoothStream of a client.
class SmoothCall {
 public:
  explicit SmoothCall(RunningGrpc& server, std::optional<std::chrono::milliseconds> timeout = {}) {
    if (timeout) context.set_deadline(std::chrono::system_clock::now() + *timeout);
    stream = server.stub().SmoothStream(&context);
  }

  bool start(const v1::SmoothStart& start = {}) {
    v1::SmoothStreamRequest message;
    *message.mutable_start() = start;
    return stream->Write(message);
  }
  bool mesh(const std::string& bytes) {
    v1::SmoothStreamRequest message;
    message.set_mesh_chunk(bytes);
    return stream->Write(message);
  }
  bool reference(const std::string& bytes) {
    v1::SmoothStreamRequest message;
    message.set_reference_chunk(bytes);
    return stream->Write(message);
  }
  /// In chunks of `chunk` bytes, then the end.
  void upload(const std::string& bytes, std::size_t chunk = std::size_t{1} << 20) {
    for (std::size_t at = 0; at < bytes.size(); at += chunk) mesh(bytes.substr(at, chunk));
    stream->WritesDone();
  }
  void upload_reference(const std::string& bytes) {
    for (std::size_t at = 0; at < bytes.size(); at += 100) reference(bytes.substr(at, 100));
  }

  /// Reads up to the status, however many messages there are.
  grpc::Status finish() {
    v1::SmoothStreamResponse message;
    while (stream->Read(&message)) take(message);
    return stream->Finish();
  }

  /// Reads until the job is at `stage` or beyond; false when the stream ended before.
  bool read_until(v1::SmoothStage stage) {
    v1::SmoothStreamResponse message;
    while (stream->Read(&message)) {
      take(message);
      if (message.has_progress() && message.progress().stage() >= stage) return true;
    }
    return false;
  }

  grpc::ClientContext context;
  std::unique_ptr<grpc::ClientReaderWriter<v1::SmoothStreamRequest, v1::SmoothStreamResponse>> stream;
  std::vector<v1::SmoothProgress> progress;
  std::vector<std::size_t> chunks;  ///< sizes
  std::string result;
  std::optional<v1::SmoothReport> report;
  bool in_order = true;  ///< progress, then chunks, then one report

 private:
  void take(const v1::SmoothStreamResponse& message) {
    if (report) in_order = false;
    if (message.has_progress()) {
      if (!chunks.empty()) in_order = false;
      progress.push_back(message.progress());
    } else if (message.has_report()) {
      report = message.report();
    } else {
      chunks.push_back(message.mesh_chunk().size());
      result += message.mesh_chunk();
    }
  }
};

}  // namespace burnish::testing
