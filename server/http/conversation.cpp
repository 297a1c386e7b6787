#include "server/http/conversation.h"

#include <httplib.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include "server/http/answer_encoding.h"
#include "server/http/body_intake.h"
#include "server/http/header_value.h"
#include "server/http/request_head.h"
#include "server/http/request_reader.h"
#include "server/http/request_stream.h"

namespace burnish {
namespace {

constexpr int kRequestsPerConnection = 1000;
constexpr std::uint64_t kSkippedBytes = 1 << 20;  // of a refused body, to keep its connection
constexpr std::string_view kAreYouThere = "HTTP/1.1 100 Continue\r\n\r\n";

HttpRequest to_request(const httplib::Request& from) {
  HttpRequest request{.method = from.method, .path = from.path};
  request.query.insert(from.params.begin(), from.params.end());
  for (const auto& [name, value] : from.headers) {
    const auto [known, is_new] = request.headers.emplace(name, value);
    if (!is_new && !same_ignoring_case(name, "Content-Length")) known->second.append(", ").append(value);
  }
  return request;
}

constexpr const char* kNotUnderstood = "the server cannot understand this HTTP request";

std::string_view body_of(const HttpResponse& response) {
  return response.file.owner ? response.file.bytes : std::string_view(response.body);
}

/// One request and its answer.
struct Exchange {
  std::optional<RequestHead> head;  ///< nothing: the library could not read it
  bool worth_reading = false;       ///< the gateway said so, before 100 Continue
  bool body_done = false;
  bool answered = false;   ///< by us, not by the library
  bool abandoned = false;  ///< the client left before its answer was ready
  HttpResponse answer;     ///< its body: the rest has gone to the library
};

/// The library's server is made for many sockets; here it is the parser of one connection.
class Conversation final : public httplib::Server {
 public:
  Conversation(Connection& connection, const ConversationContext& context)
      : connection_(connection),
        context_(context),
        reader_(connection, context.patience),
        stream_(connection, reader_) {
    set_up();
  }

  void run();

 private:
  void set_up();
  void answer_next();
  void take_head(httplib::Request& from);
  std::optional<HttpResponse> answer_head();
  Result<> read_body(const httplib::ContentReader& read, HttpRequest& request);
  Error why_unread() const;
  HttpResponse answer_body(const httplib::ContentReader& read);
  HttpResponse answer_upload(const httplib::ContentReader& read, BodyTaker& taker);
  HttpResponse answer_exception(const std::exception_ptr& thrown);
  bool client_gone();
  void respond(HttpResponse from, httplib::Response& to);
  void settle(const httplib::Request& request, httplib::Response& response);
  void deliver();
  void reject(int status, const Error& error);
  std::optional<std::uint64_t> unread_bytes() const;

  Connection& connection_;
  const ConversationContext& context_;
  RequestReader reader_;
  RequestStream stream_;
  Exchange exchange_;
  int left_ = kRequestsPerConnection;
  bool closing_ = false;
  bool lingering_ = false;  ///< the client may still be sending
};

void Conversation::run() {
  for (; left_ > 0 && !closing_; --left_) {
    answer_next();
    exchange_ = {};  // a body must not wait for the client's next request
  }
  if (lingering_) connection_.linger();
}

void Conversation::set_up() {
  set_payload_max_length(std::numeric_limits<std::size_t>::max());  // ours are counted after decompression
  set_expect_100_continue_handler([this](const httplib::Request&, httplib::Response& response) {
    auto answer = answer_head();
    exchange_.worth_reading = !answer;
    if (!answer) return static_cast<int>(httplib::StatusCode::Continue_100);
    exchange_.head->wants_close = true;  // nobody knows whether the client sends the body all the same
    respond(*std::move(answer), response);
    return response.status;
  });
  set_pre_routing_handler([this](const httplib::Request&, httplib::Response& response) {
    if (exchange_.worth_reading) return HandlerResponse::Unhandled;
    auto answer = answer_head();
    if (!answer) return HandlerResponse::Unhandled;
    respond(*std::move(answer), response);
    return HandlerResponse::Handled;
  });
  const auto with_body = [this](const httplib::Request&, httplib::Response& response,
                                const httplib::ContentReader& read) { respond(answer_body(read), response); };
  Post(".*", with_body);
  Patch(".*", with_body);
  set_exception_handler(
      [this](const httplib::Request&, httplib::Response& response, const std::exception_ptr& thrown) {
        respond(answer_exception(thrown), response);
      });
  set_error_handler([this](const httplib::Request&, httplib::Response& response) {
    if (!exchange_.answered) {
      respond(context_.gateway.bad_request(response.status, {Cause::BadRequest, kNotUnderstood}), response);
    }
    return HandlerResponse::Handled;
  });
  set_post_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) { settle(request, response); });
}

void Conversation::answer_next() {
  using Head = RequestReader::Head;
  switch (reader_.read_head(left_ == kRequestsPerConnection)) {
    case Head::None:
      closing_ = true;
      return;
    case Head::TooSlow:
      return reject(408, {Cause::RequestTimeout, "the head of the request came too slowly"});
    case Head::Stopping:
      return reject(503, {Cause::ShuttingDown, "the server is shutting down"});
    case Head::TooLarge:
      return reject(431, {Cause::BadRequest, "the head of the request has more than " +
                                                 std::to_string(RequestReader::kMaxHeadBytes) + " bytes"});
    case Head::LongLine:
      return reject(414, {Cause::BadRequest, "the first line of the request has more than " +
                                                 std::to_string(RequestReader::kMaxLineBytes) + " bytes"});
    case Head::Whole:
    case Head::Cut:
      break;
  }
  bool library_would_close = false;  // settle() knows more
  process_request(stream_, "", 0, "", 0, false, library_would_close,
                  [this](httplib::Request& request) { take_head(request); });
  deliver();
}

void Conversation::take_head(httplib::Request& from) {
  HttpRequest request = to_request(from);
  if (const auto range = split_value(reader_.range(), '\r').front(); !range.empty())
    request.headers["Range"] = range;
  exchange_.head = understand(std::move(request), from.version == "HTTP/1.0");
  // The library acts on these, but not on compressed forms, cut streams or forms without end as we must.
  for (const char* name : {"Content-Encoding", "Content-Type", "Upgrade"}) from.headers.erase(name);
  reader_.begin_body();
}

std::optional<HttpResponse> Conversation::answer_head() {
  const RequestHead& head = *exchange_.head;
  if (head.flaw) return context_.gateway.refuse(head.request, *head.flaw);
  return context_.gateway.answer_head(head.request, [this] { return client_gone(); });
}

HttpResponse Conversation::answer_body(const httplib::ContentReader& read) {
  HttpRequest& request = exchange_.head->request;
  if (auto taking = context_.gateway.take_body(request))
    return taking->taker ? answer_upload(read, *taking->taker) : std::move(taking->refusal);
  if (auto complete = read_body(read, request); !complete) {
    return context_.gateway.refuse(request, complete.error());
  }
  HttpResponse response = context_.gateway.handle(request, [this] { return client_gone(); });
  request.body = {};  // a slow reader of the answer must not hold the spool
  request.parts.clear();
  return response;
}

/// What came is kept, also when not all of it did.
HttpResponse Conversation::answer_upload(const httplib::ContentReader& read, BodyTaker& taker) {
  const HttpRequest& request = exchange_.head->request;
  auto decoder = BodyDecoder::for_encoding(request.header("Content-Encoding"));
  if (!decoder) return context_.gateway.refuse(request, decoder.error());
  const ByteSink sink = [&taker](std::string_view bytes) { return taker.take(bytes); };
  Result<> state;
  exchange_.body_done = read([&](const char* bytes, std::size_t size) {
    state = (*decoder)->feed({bytes, size}, sink);
    return state.ok();
  });
  if (state) {
    auto rest = (*decoder)->finish(sink);
    state = exchange_.body_done ? std::move(rest) : Result<>(why_unread());
  }
  auto answer = state ? taker.finish() : Result<HttpResponse>(state.error());
  return answer ? std::move(answer).value() : context_.gateway.refuse(request, answer.error());
}

/// An interim answer means nothing to a client of HTTP/1.1; one of HTTP/1.0 must not get any.
bool Conversation::client_gone() { return connection_.gone(exchange_.head->http_1_0 ? "" : kAreYouThere); }

Result<> Conversation::read_body(const httplib::ContentReader& read, HttpRequest& request) {
  BodyIntake intake(context_.spool, context_.limits);
  Result<> state = intake.begin(request, exchange_.head->length.bytes);
  if (!state) return state;
  exchange_.body_done = read([&](const char* bytes, std::size_t size) {
    state = intake.feed({bytes, size});
    return state.ok();
  });
  if (!state) return state;
  if (!exchange_.body_done) return why_unread();
  return intake.finish(request);
}

Error Conversation::why_unread() const {
  switch (reader_.ended()) {
    case Connection::Event::End:
      return {Cause::BadRequest, "the body ends before it is complete"};
    case Connection::Event::Stopping:
      return {Cause::ShuttingDown, "the server is shutting down"};
    case Connection::Event::TimedOut:
      return {Cause::RequestTimeout, "the body came too slowly, with fewer than " +
                                         std::to_string(context_.patience.min_body_rate) +
                                         " bytes a second (min-body-rate)"};
    case Connection::Event::Bytes:
      break;
  }
  return {Cause::BadRequest, "the body breaks the rules of chunked transfer"};
}

HttpResponse Conversation::answer_exception(const std::exception_ptr& thrown) {
  Error error{Cause::Internal, "the server failed to answer"};
  try {
    std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    error = {Cause::OutOfMemory, "no memory to answer the request"};
  } catch (...) {  // whatever else it is, it is a mistake of ours
  }
  return context_.gateway.refuse(exchange_.head->request, error);
}

void Conversation::respond(HttpResponse from, httplib::Response& to) {
  if (const auto& head = exchange_.head) {
    const std::string_view accepted = head->request.header("Accept-Encoding");
    exchange_.abandoned = !encode_answer(from, accepted, [this] { return client_gone(); });
  }
  exchange_.answered = true;
  to.status = from.status;
  to.headers.clear();
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  // Not given to the library, which would copy it behind the head.
  to.set_header("Content-Length", std::to_string(body_of(from).size()));
  exchange_.answer = std::move(from);
}

/// Bytes of the body that were announced and not read; nothing when nobody knows how many they are.
std::optional<std::uint64_t> Conversation::unread_bytes() const {
  const auto& head = exchange_.head;
  if (!head || head->flaw) return {};
  if (exchange_.body_done) return 0;
  if (head->length.chunked) return {};
  return head->length.bytes - reader_.body_bytes();
}

/// The last word on the head of the answer, and on what becomes of the connection.
void Conversation::settle(const httplib::Request& request, httplib::Response& response) {
  reader_.end_body();  // or the library would read on, as long as the client likes
  if (request.method == "HEAD") {
    std::string().swap(exchange_.answer.body);
    exchange_.answer.file = {};
  }
  const auto unread = unread_bytes();
  closing_ = !unread || *unread > kSkippedBytes || exchange_.head->wants_close || left_ == 1 ||
             connection_.stopping() || reader_.ended() != Connection::Event::Bytes || exchange_.answer.stream;
  for (const char* name : {"Connection", "Keep-Alive"}) response.headers.erase(name);
  if (!exchange_.answer.headers.contains("Accept-Ranges")) response.headers.erase("Accept-Ranges");
  if (exchange_.answer.stream) response.headers.erase("Content-Length");  // it ends with the connection
  using Code = httplib::StatusCode;
  if (response.status == Code::NoContent_204 || response.status == Code::NotModified_304)
    response.headers.erase("Content-Length");
  if (closing_) {
    response.set_header("Connection", "close");
  } else if (exchange_.head->http_1_0) {
    response.set_header("Connection", "keep-alive");
  }
}

void Conversation::deliver() {
  const std::string head = stream_.take_written();
  if (head.empty()) return reject(400, {Cause::BadRequest, kNotUnderstood});
  if (exchange_.abandoned || !connection_.send(head, body_of(exchange_.answer))) {
    closing_ = true;
    return;
  }
  if (exchange_.answer.stream) {
    exchange_.answer.stream([this](std::string_view piece) { return connection_.send(piece, {}); },
                            [this] { return connection_.gone("") || connection_.stopping(); });
  }
  const auto unread = unread_bytes();
  if (!closing_ && !reader_.skip(unread.value_or(0))) closing_ = true;
  lingering_ = closing_ && unread != 0u;
}

void Conversation::reject(int status, const Error& error) {
  closing_ = true;
  lingering_ = connection_.send(closing_answer(context_.gateway.bad_request(status, error)), {});
}

}  // namespace

void converse(Connection& connection, const ConversationContext& context) {
  try {
    Conversation(connection, context).run();
  } catch (const std::exception& failure) {
    spdlog::error("an HTTP connection ended early: {}", failure.what());
  }
}

std::string closing_answer(const HttpResponse& response) {
  std::string answer =
      "HTTP/1.1 " + std::to_string(response.status) + " " + httplib::status_message(response.status) + "\r\n";
  for (const auto& [name, value] : response.headers)
    answer.append(name).append(": ").append(value).append("\r\n");
  answer += "Content-Length: " + std::to_string(response.body.size()) + "\r\nConnection: close\r\n\r\n";
  return answer + response.body;
}

}  // namespace burnish
