// The real server in process on ports of its own, and what a gRPC client needs to talk to it.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "server/server.h"
#include "tests/server/raw_http.h"
#include "tests/server/running_grpc.h"

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
    channel_ = connect(server_->grpc_address());
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

}  // namespace burnish::testing
