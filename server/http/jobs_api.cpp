#include "server/http/jobs_api.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "server/http/byte_range.h"
#include "server/http/header_value.h"
#include "server/http/job_request.h"
#include "server/http/media_type.h"
#include "server/http/problem.h"
#include "server/http/report_header.h"
#include "server/jobs/latest_job.h"

namespace burnish {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kAskClientEvery{15}, kEventsEvery{50};
constexpr seconds kLongestWait{60}, kHeartbeat{15};
constexpr int kMostListeners = 64;  // each holds a thread

HttpResponse json(int status, const google::protobuf::Message& message) {
  return {.status = status,
          .headers = {{"Content-Type", std::string(kJsonType)}, {"Cache-Control", "no-store"}},
          .body = to_json(message, true) + "\n"};
}

std::string path_of(const std::string& id) { return "/v1/jobs/" + id; }

std::string whole_seconds(milliseconds time) {
  return std::to_string(std::chrono::ceil<seconds>(time).count());
}

/// N of "Prefer: wait=N"; nothing: not asked for, or not a number.
std::optional<seconds> wait_of(std::string_view prefer) {
  for (const std::string_view item : split_value(prefer, ',')) {
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos || !same_ignoring_case(item.substr(0, equals), "wait")) continue;
    const std::string_view digits = item.substr(equals + 1);
    std::uint32_t value = 0;
    const auto [end, failure] = std::from_chars(digits.begin(), digits.end(), value);
    if (failure == std::errc() && end == digits.end()) return std::min(seconds(value), kLongestWait);
  }
  return {};
}

bool wants_mesh(std::string_view accept) {
  std::vector<std::string_view> offers{kJsonType};
  for (const FormatTraits& each : formats()) offers.push_back(each.media_type);
  offers.push_back(kAnyBytesType);
  const auto best = best_offer(accept, offers);
  return best && *best != kJsonType;
}

/// The format of a result, which is never unspecified.
std::string type_of(const v1::MeshFile& file) {
  return std::string(media_type_of(from_proto(file.format()).value_or(Format::Obj)));
}

}  // namespace

HttpResponse JobsApi::answer(int status, const v1::Job& job) const {
  HttpResponse response = json(status, job);
  if (!has_ended(job.state()))
    response.headers["Retry-After"] = whole_seconds(durable_jobs_.look_again_after());
  return response;
}

Result<> JobsApi::expect(const HttpRequest& head) const { return expect_submission(head, jobs_.service()); }

Result<HttpResponse> JobsApi::submit(const HttpRequest& request, const Caller& caller) {
  const auto submission = read_submission(request, jobs_.service());
  if (!submission) return submission.error();
  const auto job = durable_jobs_.submit(caller, *submission);
  if (!job) return job.error();
  HttpResponse response = answer(202, *job);
  response.headers["Location"] = path_of(job->id());
  return response;
}

Result<HttpResponse> JobsApi::list(const HttpRequest& request, const Caller& caller) {
  std::uint32_t page_size = 0;
  std::string page_token;
  for (const auto& [name, text] : request.query) {
    if (name == "page_size") {
      const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), page_size);
      if (failure != std::errc() || end != text.data() + text.size() || page_size == 0)
        return Error{Cause::BadOption, "page_size is '" + text + "', expected a whole number from 1", name};
    } else if (name == "page_token") {
      page_token = text;
    } else {
      return Error{Cause::UnknownOption, "there is no query parameter '" + name + "' here", name};
    }
  }
  const auto jobs = durable_jobs_.list(caller, page_size, page_token);
  if (!jobs) return jobs.error();
  return json(200, *jobs);
}

Result<HttpResponse> JobsApi::get(const HttpRequest& request, const Caller& caller, const std::string& id,
                                  const std::function<bool()>& client_gone) {
  const auto wait = wait_of(request.header("Prefer"));
  const auto latest = LatestJob::watch(durable_jobs_, caller, id);
  if (!latest) return latest.error();
  v1::Job job;
  std::uint64_t seen = 0;
  for (const auto until = Clock::now() + wait.value_or(seconds(0));;) {
    latest->wait(seen, kAskClientEvery, job);
    if (has_ended(job.state()) || Clock::now() >= until || client_gone() || !jobs_.serving()) break;
  }
  HttpResponse response = answer(200, job);
  if (wait) response.headers["Preference-Applied"] = "wait=" + std::to_string(wait->count());
  if (job.state() == v1::JOB_STATE_SUCCEEDED && wants_mesh(request.header("Accept"))) {
    response.status = 303;
    response.headers["Location"] = path_of(id) + "/mesh";
  }
  return response;
}

Result<HttpResponse> JobsApi::events(const Caller& caller, const std::string& id) {
  const auto place = std::shared_ptr<void>(nullptr, [listeners = listeners_](void*) { --*listeners; });
  if (++*listeners_ > kMostListeners) {
    return Error{.cause = Cause::QueueFull,
                 .message = "more than " + std::to_string(kMostListeners) + " callers listen to events",
                 .retry_after = kHeartbeat};
  }
  auto latest = LatestJob::watch(durable_jobs_, caller, id);
  if (!latest) return std::move(latest).error();
  const auto stream = [place, latest = std::move(latest).value()](const auto& send, const auto& gone) {
    v1::Job job;
    std::uint64_t seen = 0;
    std::uint64_t event = 0;
    auto quiet_since = Clock::now();
    while (!gone()) {
      std::string text;
      if (latest.wait(seen, kEventsEvery, job)) {
        text = "event: job\nid: " + std::to_string(++event) + "\ndata: " + to_json(job, true) + "\n\n";
      } else if (Clock::now() - quiet_since >= kHeartbeat) {
        text = ": still there\n\n";
      }
      if (text.empty()) continue;
      if (!send(text) || has_ended(job.state())) return;
      quiet_since = Clock::now();
      latest.pause(kEventsEvery);
    }
  };
  return HttpResponse{.headers = {{"Content-Type", "text/event-stream"}, {"Cache-Control", "no-store"}},
                      .stream = stream};
}

Result<HttpResponse> JobsApi::mesh(const HttpRequest& request, const Caller& caller, const std::string& id) {
  auto result = durable_jobs_.result(caller, id);
  if (!result) return std::move(result).error();
  const auto job = durable_jobs_.get(caller, id);
  if (!job) return job.error();
  const std::string etag = '"' + result->file.sha256() + '"';
  HttpResponse response{.headers = {{"Content-Type", type_of(result->file)},
                                    {"ETag", etag},
                                    {"Accept-Ranges", "bytes"},
                                    {"Cache-Control", "private, no-cache"},
                                    {"Burnish-Report", report_header(job->report())}}};
  const std::string_view known = request.header("If-None-Match");
  if (value_names(known, etag) || value_names(known, "W/" + etag) || known == "*") {
    response.status = 304;
    return response;
  }
  response.file = {.bytes = result->content.bytes, .owner = result->content.owner};
  const std::string_view same = request.header("If-Range");
  if (!same.empty() && same != etag) return response;
  const std::string size = std::to_string(response.file.bytes.size());
  const auto range = parse_range(request.header("Range"), response.file.bytes.size());
  if (!range) {
    HttpResponse refusal = problem(range.error(), caller.request_id);
    refusal.headers["Content-Range"] = "bytes */" + size;
    return refusal;
  }
  if (!*range) return response;
  response.status = 206;
  response.headers["Content-Range"] = "bytes " + std::to_string((*range)->first) + "-" +
                                      std::to_string((*range)->first + (*range)->size - 1) + "/" + size;
  response.file.bytes = response.file.bytes.substr((*range)->first, (*range)->size);
  return response;
}

Result<HttpResponse> JobsApi::report(const Caller& caller, const std::string& id) {
  if (auto there = durable_jobs_.result(caller, id); !there) return std::move(there).error();
  const auto job = durable_jobs_.get(caller, id);
  if (!job) return job.error();
  return json(200, job->report());
}

Result<HttpResponse> JobsApi::remove(const Caller& caller, const std::string& id) {
  const auto job = durable_jobs_.get(caller, id);
  if (!job) return job.error();
  if (!has_ended(job->state())) {
    const auto cancelled = durable_jobs_.cancel(caller, id);
    if (!cancelled) return cancelled.error();
    return json(202, *cancelled);
  }
  if (auto removed = durable_jobs_.remove(caller, id); !removed) return std::move(removed).error();
  return HttpResponse{.status = 204};
}

}  // namespace burnish
