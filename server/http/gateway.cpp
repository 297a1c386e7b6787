#include "server/http/gateway.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/http/problem.h"
#include "server/http/report_header.h"
#include "server/http/smooth_query.h"
#include "server/observe/log.h"

namespace burnish {
namespace {

using Clock = RunControl::Clock;
using std::chrono::milliseconds;

constexpr milliseconds kAskClientEvery{15};
/// A job that polls its deadline answers within this; one inside a library call is not waited for.
constexpr milliseconds kDeadlineSlack{25};

constexpr std::string_view kSmoothPath = "/v1/smooth";
constexpr std::array<std::string_view, 4> kReadPaths{"/v1/methods", "/livez", "/readyz", "/metrics"};

HttpResponse text(std::string body, const char* type = "text/plain; charset=utf-8") {
  return {.status = 200, .headers = {{"Content-Type", type}}, .body = std::move(body)};
}

/// Where a job leaves its answer for the thread that waits for it. Shared, for either may be gone first.
class Answer {
 public:
  void set(Result<SmoothResult> result) {
    const std::lock_guard lock(mutex_);
    result_ = std::move(result);
    changed_.notify_one();
  }

  /// The answer; Cancelled when `give_up` comes true, DeadlineExceeded when the job is late for its deadline.
  Result<SmoothResult> wait(std::optional<Clock::time_point> deadline, const std::function<bool()>& give_up) {
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
  std::optional<Result<SmoothResult>> result_;
};

HttpResponse not_allowed(const std::string& path, bool to_smooth) {
  const std::string allow = to_smooth ? "POST" : "GET, HEAD";
  HttpResponse response = problem({Cause::MethodNotAllowed, path + " answers " + allow}, new_request_id());
  response.headers["Allow"] = allow;
  return response;
}

HttpResponse mesh_response(SmoothResult result, const std::string& request_id) {
  return {.status = 200,
          .headers = {{"Content-Type", result.format == Format::Obj ? "model/obj" : "model/vnd.draco"},
                      {"Burnish-Report", report_header(result.report)},
                      {"Burnish-Request-Id", request_id}},
          .body = std::move(result.mesh)};
}

}  // namespace

bool IgnoreCase::operator()(std::string_view a, std::string_view b) const {
  return std::ranges::lexicographical_compare(
      a, b, {}, [](unsigned char c) { return std::tolower(c); },
      [](unsigned char c) { return std::tolower(c); });
}

Error body_too_large(std::uint64_t limit) {
  return {Cause::TooLarge,
          "the body has more than " + std::to_string(limit) + " bytes, the limit of this server"};
}

std::optional<HttpResponse> Gateway::answer_head(const HttpRequest& request) {
  const bool to_smooth = request.path == kSmoothPath;
  if (!to_smooth && std::ranges::find(kReadPaths, request.path) == kReadPaths.end()) {
    return problem({Cause::NotFound, "there is nothing at " + printable(request.path, 100)},
                   new_request_id());
  }
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (to_smooth ? request.method != "POST" : !reads) return not_allowed(request.path, to_smooth);
  return to_smooth ? refuse_early(request) : answer_read(request.path);
}

HttpResponse Gateway::answer_read(std::string_view path) {
  if (path == "/v1/methods") return text(to_json(list_methods(), false) + "\n", "application/json");
  if (path == "/metrics") return text(jobs_.metrics_text(), "text/plain; version=0.0.4; charset=utf-8");
  if (path == "/livez") return text("alive\n");
  if (jobs_.serving()) return text("ready\n");
  return problem({Cause::ShuttingDown, "the server does not take work now"}, new_request_id());
}

std::optional<HttpResponse> Gateway::refuse_early(const HttpRequest& request) {
  if (!jobs_.serving()) return refuse({Cause::ShuttingDown, "the server is shutting down"});
  if (const auto query = parse_smooth_query(request); !query) return refuse(query.error());
  std::uint64_t length = 0;
  const std::string_view digits = request.header("Content-Length");
  std::from_chars(digits.data(), digits.data() + digits.size(), length);
  if (length > jobs_.limits().max_bytes) return refuse(body_too_large(jobs_.limits().max_bytes));
  return {};
}

HttpResponse Gateway::handle(const HttpRequest& request, const std::function<bool()>& client_gone) {
  if (auto response = answer_head(request)) return *std::move(response);
  return smooth(request, client_gone);
}

HttpResponse Gateway::smooth(const HttpRequest& request, const std::function<bool()>& client_gone) {
  const auto query = parse_smooth_query(request);
  if (!query) return refuse(query.error());
  SmoothJob job;
  job.mesh = request.body ? *request.body : std::string_view();
  job.format = query.value().format;
  job.options = query.value().options;
  job.request_id = new_request_id();
  const std::string id = job.request_id;
  std::optional<Clock::time_point> deadline;
  if (query.value().timeout) deadline = Clock::now() + *query.value().timeout;

  const auto answer = std::make_shared<Answer>();
  auto handle = jobs_.submit(
      Transport::Http, std::move(job), deadline,
      [answer, body = request.body](Result<SmoothResult> result) { answer->set(std::move(result)); });
  Result<SmoothResult> result = answer->wait(deadline, client_gone);
  if (result) return mesh_response(std::move(result).value(), id);
  if (handle && result.error().cause == Cause::Cancelled) handle->cancel();
  return problem(result.error(), id);
}

HttpResponse Gateway::refuse(const Error& error) {
  const std::string id = new_request_id();
  jobs_.record_refusal(Transport::Http, id, error);
  return problem(error, id);
}

}  // namespace burnish
