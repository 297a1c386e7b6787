// What all calls share: who asks, how many are under way, which of them still wait for bytes.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include <grpcpp/server_context.h>

#include "server/jobs/jobs.h"

namespace burnish {

/// How many calls are under way, from their arrival until their answer has been sent. Thread-safe.
class CallCount {
 public:
  void enter();
  void leave();
  int count() const;
  /// False when calls are still under way after `patience`.
  bool wait_until_none(std::chrono::milliseconds patience);

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int calls_ = 0;  ///< guarded by mutex_
};

/// A call whose bytes are still coming.
class OpenUpload {
 public:
  virtual ~OpenUpload() = default;
  /// Answers with the error, unless all bytes have come. Thread-safe.
  virtual void refuse(const Error& error) = 0;
};

/// Thread-safe.
class OpenUploads {
 public:
  void add(const std::shared_ptr<OpenUpload>& upload);
  void remove(const OpenUpload* upload);
  void refuse_all(const Error& error);

 private:
  std::mutex mutex_;
  std::map<const OpenUpload*, std::weak_ptr<OpenUpload>> uploads_;  ///< guarded by mutex_
};

struct CallLimits {
  std::uint64_t max_message_bytes = std::uint64_t{8} << 20;  ///< of one message
  std::chrono::milliseconds idle{60'000};  ///< for a caller's next message, or for taking the next of ours
};

/// What a call needs of its server.
struct CallHome {
  Jobs& jobs;
  const CallLimits limits;
  CallCount calls = {};
  OpenUploads uploads = {};
};

/// Who calls, from the call's metadata, or why this caller is refused; sends the request id with the answer.
Caller caller_of(grpc::ServerContextBase& context, Kind kind, const Jobs& jobs);

/// Whether the deadline passed, or is so near that a cancellation now comes from it.
bool deadline_passed(const Caller& caller);

}  // namespace burnish
