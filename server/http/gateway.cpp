#include "server/http/gateway.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/http/job_request.h"
#include "server/http/media_type.h"
#include "server/http/openapi.h"
#include "server/http/problem.h"
#include "server/http/routes.h"
#include "server/http/smooth_answer.h"
#include "server/observe/log.h"
#include "server/observe/trace.h"

namespace burnish {
namespace {

using Clock = RunControl::Clock;
using std::chrono::milliseconds;

constexpr milliseconds kAskClientEvery{15};
/// A job that polls its deadline answers within this; one inside a library call is not waited for.
constexpr milliseconds kDeadlineSlack{25};
constexpr std::size_t kLongestRequestId = 64;

HttpResponse text(std::string body, std::string_view type) {
  return {.headers = {{"Content-Type", std::string(type)}}, .body = std::move(body)};
}
HttpResponse plain(std::string body) { return text(std::move(body), "text/plain; charset=utf-8"); }

bool is_request_id(std::string_view id) {
  return !id.empty() && id.size() <= kLongestRequestId && std::ranges::all_of(id, [](unsigned char c) {
    return (c < 128 && std::isalnum(c)) || c == '.' || c == '_' || c == '-';
  });
}

/// Where a job leaves its answer for the thread that waits for it. Shared, for either may be gone first.
template <class T>
class Answer {
 public:
  void set(Result<T> result) {
    const std::lock_guard lock(mutex_);
    result_ = std::move(result);
    changed_.notify_one();
  }

  /// The answer; Cancelled when `give_up` comes true, DeadlineExceeded when the job is late for its deadline.
  Result<T> wait(std::optional<Clock::time_point> deadline, const std::function<bool()>& give_up) {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kAskClientEvery, [this] { return result_.has_value(); })) {
      if (give_up()) return Error{Cause::Cancelled, "the client went away"};
      if (deadline && Clock::now() >= *deadline + kDeadlineSlack) {
        return Error{Cause::DeadlineExceeded, "the deadline passed before the job was done"};
      }
    }
    return *std::move(result_);
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Result<T>> result_;
};

/// The bytes that a job's views point to.
std::vector<SharedBytes> meshes_of(const HttpRequest& request) {
  std::vector<SharedBytes> meshes{request.body};
  for (const FormPart& part : request.parts) meshes.push_back(part.content);
  return meshes;
}

/// Starts a job by `start(done)` and waits for it.
template <class T, class Start>
Result<T> run(const HttpRequest& request, const Caller& caller, const std::function<bool()>& client_gone,
              const Start& start) {
  const auto answer = std::make_shared<Answer<T>>();
  auto handle =
      start([answer, kept = meshes_of(request)](Result<T> result) { answer->set(std::move(result)); });
  Result<T> result = answer->wait(caller.deadline, client_gone);
  if (!result && handle && result.error().cause == Cause::Cancelled) handle->cancel();
  return result;
}

std::optional<Clock::time_point> deadline_after(Timeout timeout) {
  if (!timeout) return {};
  return Clock::now() + *timeout;
}

}  // namespace

bool IgnoreCase::operator()(std::string_view a, std::string_view b) const {
  return std::ranges::lexicographical_compare(
      a, b, {}, [](unsigned char c) { return std::tolower(c); },
      [](unsigned char c) { return std::tolower(c); });
}

/// A request on its way to its answer.
struct Gateway::Exchange {
  Exchange(const HttpRequest& of, const Jobs& jobs, bool is_new = false)
      : request(of), route(find_route(of.path)) {
    caller.transport = Transport::Http;
    if (route && route->endpoint == Endpoint::Compare) caller.kind = Kind::Compare;
    if (const auto id = of.header("Burnish-Request-Id"); is_request_id(id)) caller.request_id = id;
    caller.trace_id = trace_id_of(of.header("traceparent"));
    if (route && !route->is_open() && of.method != "OPTIONS")
      jobs.identify(of.header("Authorization"), caller, is_new);
  }

  bool is_work() const { return route && route->takes_meshes() && request.method == "POST"; }
  bool is_upload() const {
    return route && route->takes_uploads() && (request.method == "POST" || request.method == "PATCH") &&
           route->allows(request.method);
  }
  std::string id() const { return std::string(id_in(request.path, *route)); }

  const HttpRequest& request;
  const Route* const route;  ///< null: no such path
  Caller caller;
};

/// Answers as the gateway does when the body has come.
class Gateway::Taker final : public BodyTaker {
 public:
  Taker(const Gateway& gateway, const Exchange& exchange, std::unique_ptr<BodyTaker> taker)
      : gateway_(gateway), exchange_(exchange), taker_(std::move(taker)) {}

  Result<> take(std::string_view bytes) override { return taker_->take(bytes); }
  Result<HttpResponse> finish() override {
    auto answer = taker_->finish();
    return answer ? Result(gateway_.finish(exchange_, std::move(answer).value())) : std::move(answer);
  }

 private:
  const Gateway& gateway_;
  const Exchange exchange_;
  const std::unique_ptr<BodyTaker> taker_;
};

Gateway::Gateway(Jobs& jobs, DurableJobs& durable_jobs, Uploads& uploads, GatewayOptions options)
    : jobs_(jobs),
      jobs_api_(jobs, durable_jobs),
      uploads_api_(uploads),
      cors_(std::move(options.cors_origins)),
      page_(options.page),
      openapi_(openapi_document(jobs.limits())) {}

std::optional<HttpResponse> Gateway::answer_head(const HttpRequest& request,
                                                 const std::function<bool()>& client_gone) {
  Exchange exchange(request, jobs_, true);
  auto response = answer_head(exchange, client_gone);
  if (!response) return {};
  return finish(exchange, *std::move(response));
}

HttpResponse Gateway::handle(const HttpRequest& request, const std::function<bool()>& client_gone) {
  Exchange exchange(request, jobs_);
  auto response = answer_head(exchange, client_gone);
  if (!response) response = work(exchange, client_gone);
  return finish(exchange, *std::move(response));
}

HttpResponse Gateway::refuse(const HttpRequest& request, const Error& error) {
  Exchange exchange(request, jobs_);
  return finish(exchange, refuse(exchange, error));
}

HttpResponse Gateway::bad_request(int status, const Error& error) {
  const Caller caller{.transport = Transport::Http};
  jobs_.record_refusal(caller, error);
  HttpResponse response = problem(error, caller.request_id, status);
  response.headers["Burnish-Request-Id"] = caller.request_id;
  return response;
}

std::optional<BodyTaking> Gateway::take_body(const HttpRequest& request) {
  Exchange exchange(request, jobs_);
  if (!exchange.is_upload()) return {};
  if (exchange.caller.refusal) return BodyTaking{nullptr, answer_head(request).value()};
  auto taker = exchange.route->endpoint == Endpoint::Uploads
                   ? uploads_api_.create(request, exchange.caller)
                   : uploads_api_.append(request, exchange.caller, exchange.id());
  BodyTaking taking;
  if (taker) {
    taking.taker = std::make_unique<Taker>(*this, exchange, std::move(taker).value());
    return taking;
  }
  taking.refusal = refuse(exchange, taker.error());
  if (taker.error().cause == Cause::UploadOffsetMismatch)
    taking.refusal.headers["Upload-Offset"] = uploads_api_.offset_of(exchange.caller, exchange.id());
  taking.refusal = finish(exchange, std::move(taking.refusal));
  return taking;
}

std::optional<HttpResponse> Gateway::answer_head(Exchange& exchange,
                                                 const std::function<bool()>& client_gone) {
  const auto& [request, route, caller] = exchange;
  if (!route && is_page_path(request.path)) return answer_page(exchange);
  if (!route) return refuse(exchange, {Cause::NotFound, "there is nothing at " + request.path});
  const std::string allow(route->verbs);
  if (request.method == "OPTIONS") return HttpResponse{.status = 204, .headers = {{"Allow", allow}}};
  if (caller.refusal) return refuse(exchange, *caller.refusal);
  if (exchange.is_work()) return refuse_early(exchange);
  if (exchange.is_upload()) return {};
  if (route->allows(request.method)) {
    if (!route->is_kept()) return answer_read(exchange);
    auto answer = answer_kept(exchange, client_gone);
    return answer ? std::move(answer).value() : refuse(exchange, answer.error());
  }
  HttpResponse response = refuse(exchange, {Cause::MethodNotAllowed, request.path + " answers " + allow});
  response.headers["Allow"] = allow;
  return response;
}

HttpResponse Gateway::answer_page(Exchange& exchange) {
  const HttpRequest& request = exchange.request;
  auto answer = page_answer(page_, request);
  if (!answer) return refuse(exchange, answer.error());
  const std::string allow(kPageVerbs);
  if (request.method == "OPTIONS") return {.status = 204, .headers = {{"Allow", allow}}};
  if (request.method == "GET" || request.method == "HEAD") return std::move(answer).value();
  HttpResponse response = refuse(exchange, {Cause::MethodNotAllowed, request.path + " answers " + allow});
  response.headers["Allow"] = allow;
  return response;
}

Result<HttpResponse> Gateway::answer_kept(const Exchange& exchange,
                                          const std::function<bool()>& client_gone) {
  const auto& [request, route, caller] = exchange;
  const std::string id = exchange.id();
  switch (route->endpoint) {
    case Endpoint::Jobs:
      return jobs_api_.list(request, caller);
    case Endpoint::JobEvents:
      return jobs_api_.events(caller, id);
    case Endpoint::JobMesh:
      return jobs_api_.mesh(request, caller, id);
    case Endpoint::JobReport:
      return jobs_api_.report(caller, id);
    case Endpoint::Upload:
      return request.method == "DELETE" ? uploads_api_.remove(caller, id) : uploads_api_.get(caller, id);
    default:
      return request.method == "DELETE" ? jobs_api_.remove(caller, id)
                                        : jobs_api_.get(request, caller, id, client_gone);
  }
}

HttpResponse Gateway::answer_read(const Exchange& exchange) const {
  switch (exchange.route->endpoint) {
    case Endpoint::Methods:
      return text(to_json(list_methods(), false) + "\n", kJsonType);
    case Endpoint::OpenApi:
      return text(openapi_, kJsonType);
    case Endpoint::Metrics:
      return text(jobs_.metrics_text(), "text/plain; version=0.0.4; charset=utf-8");
    case Endpoint::Ready:
      return jobs_.serving() ? plain("ready\n") : not_ready(exchange);
    default:
      return plain("alive\n");
  }
}

HttpResponse Gateway::not_ready(const Exchange& exchange) const {
  const auto taken = jobs_.expect({}, 0, 0);
  const bool draining = !taken && taken.error().cause == Cause::ShuttingDown;
  return problem({Cause::ShuttingDown, draining ? taken.error().message : "the workers stand still"},
                 exchange.caller.request_id);
}

std::optional<HttpResponse> Gateway::refuse_early(Exchange& exchange) {
  if (exchange.route->endpoint == Endpoint::Jobs) {
    if (auto fine = jobs_api_.expect(exchange.request); !fine) return refuse(exchange, fine.error());
    return {};
  }
  const auto expected = exchange.route->endpoint == Endpoint::Smooth
                            ? expect_smooth(exchange.request, jobs_.service())
                            : expect_compare(exchange.request, jobs_.limits());
  if (!expected) return refuse(exchange, expected.error());
  exchange.caller.deadline = deadline_after(expected->timeout);
  const auto fits = jobs_.expect(exchange.caller, expected->mesh_bytes, expected->reference_bytes);
  if (!fits) return refuse(exchange, fits.error());
  return {};
}

HttpResponse Gateway::work(Exchange& exchange, const std::function<bool()>& client_gone) {
  if (exchange.route->endpoint == Endpoint::Smooth) return smooth(exchange, client_gone);
  if (exchange.route->endpoint == Endpoint::Compare) return compare(exchange, client_gone);
  auto submitted = jobs_api_.submit(exchange.request, exchange.caller);
  return submitted ? std::move(submitted).value() : refuse(exchange, submitted.error());
}

HttpResponse Gateway::smooth(Exchange& exchange, const std::function<bool()>& client_gone) {
  auto& [request, route, caller] = exchange;
  auto read = read_smooth(request, jobs_.service());
  if (!read) return refuse(exchange, read.error());
  const auto type = choose_smooth_answer(request.header("Accept"), result_format(read->job));
  if (!type) return refuse(exchange, type.error());
  caller.deadline = deadline_after(read->timeout);
  auto result = run<SmoothResult>(request, caller, client_gone, [&](Jobs::Done<SmoothResult> done) {
    return jobs_.smooth(exchange.caller, std::move(read->job), std::move(done));
  });
  return result ? smooth_answer(*std::move(result), *type) : problem(result.error(), caller.request_id);
}

HttpResponse Gateway::compare(Exchange& exchange, const std::function<bool()>& client_gone) {
  auto& [request, route, caller] = exchange;
  auto read = read_compare(request);
  if (!read) return refuse(exchange, read.error());
  caller.deadline = deadline_after(read->timeout);
  auto result = run<v1::CompareResponse>(request, caller, client_gone, [&](auto done) {
    return jobs_.compare(exchange.caller, std::move(read->job), std::move(done));
  });
  return result ? text(to_json(*result, true) + "\n", kJsonType) : problem(result.error(), caller.request_id);
}

/// Only requests for work count as such; finish() logs the others.
HttpResponse Gateway::refuse(Exchange& exchange, Error error) {
  error.message = printable(error.message);
  error.field = printable(error.field, 100);
  if (exchange.is_work()) jobs_.record_refusal(exchange.caller, error);
  HttpResponse response = problem(error, exchange.caller.request_id);
  if (error.cause == Cause::Unauthenticated) response.headers["WWW-Authenticate"] = "Bearer";
  return response;
}

HttpResponse Gateway::finish(const Exchange& exchange, HttpResponse response) const {
  const auto& [request, route, caller] = exchange;
  response.headers["Burnish-Request-Id"] = caller.request_id;
  cors_.allow(request, response);
  if (exchange.is_work()) return response;  // the jobs have logged it
  spdlog::log(route && route->is_probe() ? spdlog::level::debug : spdlog::level::info,
              "request id={}{}{} transport=http call={} {} status={}", caller.request_id,
              caller.trace_id.empty() ? "" : " trace=", caller.trace_id, printable(request.method, 10),
              printable(request.path, 100), response.status);
  return response;
}

}  // namespace burnish
