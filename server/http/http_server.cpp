#define CPPHTTPLIB_LISTEN_BACKLOG 128  // the library's own 5 drops bursts of connections
#include "server/http/http_server.h"

#include <httplib.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <future>
#include <thread>
#include <utility>

#include "server/http/problem.h"
#include "server/observe/log.h"

namespace burnish {
namespace {

constexpr std::size_t kThreadsForReads = 16;  // so that probes are answered while every job's caller waits
constexpr std::size_t kWaitingConnections = 256;   // beyond them a connection is closed
constexpr std::size_t kDrainedBytes = 1ull << 30;  // of a refused body, so that its sender sees the answer
constexpr std::size_t kRequestsPerConnection = 32;
constexpr int kKeepAliveSeconds = 2, kReadSeconds = 10, kWriteSeconds = 30;

HttpRequest to_request(const httplib::Request& from) {
  HttpRequest request{.method = from.method, .path = from.path};
  request.query.insert(from.params.begin(), from.params.end());
  request.headers.insert(from.headers.begin(), from.headers.end());
  return request;
}

void respond(HttpResponse from, httplib::Response& to) {
  to.status = from.status;
  for (const auto& [name, value] : from.headers) {
    if (name != "Content-Type") to.set_header(name, value);
  }
  // The body itself, not a content provider: those are cut off when the server stops.
  to.set_content(std::move(from.body), from.headers["Content-Type"]);
}

/// One of a bounded number of places, taken for as long as it lives.
class Place {
 public:
  Place(std::atomic<std::size_t>& taken, std::size_t places) : taken_(taken), got_(++taken <= places) {}
  ~Place() { --taken_; }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  explicit operator bool() const { return got_; }

 private:
  std::atomic<std::size_t>& taken_;
  const bool got_;
};

}  // namespace

struct HttpServer::Impl {
  Impl(const HttpServerOptions& given, Gateway& the_gateway) : options(given), gateway(the_gateway) {}

  void set_up();
  void serve_smooth(const httplib::Request& request, httplib::Response& response,
                    const httplib::ContentReader& read);
  HttpResponse read_and_handle(const httplib::Request& request, const httplib::ContentReader& read);
  void log(const httplib::Request& request, const httplib::Response& response) const;

  const HttpServerOptions options;
  Gateway& gateway;
  Address address;
  std::atomic<bool> stopping = false;
  std::atomic<std::size_t> smooth_calls = 0;
  httplib::Server server;
  std::future<void> ended;
  std::jthread thread;
};

void HttpServer::Impl::set_up() {
  server.new_task_queue = [threads = options.smooth_calls + kThreadsForReads] {
    return new httplib::ThreadPool(threads, threads, kWaitingConnections);
  };
  // SO_REUSEADDR alone: with the library's SO_REUSEPORT a second server would share the port.
  server.set_socket_options(
      [](socket_t socket) { httplib::set_socket_opt(socket, SOL_SOCKET, SO_REUSEADDR, 1); });
  server.set_tcp_nodelay(true);
  server.set_keep_alive_max_count(kRequestsPerConnection);
  server.set_keep_alive_timeout(kKeepAliveSeconds);
  server.set_read_timeout(kReadSeconds);
  server.set_write_timeout(kWriteSeconds);
  server.set_payload_max_length(options.max_bytes + kDrainedBytes);  // our own limit is counted while reading

  server.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    auto answer = gateway.answer_head(to_request(request));
    if (!answer) return httplib::Server::HandlerResponse::Unhandled;
    respond(*std::move(answer), response);
    return httplib::Server::HandlerResponse::Handled;
  });
  server.set_expect_100_continue_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        auto answer = gateway.answer_head(to_request(request));
        if (!answer) return static_cast<int>(httplib::StatusCode::Continue_100);
        respond(*std::move(answer), response);
        return response.status;
      });
  server.Post(".*", [this](const auto& request, auto& response, const auto& read) {
    serve_smooth(request, response, read);
  });
  server.set_error_handler([](const httplib::Request&, httplib::Response& response) {
    if (response.body.empty()) respond(bad_request(response.status, new_request_id()), response);
    return httplib::Server::HandlerResponse::Handled;
  });
  server.set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
        respond(problem({Cause::Internal, "the server failed to answer"}, new_request_id()), response);
      });
  server.set_logger([this](const auto& request, const auto& response) { log(request, response); });
}

void HttpServer::Impl::serve_smooth(const httplib::Request& request, httplib::Response& response,
                                    const httplib::ContentReader& read) {
  const Place place(smooth_calls, options.smooth_calls);
  respond(place ? read_and_handle(request, read)
                : gateway.refuse({Cause::QueueFull, "too many requests to smooth at once; try again later"}),
          response);
}

HttpResponse HttpServer::Impl::read_and_handle(const httplib::Request& request,
                                               const httplib::ContentReader& read) {
  auto body = std::make_shared<std::string>();
  body->reserve(std::min<std::uint64_t>(request.get_header_value_u64("Content-Length"), options.max_bytes));
  bool too_large = false;
  const bool complete = read([&](const char* data, std::size_t size) {
    too_large = too_large || body->size() + size > options.max_bytes;
    if (too_large) {
      std::string().swap(*body);  // the rest is read and dropped
    } else {
      body->append(data, size);
    }
    return !stopping;
  });
  if (too_large) return gateway.refuse(body_too_large(options.max_bytes));
  if (stopping) return gateway.refuse({Cause::ShuttingDown, "the server is shutting down"});
  if (!complete) return bad_request(httplib::StatusCode::BadRequest_400, new_request_id());
  HttpRequest smooth = to_request(request);
  smooth.body = std::move(body);
  return gateway.handle(smooth, request.is_connection_closed);
}

/// Requests to smooth have a line of their own, with more to say.
void HttpServer::Impl::log(const httplib::Request& request, const httplib::Response& response) const {
  if (request.path == "/v1/smooth") return;
  const bool probe = request.path == "/livez" || request.path == "/readyz" || request.path == "/metrics";
  spdlog::log(probe ? spdlog::level::debug : spdlog::level::info,
              "request transport=http call={} {} status={}", printable(request.method, 10),
              printable(request.path, 100), response.status);
}

Result<std::unique_ptr<HttpServer>> HttpServer::start(const HttpServerOptions& options, Gateway& gateway) {
  auto impl = std::make_unique<Impl>(options, gateway);
  impl->set_up();
  const auto& [host, port] = options.listen;
  const int opened =
      port == 0 ? impl->server.bind_to_any_port(host) : (impl->server.bind_to_port(host, port) ? port : -1);
  if (opened <= 0) {
    return Error{Cause::BadOption, "cannot listen on " + options.listen.text() +
                                       " for HTTP: the address is in use or not one of this machine's"};
  }
  impl->address = {host, opened};
  std::packaged_task<void()> listen([server = &impl->server] { server->listen_after_bind(); });
  impl->ended = listen.get_future();
  impl->thread = std::jthread(std::move(listen));
  impl->server.wait_until_ready();  // stop() before that would be lost
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

HttpServer::~HttpServer() { stop(std::chrono::milliseconds::zero()); }

const Address& HttpServer::address() const { return impl_->address; }

bool HttpServer::stop(std::chrono::milliseconds patience) {
  impl_->stopping = true;
  impl_->server.stop();
  return impl_->ended.wait_for(patience) == std::future_status::ready;
}

}  // namespace burnish
