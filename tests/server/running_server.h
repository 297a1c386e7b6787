// The real server in process on ports of its own, and what a gRPC client needs to talk to it.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/server.h"
#include "tests/server/raw_http.h"

namespace burnish::testing {

inline Config any_port() {
  Config config;
  config.grpc_listen = {"127.0.0.1", 0};
  config.http_listen = {"127.0.0.1", 0};
  return config;
}

class RunningServer {
 public:
  explicit RunningServer(const Config& config = any_port(), SmoothFunction smooth = {})
      : server_(std::move(Server::start(config, std::move(smooth)).value())) {
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // each test its own connection
    channel_ = grpc::CreateCustomChannel(server_->grpc_address().text(), grpc::InsecureChannelCredentials(),
                                         arguments);
    stub_ = v1::SmoothingService::NewStub(channel_);
  }

  Server& operator*() { return *server_; }
  Server* operator->() { return server_.get(); }
  v1::SmoothingService::Stub& stub() { return *stub_; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  HttpResponse http(std::string_view method, std::string_view target, std::string_view body = {},
                    std::string_view headers = {}) {
    return http_call(server_->http_address().port, method, target, body, headers);
  }

  grpc::Status smooth(const v1::SmoothRequest& request, v1::SmoothResponse& response,
                      std::optional<std::chrono::milliseconds> timeout = {}) {
    grpc::ClientContext context;
    if (timeout) context.set_deadline(std::chrono::system_clock::now() + *timeout);
    return stub_->Smooth(&context, request, &response);
  }
  grpc::Status smooth_mesh(const std::string& mesh) {
    v1::SmoothRequest request;
    v1::SmoothResponse response;
    request.set_mesh(mesh);
    return smooth(request, response);
  }

 private:
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SmoothingService::Stub> stub_;
};

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

}  // namespace burnish::testing
