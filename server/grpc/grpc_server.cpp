#include "server/grpc/grpc_server.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>

namespace burnish {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
/// For clients to close their connections themselves. Some never do: those that watch health, or do not poll.
constexpr std::chrono::milliseconds kGoodbye{250};
constexpr int kMaxMetadataBytes = 16 * 1024;

int at_most_int(std::uint64_t value) {
  return static_cast<int>(std::min<std::uint64_t>(value, std::numeric_limits<int>::max()));
}

void set_limits(grpc::ServerBuilder& builder, const GrpcServerOptions& options) {
  // A mesh, a reference of the same size, and the options around them.
  const std::uint64_t largest_request = 2 * options.max_bytes + kMiB;
  grpc::ResourceQuota quota("burnish");
  quota.Resize(std::max(1024 * kMiB, 16 * largest_request));
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(at_most_int(largest_request));
  builder.SetMaxSendMessageSize(std::numeric_limits<int>::max());  // a Draco file grows when written as OBJ
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMaxMetadataBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, options.max_streams);
  // Without this a second server would share the port and take half of the calls.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
}

}  // namespace

Result<std::unique_ptr<GrpcServer>> GrpcServer::start(const GrpcServerOptions& options, SmoothJobs& jobs) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();

  auto result = std::unique_ptr<GrpcServer>(new GrpcServer(jobs));
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort(options.listen.text(), grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&result->handler_);
  set_limits(builder, options);
  result->server_ = builder.BuildAndStart();
  if (!result->server_ || port == 0) {
    return Error{Cause::BadOption, "cannot listen on " + options.listen.text() +
                                       " for gRPC: the address is in use or not one of this machine's"};
  }
  result->address_ = {options.listen.host, port};
  result->set_serving(false);
  return result;
}

GrpcServer::~GrpcServer() { stop(std::chrono::milliseconds::zero()); }

void GrpcServer::set_serving(bool serving) {
  auto* health = server_->GetHealthCheckService();
  health->SetServingStatus("", serving);
  health->SetServingStatus(std::string(v1::SmoothingService::service_full_name()), serving);
}

void GrpcServer::stop(std::chrono::milliseconds patience) {
  if (!server_) return;
  handler_.calls().wait_until_none(patience);
  server_->Shutdown(std::chrono::system_clock::now() + kGoodbye);
  server_->Wait();
}

}  // namespace burnish
