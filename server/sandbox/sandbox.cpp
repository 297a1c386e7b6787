#include "server/sandbox/sandbox.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/mapped_files.h"
#include "server/sandbox/helper_process.h"
#include "server/sandbox/messages.h"

namespace burnish {
namespace {

using std::chrono::milliseconds;
using Clock = RunControl::Clock;

constexpr milliseconds kStart{30'000}, kTick{50};
constexpr std::uint64_t kAlignment = 64;
constexpr int kAttempts = 2;

}  // namespace

/// A job on its way to a helper and back.
struct Sandbox::Exchange {
  sandbox::Request request;
  std::string_view mesh, reference;
  std::function<void(v1::SmoothStage stage, double fraction)> progress = {};
  std::vector<int> files = {};
  sandbox::Reply reply = {};
  std::string result = {};
  bool unread = false;  ///< the helper ended before it saw the job, so that another may have it
};

Result<std::unique_ptr<Sandbox>> Sandbox::start(const SandboxOptions& options) {
  std::unique_ptr<Sandbox> sandbox(new Sandbox(options));
  for (unsigned i = 0; i < options.helpers; ++i) {
    auto helper = sandbox->new_helper();
    if (!helper) return std::move(helper).error();
    sandbox->idle_.push_back(std::move(helper).value());
  }
  return sandbox;
}

Sandbox::~Sandbox() = default;

Result<Sandbox::HelperPtr> Sandbox::new_helper() {
  auto started = HelperProcess::start(options_.program);
  if (!started) return std::move(started).error();
  HelperPtr helper = std::move(started).value();
  sandbox::Reply ready;
  const bool came_up = helper->jobs().send(setup_of(options_.limits, options_.max_memory)) &&
                       helper->jobs().receive(ready, kStart) == Channel::Got::Message;
  if (!came_up) return Error{Cause::Internal, "a helper process did not come up: " + helper->end()};
  if (ready.has_failure()) return error_of(ready.failure());
  const std::lock_guard lock(mutex_);
  all_.push_back(helper);
  return helper;
}

Result<Sandbox::HelperPtr> Sandbox::take() {
  {
    std::unique_lock lock(mutex_);
    came_back_.wait(lock, [this] { return !idle_.empty() || missing_ > 0; });
    if (!idle_.empty()) {
      HelperPtr helper = std::move(idle_.back());  // the last to work: its memory is warm
      idle_.pop_back();
      return helper;
    }
    --missing_;
  }
  auto helper = new_helper();
  if (helper) return helper;
  const std::lock_guard lock(mutex_);
  ++missing_;
  came_back_.notify_one();
  return helper;
}

void Sandbox::give_back(const HelperPtr& helper) {
  helper->input().tidy();
  helper->output().tidy();
  const std::lock_guard lock(mutex_);
  idle_.push_back(helper);
  came_back_.notify_one();
}

/// What to say of a job whose helper is gone.
Error Sandbox::lose(const HelperPtr& helper) {
  const int id = helper->id();
  {
    const std::lock_guard lock(mutex_);
    std::erase(all_, helper);
  }
  const std::string ending = helper->end();
  ++ended_;
  spdlog::error("helper process {} ended: {}", id, ending);
  const std::lock_guard lock(mutex_);
  ++missing_;
  came_back_.notify_one();
  if (ending.starts_with("signal 9 "))
    return {Cause::OutOfMemory,
            "the process that worked on the mesh was killed, most likely for want of memory"};
  return {Cause::Internal, "the process that worked on the mesh ended: " + ending};
}

Result<> Sandbox::hand_over(Exchange& exchange, HelperProcess& helper, const RunControl& run) const {
  exchange.files.clear();
  std::uint64_t next = 0;
  const auto place = [&](std::string_view bytes, sandbox::Place& at) -> Result<> {
    at.set_bytes(bytes.size());
    if (const auto file = MappedFile::holding(bytes); file && !bytes.empty()) {
      at.set_in_file(true);
      at.set_offset(file->offset);
      exchange.files.push_back(file->file);
      return {};
    }
    at.set_offset(next);
    if (auto written = helper.input().write(next, bytes, run); !written) return written;
    next = (next + bytes.size() + kAlignment - 1) / kAlignment * kAlignment;
    return {};
  };
  if (auto placed = place(exchange.mesh, *exchange.request.mutable_mesh()); !placed) return placed;
  return place(exchange.reference, *exchange.request.mutable_reference());
}

Result<> Sandbox::perform(Exchange& exchange, const RunControl& run) {
  sandbox::Request& request = exchange.request;
  request.set_threads(run.threads);
  request.set_progress(static_cast<bool>(exchange.progress));
  for (int attempt = 1;; ++attempt) {
    auto taken = take();
    if (!taken) return std::move(taken).error();
    const HelperPtr helper = std::move(taken).value();
    if (auto placed = hand_over(exchange, *helper, run); !placed) {
      give_back(helper);
      return placed;
    }
    if (run.deadline) {
      const auto left = std::chrono::duration_cast<std::chrono::microseconds>(*run.deadline - Clock::now());
      request.set_deadline_us(std::max<std::int64_t>(1, left.count()));
    }
    request.set_job(new_job());
    if (helper->jobs().send(request, exchange.files)) {
      auto outcome = await_end(exchange, helper, run);
      if (!exchange.unread || attempt == kAttempts) return outcome;
    } else if (const Error lost = lose(helper); attempt == kAttempts) {
      return lost;
    }
    exchange.unread = false;
  }
}

Result<> Sandbox::await_end(Exchange& exchange, const HelperPtr& helper, const RunControl& run) {
  sandbox::Cancel cancel;
  cancel.set_job(exchange.request.job());
  std::optional<std::stop_callback<std::function<void()>>> on_stop(std::in_place, run.stop,
                                                                   [&] { helper->cancels().send(cancel); });
  std::optional<Clock::time_point> stopped_since;
  for (;;) {
    const auto got = helper->jobs().receive(exchange.reply, kTick);
    if (got == Channel::Got::Gone || got == Channel::Got::Unread) {
      exchange.unread = got == Channel::Got::Unread;
      on_stop.reset();
      return lose(helper);
    }
    if (got == Channel::Got::Message && exchange.reply.ended()) break;
    if (got == Channel::Got::Message && exchange.progress)
      exchange.progress(exchange.reply.progress().stage(), exchange.reply.progress().fraction());
    if (!run.stopped()) continue;
    if (!stopped_since) stopped_since = Clock::now();
    if (Clock::now() - *stopped_since < options_.patience) continue;
    on_stop.reset();
    spdlog::warn("helper process {} does not stop: killed", helper->id());
    lose(helper);
    return run.stop_error();
  }
  on_stop.reset();
  Result<> outcome;
  if (exchange.reply.has_failure()) {
    outcome = error_of(exchange.reply.failure());
  } else if (auto copied = helper->output().copy(exchange.reply.bytes(), run)) {
    exchange.result = std::move(copied).value();
  } else {
    outcome = std::move(copied).error();
  }
  give_back(helper);
  return outcome;
}

Result<SmoothResult> Sandbox::smooth(const SmoothJob& job, const RunControl& run) {
  Exchange exchange{.request = {}, .mesh = job.mesh, .reference = job.reference, .progress = job.progress};
  sandbox::Request& request = exchange.request;
  if (job.format) request.set_format(to_proto(*job.format));
  if (job.reference_format) request.set_reference_format(to_proto(*job.reference_format));
  *request.mutable_options() = job.options;
  request.set_request_id(job.request_id);
  request.set_queue_ms(job.queue_ms);
  if (auto done = perform(exchange, run); !done) return std::move(done).error();
  return SmoothResult{.mesh = std::move(exchange.result),
                      .format = from_proto(exchange.reply.format()).value_or(Format::Obj),
                      .report = std::move(*exchange.reply.mutable_report())};
}

Result<v1::CompareResponse> Sandbox::compare(const CompareJob& job, const RunControl& run) {
  Exchange exchange{.request = {}, .mesh = job.mesh, .reference = job.reference};
  sandbox::Request& request = exchange.request;
  request.set_compare(true);
  if (job.format) request.set_format(to_proto(*job.format));
  if (job.reference_format) request.set_reference_format(to_proto(*job.reference_format));
  request.set_request_id(job.request_id);
  request.set_queue_ms(job.queue_ms);
  if (auto done = perform(exchange, run); !done) return std::move(done).error();
  return std::move(*exchange.reply.mutable_comparison());
}

std::uint64_t Sandbox::resident_bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const HelperPtr& helper : all_) sum += helper->resident_bytes();
  return sum;
}

std::vector<int> Sandbox::helper_ids() const {
  const std::lock_guard lock(mutex_);
  std::vector<int> ids;
  for (const HelperPtr& helper : all_) ids.push_back(helper->id());
  return ids;
}

}  // namespace burnish
