#include "server/grpc/smoothing_handler.h"

#include <chrono>
#include <mutex>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/grpc/grpc_status.h"

namespace burnish {
namespace {

using Clock = RunControl::Clock;

/// The call's deadline on the clock that jobs use; none when it is so far away that it means none.
std::optional<Clock::time_point> steady_deadline(const grpc::CallbackServerContext& context) {
  const auto left = context.deadline() - std::chrono::system_clock::now();
  if (left > std::chrono::hours(24 * 365)) return {};
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(left);
}

SmoothJob to_job(const v1::SmoothRequest& request) {
  SmoothJob job;
  job.mesh = request.mesh();
  job.format = from_proto(request.format());
  job.reference = request.reference();
  job.reference_format = from_proto(request.reference_format());
  job.options = request.options();
  job.request_id = new_request_id();
  return job;
}

/// One call. gRPC keeps request and response until OnDone, which comes after Finish and after every reaction.
class SmoothReactor final : public grpc::ServerUnaryReactor {
 public:
  SmoothReactor(CallCount& calls, std::optional<Clock::time_point> deadline)
      : calls_(calls), deadline_(deadline) {
    calls_.enter();
  }

  /// Called within the handler, before gRPC knows the reactor: a Finish is held back until the handler
  /// returned.
  void start(SmoothJobs& jobs, const v1::SmoothRequest& request, v1::SmoothResponse& response) {
    SmoothJob job = to_job(request);
    auto done = [this, &response, id = job.request_id](Result<SmoothResult> result) {
      Finish(result ? fill(response, *result) : to_grpc_status(result.error(), id));
    };
    auto handle = jobs.submit(Transport::Grpc, std::move(job), deadline_, std::move(done));
    const std::lock_guard lock(mutex_);
    handle_ = std::move(handle);
  }

  void OnCancel() override {
    // A passed deadline also comes as a cancellation; the job sees its deadline itself and says so.
    if (deadline_ && Clock::now() + std::chrono::milliseconds(5) >= *deadline_) return;
    std::unique_lock lock(mutex_);
    auto handle = handle_;
    lock.unlock();
    if (handle) handle->cancel();
  }

  void OnDone() override {
    calls_.leave();
    delete this;
  }

 private:
  static grpc::Status fill(v1::SmoothResponse& response, SmoothResult& result) {
    response.set_mesh(std::move(result.mesh));
    response.set_format(to_proto(result.format));
    response.mutable_report()->Swap(&result.report);
    return grpc::Status::OK;
  }

  CallCount& calls_;
  const std::optional<Clock::time_point> deadline_;
  std::mutex mutex_;
  std::optional<JobHandle> handle_;  ///< guarded by mutex_
};

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

bool CallCount::wait_until_none(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, patience, [this] { return calls_ == 0; });
}

grpc::ServerUnaryReactor* SmoothingHandler::Smooth(grpc::CallbackServerContext* context,
                                                   const v1::SmoothRequest* request,
                                                   v1::SmoothResponse* response) {
  auto* reactor = new SmoothReactor(calls_, steady_deadline(*context));  // deletes itself in OnDone
  reactor->start(jobs_, *request, *response);
  return reactor;
}

grpc::ServerUnaryReactor* SmoothingHandler::ListMethods(grpc::CallbackServerContext* context,
                                                        const v1::ListMethodsRequest* /*request*/,
                                                        v1::ListMethodsResponse* response) {
  spdlog::info("request transport=grpc call=ListMethods");
  *response = list_methods();
  auto* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace burnish
