#include "server/grpc/call.h"

#include <string_view>
#include <vector>

#include "server/observe/trace.h"

namespace burnish {
namespace {

using Clock = RunControl::Clock;

/// The call's deadline on the clock that jobs use; none when it is so far away that it means none.
std::optional<Clock::time_point> steady_deadline(const grpc::ServerContextBase& context) {
  const auto left = context.deadline() - std::chrono::system_clock::now();
  if (left > std::chrono::hours(24 * 365)) return {};
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(left);
}

}  // namespace

void CallCount::enter() {
  const std::lock_guard lock(mutex_);
  ++calls_;
}

void CallCount::leave() {
  const std::lock_guard lock(mutex_);
  --calls_;
  changed_.notify_all();  // with the lock: whoever waits may destroy this object next
}

int CallCount::count() const {
  const std::lock_guard lock(mutex_);
  return calls_;
}

bool CallCount::wait_until_none(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, patience, [this] { return calls_ == 0; });
}

void OpenUploads::add(const std::shared_ptr<OpenUpload>& upload) {
  const std::lock_guard lock(mutex_);
  uploads_.emplace(upload.get(), upload);
}

void OpenUploads::remove(const OpenUpload* upload) {
  const std::lock_guard lock(mutex_);
  uploads_.erase(upload);
}

void OpenUploads::refuse_all(const Error& error) {
  std::vector<std::shared_ptr<OpenUpload>> uploads;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, upload] : uploads_) uploads.push_back(upload.lock());
  }
  for (const auto& upload : uploads) {
    if (upload) upload->refuse(error);
  }
}

Caller caller_of(grpc::ServerContextBase& context, Kind kind, const Jobs& jobs) {
  Caller caller;
  caller.transport = Transport::Grpc;
  caller.kind = kind;
  caller.deadline = steady_deadline(context);
  const auto& metadata = context.client_metadata();
  if (const auto trace = metadata.find("traceparent"); trace != metadata.end()) {
    caller.trace_id = trace_id_of({trace->second.data(), trace->second.size()});
  }
  const auto token = metadata.find("authorization");
  jobs.identify(token == metadata.end() ? "" : std::string_view(token->second.data(), token->second.size()),
                caller);
  context.AddInitialMetadata("burnish-request-id", caller.request_id);
  return caller;
}

bool deadline_passed(const Caller& caller) {
  return caller.deadline && Clock::now() + std::chrono::milliseconds(5) >= *caller.deadline;
}

}  // namespace burnish
