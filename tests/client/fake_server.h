// A gRPC server in process whose answers the test writes.
#pragma once

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "tests/support/eventually.h"

namespace burnish::client {

using SmoothStream = grpc::ServerReaderWriter<v1::SmoothStreamResponse, v1::SmoothStreamRequest>;
using CompareStream = grpc::ServerReader<v1::CompareStreamRequest>;

/// What the server does; what is unset is UNIMPLEMENTED.
struct Script {
  std::function<grpc::Status(grpc::ServerContext&, const v1::SmoothRequest&, v1::SmoothResponse&)> smooth =
      {};
  std::function<grpc::Status(grpc::ServerContext&, SmoothStream&)> smooth_stream = {};
  std::function<grpc::Status(const v1::CompareRequest&, v1::CompareResponse&)> compare = {};
  std::function<grpc::Status(CompareStream&, v1::CompareResponse&)> compare_stream = {};
};

class FakeServer final : public v1::SmoothingService::Service {
 public:
  explicit FakeServer(Script script, const std::string& listen = "127.0.0.1:0", bool takes_gzip = true)
      : script_(std::move(script)) {
    grpc::ServerBuilder builder;
    builder.SetMaxReceiveMessageSize(-1);
    if (!takes_gzip) builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
    int port = 0;
    builder.AddListeningPort(listen, grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address_ = listen.starts_with("unix:") ? listen : "127.0.0.1:" + std::to_string(port);
  }
  ~FakeServer() override { die(); }

  const std::string& address() const { return address_; }

  /// Closes its connections in the middle of whatever they carry.
  void die() { server_->Shutdown(std::chrono::system_clock::now()); }

  grpc::Status Smooth(grpc::ServerContext* context, const v1::SmoothRequest* request,
                      v1::SmoothResponse* response) override {
    return script_.smooth ? script_.smooth(*context, *request, *response) : unimplemented();
  }
  grpc::Status SmoothStream(grpc::ServerContext* context, client::SmoothStream* stream) override {
    return script_.smooth_stream ? script_.smooth_stream(*context, *stream) : unimplemented();
  }
  grpc::Status Compare(grpc::ServerContext*, const v1::CompareRequest* request,
                       v1::CompareResponse* response) override {
    return script_.compare ? script_.compare(*request, *response) : unimplemented();
  }
  grpc::Status CompareStream(grpc::ServerContext*, client::CompareStream* stream,
                             v1::CompareResponse* response) override {
    return script_.compare_stream ? script_.compare_stream(*stream, *response) : unimplemented();
  }
  grpc::Status ListMethods(grpc::ServerContext*, const v1::ListMethodsRequest*,
                           v1::ListMethodsResponse* response) override {
    response->add_methods()->set_name("adaptive");
    return grpc::Status::OK;
  }

 private:
  static grpc::Status unimplemented() { return {grpc::StatusCode::UNIMPLEMENTED, "not in the script"}; }

  const Script script_;
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

/// A status as burnishd sends it.
inline grpc::Status refusal(grpc::StatusCode code, const std::string& reason, const std::string& field = {},
                            std::chrono::milliseconds retry_after = {}) {
  google::rpc::Status details;
  google::rpc::ErrorInfo info;
  info.set_domain("burnish");
  info.set_reason(reason);
  details.add_details()->PackFrom(info);
  if (!field.empty()) {
    google::rpc::BadRequest bad_request;
    bad_request.add_field_violations()->set_field(field);
    details.add_details()->PackFrom(bad_request);
  }
  if (retry_after.count() > 0) {
    google::rpc::RetryInfo retry;
    retry.mutable_retry_delay()->set_seconds(retry_after.count() / 1000);
    retry.mutable_retry_delay()->set_nanos(static_cast<int>(retry_after.count() % 1000 * 1'000'000));
    details.add_details()->PackFrom(retry);
  }
  return {code, "the server says why", details.SerializeAsString()};
}

inline grpc::Status queue_full(std::chrono::milliseconds retry_after = {}) {
  return refusal(grpc::StatusCode::RESOURCE_EXHAUSTED, "QUEUE_FULL", {}, retry_after);
}

/// Holds the call until the client is gone.
inline grpc::Status until_cancelled(grpc::ServerContext& context) {
  testing::eventually([&] { return context.IsCancelled(); });
  return grpc::Status::CANCELLED;
}

inline grpc::Status echo(grpc::ServerContext&, const v1::SmoothRequest& request,
                         v1::SmoothResponse& response) {
  response.set_mesh(request.mesh());
  response.mutable_report()->set_method(request.options().method());
  return grpc::Status::OK;
}

inline void send_progress(SmoothStream& stream, v1::SmoothStage stage, double fraction = 0) {
  v1::SmoothStreamResponse part;
  part.mutable_progress()->set_stage(stage);
  part.mutable_progress()->set_fraction(fraction);
  stream.Write(part);
}

inline void send_chunk(SmoothStream& stream, const std::string& bytes) {
  v1::SmoothStreamResponse part;
  part.set_mesh_chunk(bytes);
  stream.Write(part);
}

inline void send_report(SmoothStream& stream, const std::string& method = "adaptive") {
  v1::SmoothStreamResponse part;
  part.mutable_report()->set_method(method);
  part.mutable_report()->mutable_encoding()->set_format(v1::MESH_FORMAT_OBJ);
  stream.Write(part);
}

/// What came up a stream.
template <class Start>
struct Upload {
  Start start;
  std::string mesh, reference;
  std::size_t largest_chunk = 0;
};

template <class Start, class Request, class Stream>
Upload<Start> receive(Stream& stream) {
  Upload<Start> upload;
  for (Request part; stream.Read(&part);) {
    if (part.has_start()) upload.start = part.start();
    upload.mesh += part.mesh_chunk();
    upload.reference += part.reference_chunk();
    upload.largest_chunk =
        std::max({upload.largest_chunk, part.mesh_chunk().size(), part.reference_chunk().size()});
  }
  return upload;
}

inline Upload<v1::SmoothStart> receive(SmoothStream& stream) {
  return receive<v1::SmoothStart, v1::SmoothStreamRequest>(stream);
}
inline Upload<v1::CompareStart> receive(CompareStream& stream) {
  return receive<v1::CompareStart, v1::CompareStreamRequest>(stream);
}

inline grpc::Status echo_stream(grpc::ServerContext&, SmoothStream& stream) {
  const auto upload = receive(stream);
  for (std::size_t at = 0; at < upload.mesh.size(); at += std::size_t{1} << 20) {
    send_chunk(stream, upload.mesh.substr(at, std::size_t{1} << 20));
  }
  send_report(stream, upload.start.options().method());
  return grpc::Status::OK;
}

}  // namespace burnish::client
