#include "server/grpc/grpc_server.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include "server/unix_socket.h"

namespace burnish {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
/// For clients to close their connections themselves. Some never do: those that watch health, or do not poll.
constexpr std::chrono::milliseconds kGoodbye{250};
constexpr int kWindowBytes = 16 * 1024;  // of a call that nobody reads yet
constexpr int kMaxMetadataBytes = 16 * 1024;
constexpr unsigned kReadFilesEverySeconds = 1;
constexpr int kMostThreads = 512;  // of the synchronous services; more calls are refused

// A silent peer is asked after a minute and given up 20 s later. Clients may ask every 30 s, with some slack.
constexpr int kKeepaliveMs = 60'000;
constexpr int kKeepalivePatienceMs = 20'000;
constexpr int kLeastPingIntervalMs = 20'000;

/// gRPC 1.51.1 buffers a message whole before it looks at its limit (measured: 300 MB against a limit of 4
/// MiB took 311 MB, and 74 MB with a quota of 64 MiB, which then resets the stream). So the transport has no
/// limit of its own, the handler has one with a sentence, and the quota bounds the buffers: 100 calls of 8
/// MiB at once pass 512 MiB unharmed, but not 256 MiB.
std::uint64_t buffer_bytes(const Config& config) { return std::max(512 * kMiB, 64 * config.max_unary_bytes); }

void set_limits(grpc::ServerBuilder& builder, const Config& config) {
  grpc::ResourceQuota quota("burnish");
  quota.Resize(buffer_bytes(config));
  quota.SetMaxThreads(kMostThreads);
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(std::numeric_limits<int>::max());
  builder.SetMaxSendMessageSize(std::numeric_limits<int>::max());  // a Draco file grows when written as OBJ
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMaxMetadataBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, config.max_streams);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepalivePatienceMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kLeastPingIntervalMs);
  // A probed window grows to megabytes, which refused callers would fill: a message that is read gets its
  // room all the same.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kWindowBytes);
  // Without this a second server would share the port and take half of the calls.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
}

void set_compression(grpc::ServerBuilder& builder, bool compress_answers) {
  // gRPC inflates without a limit (measured: 300 KB became 300 MB, quota or not), so messages.h does it.
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  // A level is what the caller accepts; an algorithm would be forced on it.
  if (compress_answers) builder.SetDefaultCompressionLevel(GRPC_COMPRESS_LEVEL_LOW);
}

/// Reads the files again by itself when they change.
std::shared_ptr<grpc::ServerCredentials> credentials(const TlsFiles& files) {
  if (!files.given()) return grpc::InsecureServerCredentials();
  namespace tls = grpc::experimental;
  const bool mutual = !files.client_ca.empty();
  const auto provider = mutual ? std::make_shared<tls::FileWatcherCertificateProvider>(
                                     files.key, files.certificate, files.client_ca, kReadFilesEverySeconds)
                               : std::make_shared<tls::FileWatcherCertificateProvider>(
                                     files.key, files.certificate, kReadFilesEverySeconds);
  tls::TlsServerCredentialsOptions options(provider);
  options.watch_identity_key_cert_pairs();
  if (mutual) options.watch_root_certs();
  options.set_cert_request_type(mutual ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                                       : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  return tls::TlsServerCredentials(options);
}

Error cannot_listen(const Address& address) {
  return {Cause::BadOption, "cannot listen on " + address.text() +
                                " for gRPC: the address is in use or not one of this machine's"};
}

}  // namespace

Result<std::unique_ptr<GrpcServer>> GrpcServer::start(const Config& config, Jobs& jobs,
                                                      DurableJobs& durable_jobs, Uploads& uploads,
                                                      std::chrono::milliseconds idle) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  // gRPC itself would take the socket away from a server that lives.
  if (config.grpc_listen.is_unix()) {
    if (auto clear = clear_unix_socket(config.grpc_listen.path); !clear) return clear.error();
  }

  const CallLimits limits{.max_message_bytes = config.max_unary_bytes, .idle = idle};
  auto result = std::unique_ptr<GrpcServer>(new GrpcServer(jobs, durable_jobs, uploads, limits));
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort(config.grpc_listen.text(), credentials(config.tls), &port);
  builder.RegisterService(&result->handler_);
  builder.RegisterCallbackGenericService(&result->unary_calls_);
  builder.RegisterService(&result->jobs_handler_);
  builder.RegisterService(&result->uploads_handler_);
  set_limits(builder, config);
  set_compression(builder, config.grpc_compression);
  result->server_ = builder.BuildAndStart();
  if (!result->server_ || port == 0) return cannot_listen(config.grpc_listen);
  result->address_ = config.grpc_listen;
  if (!config.grpc_listen.is_unix()) result->address_.port = port;
  result->set_serving(false);
  return result;
}

GrpcServer::~GrpcServer() { stop(std::chrono::milliseconds::zero()); }

void GrpcServer::set_serving(bool serving) {
  auto* health = server_->GetHealthCheckService();
  health->SetServingStatus("", serving);
  for (const char* const service :
       {v1::SmoothingService::service_full_name(), v1::JobService::service_full_name(),
        v1::UploadService::service_full_name()})
    health->SetServingStatus(service, serving);
}

void GrpcServer::refuse_uploads() {
  handler_.uploads().refuse_all({Cause::ShuttingDown, "the server is shutting down"});
}

void GrpcServer::stop(std::chrono::milliseconds patience) {
  if (!server_) return;
  refuse_uploads();
  handler_.calls().wait_until_none(patience);
  server_->Shutdown(std::chrono::system_clock::now() + kGoodbye);
  server_->Wait();
}

}  // namespace burnish
