// Private to the kept jobs: one that has not ended, and what their files share.
#pragma once

#include <algorithm>
#include <cctype>
#include <limits>

#include <google/protobuf/util/time_util.h>

#include "server/jobs/durable_jobs.h"

namespace burnish {

/// A second, or a minute: no caller is told to look sooner, or later.
constexpr std::chrono::milliseconds kShortestLook{1000}, kLongestLook{60'000};
constexpr std::uint64_t kLargestFile = std::numeric_limits<std::uint32_t>::max();  // of MeshFile::bytes

inline WallTime wall_now() { return std::chrono::system_clock::now(); }

inline void set_time(google::protobuf::Timestamp& to, WallTime time) {
  to = google::protobuf::util::TimeUtil::MillisecondsToTimestamp(
      std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count());
}

inline WallTime time_of(const google::protobuf::Timestamp& time) {
  return WallTime(std::chrono::milliseconds(google::protobuf::util::TimeUtil::TimestampToMilliseconds(time)));
}

inline v1::JobError to_proto(const Error& error) {
  v1::JobError proto;
  std::string code(cause_code(error.cause));
  std::ranges::transform(code, code.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  proto.set_code(code);
  proto.set_message(error.message);
  proto.set_field(error.field);
  return proto;
}

/// A job that has not ended.
struct DurableJobs::Entry {
  JobRecord record;
  v1::SmoothProgress progress = {};
  std::optional<JobHandle> handle = {};  ///< while a worker has it or is to have it
  bool over = false;                     ///< its end is on disk: whatever the worker still says is dropped
  std::map<const Watching*, Watcher> watchers = {};
  Clock::time_point started = {};
  double seconds = 0;  ///< of one core that it is expected to take
  std::optional<Clock::time_point> deadline = {};

  Turn turn() const { return {record.owner, record.job.priority() == v1::JOB_PRIORITY_LOW}; }

  v1::Job seen() const {
    v1::Job job = record.job;
    if (job.state() == v1::JOB_STATE_RUNNING) *job.mutable_progress() = progress;
    return job;
  }
};

/// Takes its watcher away when it goes.
struct DurableJobs::Watching {
  Watching(DurableJobs& of, EntryPtr at) : jobs(of), entry(std::move(at)) {}
  ~Watching() {
    const std::lock_guard lock(jobs.mutex_);
    entry->watchers.erase(this);
  }
  Watching(const Watching&) = delete;
  Watching& operator=(const Watching&) = delete;

  DurableJobs& jobs;
  const EntryPtr entry;
};

/// What a worker needs of a job, with the files in memory.
struct DurableJobs::Prepared {
  Caller caller;
  SmoothJob smooth;
  std::shared_ptr<const void> mesh = {}, reference = {};  ///< keep the bytes
};

}  // namespace burnish
