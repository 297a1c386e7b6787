#include "server/http/http_server.h"

#include <locale>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "server/http/connection_threads.h"
#include "server/http/conversation.h"
#include "server/http/listener.h"
#include "server/http/tls_connection.h"

namespace burnish {

HttpServerOptions http_options(const Config& config) {
  return {.listen = config.http_listen,
          .max_connections = config.max_connections,
          .patience = {.head = config.head_timeout, .min_body_rate = config.min_body_rate}};
}

namespace {

/// libstdc++ fills this cache on first use, without a lock, and std::regex, which the HTTP library makes for
/// every connection, reads it: two connections would race.
bool fill_character_cache() {
  const auto& characters = std::use_facet<std::ctype<char>>(std::locale::classic());
  for (int c = 1; c < 256; ++c) characters.narrow(static_cast<char>(c), '\0');
  return true;
}

}  // namespace

struct HttpServer::Impl {
  Impl(const HttpServerOptions& options, Gateway& gateway, Jobs& jobs)
      : context{.gateway = gateway,
                .spool = jobs.spool(),
                .limits = jobs.limits(),
                .patience = options.patience},
        tls(options.tls),
        max_connections(options.max_connections),
        threads(options.max_connections) {
    [[maybe_unused]] static const bool filled = fill_character_cache();
  }

  void accept();
  void serve(int socket);
  std::string refusal() const;
  void abort_all();

  const ConversationContext context;
  const TlsContexts* const tls;
  const std::size_t max_connections;
  StopEvent stopping;
  std::unique_ptr<Listener> listener;
  std::mutex mutex;
  std::set<SocketConnection*> connections;  ///< guarded by mutex
  ConnectionThreads threads;
  std::mutex stop_mutex;  ///< one stop() at a time
  std::jthread acceptor;
};

void HttpServer::Impl::accept() {
  listener->run(
      stopping, [this](int socket) { return threads.run([this, socket] { serve(socket); }); },
      [this] { return refusal(); });
}

void HttpServer::Impl::serve(int socket) {
  SocketConnection connection(socket, stopping, context.patience);
  {
    const std::lock_guard lock(mutex);
    connections.insert(&connection);
  }
  if (!tls) {
    converse(connection, context);
  } else if (TlsConnection encrypted(connection, tls->current());
             encrypted.handshake(Connection::Clock::now() + context.patience.head)) {
    converse(encrypted, context);
  }
  const std::lock_guard lock(mutex);
  connections.erase(&connection);
}

std::string HttpServer::Impl::refusal() const {
  const Error error{.cause = Cause::QueueFull,
                    .message = "the server has no place for more than " + std::to_string(max_connections) +
                               " connections (max-connections)",
                    .retry_after = std::chrono::seconds(1)};
  return closing_answer(context.gateway.bad_request(429, error));
}

void HttpServer::Impl::abort_all() {
  const std::lock_guard lock(mutex);
  for (SocketConnection* const connection : connections) connection->abort();
}

Result<std::unique_ptr<HttpServer>> HttpServer::start(const HttpServerOptions& options, Gateway& gateway,
                                                      Jobs& jobs) {
  auto impl = std::make_unique<Impl>(options, gateway, jobs);
  if (impl->stopping.file() < 0) {
    return Error{Cause::BadOption, "the process has no file descriptor to spare for HTTP"};
  }
  auto listener = Listener::open(options.listen);
  if (!listener) return std::move(listener).error();
  impl->listener = std::move(listener).value();
  impl->acceptor = std::jthread([impl = impl.get()] { impl->accept(); });
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

std::unique_ptr<HttpServer> HttpServer::without_port(const HttpServerOptions& options, Gateway& gateway,
                                                     Jobs& jobs) {
  return std::unique_ptr<HttpServer>(new HttpServer(std::make_unique<Impl>(options, gateway, jobs)));
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

HttpServer::~HttpServer() { stop(std::chrono::milliseconds::zero()); }

const Address& HttpServer::address() const { return impl_->listener->address(); }

std::string HttpServer::answer(std::string_view bytes) {
  MemoryConnection connection(bytes);
  converse(connection, impl_->context);
  return connection.take_output();
}

void HttpServer::stop(std::chrono::milliseconds patience) {
  const std::lock_guard stopping(impl_->stop_mutex);
  impl_->stopping.set();
  if (impl_->acceptor.joinable()) impl_->acceptor.join();
  impl_->listener.reset();
  if (impl_->threads.wait_until_idle(patience)) return;
  impl_->abort_all();
  impl_->threads.wait_until_idle(std::chrono::hours(1));
}

}  // namespace burnish
