// The half that all calls with a mesh share: bytes come in until the caller has no more, then there is a job,
// then an answer.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/grpc/call.h"
#include "server/grpc/grpc_status.h"
#include "server/grpc/messages.h"
#include "server/grpc/timer.h"

namespace burnish {

/// `Reactor` is gRPC's for the kind of the call. Reactions, the job's worker, the timer and the server's stop
/// come on threads of their own; mutex_ puts them in order, and phase_ says what each may still do. gRPC
/// never runs a reaction within a call to it, so reads, writes and Finish are started with the lock.
template <class Reactor>
class UploadCall : public Reactor,
                   public OpenUpload,
                   public std::enable_shared_from_this<UploadCall<Reactor>> {
 public:
  /// `idle`: how long its caller may neither send a message nor take one; 0: for ever.
  UploadCall(CallHome& home, Kind kind, grpc::CallbackServerContext& context, std::chrono::milliseconds idle)
      : home_(home), caller_(caller_of(context, kind, home.jobs)), idle_(idle), context_(context) {
    home_.calls.enter();
  }

  /// Called within the handler, once.
  void begin() {
    self_ = this->shared_from_this();
    home_.uploads.add(self_);
    const std::lock_guard lock(mutex_);
    if (phase_ != Phase::Uploading) return;
    // Before the first byte, and after the server can find this call: one that stops misses none.
    if (auto chance = home_.jobs.expect(caller_, 0, 0); !chance) return end(chance.error());
    if (idle_.count() > 0) watch(idle_);
    this->StartRead(&in_);
  }

  void refuse(const Error& error) override {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::Uploading) end(error);
  }

  void OnReadDone(bool ok) override {
    std::unique_lock lock(mutex_);
    if (phase_ != Phase::Uploading) return;
    moved_at_ = Clock::now();
    if (!ok) {
      if (context_.IsCancelled()) return end(cancelled(deadline_passed(caller_)));
      if (auto whole = finish_upload(); !whole) return end(whole.error());
      run(lock);
    } else if (auto taken = take(in_); !taken) {
      end(taken.error());
    } else {
      this->StartRead(&in_);
    }
  }

  void OnCancel() override {
    std::unique_lock lock(mutex_);
    const bool late = deadline_passed(caller_);
    if (phase_ == Phase::Uploading) return end(cancelled(late));
    if (late) return;  // the job sees its deadline itself and says so
    cancelled_ = true;
    auto handle = handle_;
    lock.unlock();
    if (handle) handle->cancel();
  }

  void OnDone() override {
    std::shared_ptr<UploadCall> self;
    {
      const std::lock_guard lock(mutex_);
      phase_ = Phase::Done;
      timer_.stop();
      handle_.reset();
      self = std::move(self_);
    }
    home_.calls.leave();
  }

 protected:
  using Clock = RunControl::Clock;
  /// Only forwards. Running: all bytes are here, a job has them. Answering: it is done. Finished: gRPC has
  /// the status. Done: gRPC has forgotten the call.
  enum class Phase : std::uint8_t { Uploading, Running, Answering, Finished, Done };

  // All with the lock, except submit(), after which nobody else looks at what was uploaded.
  virtual Result<> take(grpc::ByteBuffer& message) = 0;
  virtual Result<> finish_upload() = 0;
  virtual void drop_upload() = 0;
  virtual std::optional<JobHandle> submit() = 0;
  virtual void submitted() {}

  /// With the lock.
  void finish(const grpc::Status& status) {
    phase_ = Phase::Finished;
    this->Finish(status);
  }
  grpc::Status status_of_error(const Error& error) const { return to_grpc_status(error, caller_.request_id); }

  CallHome& home_;
  const Caller caller_;
  std::mutex mutex_;  ///< guards everything below
  Phase phase_ = Phase::Uploading;
  Clock::time_point moved_at_ = Clock::now();  ///< when the caller last did something

 private:
  static Error cancelled(bool late) {
    if (late) return {Cause::DeadlineExceeded, "the deadline passed before all bytes had come"};
    return {Cause::Cancelled, "the caller went away before all bytes had come"};
  }

  void leave_upload(Phase next) {
    phase_ = next;
    home_.uploads.remove(this);
  }

  void end(const Error& error) {
    leave_upload(Phase::Finished);
    drop_upload();
    home_.jobs.record_refusal(caller_, error);
    this->Finish(status_of_error(error));
  }

  /// The job may be refused or done before submit() returns, on this thread, so it comes without the lock.
  void run(std::unique_lock<std::mutex>& lock) {
    leave_upload(Phase::Running);
    lock.unlock();
    auto handle = submit();
    lock.lock();
    if (phase_ != Phase::Running) return;
    handle_ = handle;
    submitted();
    const bool gone = cancelled_;
    lock.unlock();
    if (gone && handle) handle->cancel();
  }

  void watch(std::chrono::milliseconds delay) {
    timer_.set(delay, [weak = this->weak_from_this()] {
      if (const auto self = weak.lock()) self->look_after();
    });
  }

  /// Ends calls whose caller neither sends nor takes anything for too long.
  void look_after() {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::Done) return;
    if (phase_ == Phase::Running) moved_at_ = Clock::now();  // it is our turn
    const auto idle = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - moved_at_);
    if (idle < idle_) return watch(idle_ - idle);
    if (phase_ == Phase::Uploading) {
      return end({Cause::RequestTimeout,
                  "nothing came for " + std::to_string(idle.count()) + " ms before the end of the bytes"});
    }
    context_.TryCancel();
  }

  const std::chrono::milliseconds idle_;
  grpc::CallbackServerContext& context_;  ///< until Done
  grpc::ByteBuffer in_;
  Timer timer_;
  bool cancelled_ = false;
  std::optional<JobHandle> handle_;
  std::shared_ptr<UploadCall> self_;  ///< until Done
};

}  // namespace burnish
