#include "server/grpc/unary.h"

#include <memory>
#include <mutex>
#include <utility>

#include "server/grpc/grpc_status.h"
#include "server/grpc/messages.h"

namespace burnish {
namespace {

struct Smooth {
  using Request = v1::SmoothRequest;
  using Answer = SmoothResult;
  static constexpr Kind kKind = Kind::Smooth;
  static constexpr std::string_view kAdvice = "use SmoothStream";
  static constexpr auto kSubmit = &Jobs::smooth;

  static Result<SmoothJob> job(const Request& request) {
    SmoothJob job;
    if (auto formats = set_formats(request, job); !formats) return formats.error();
    job.mesh = request.mesh();
    job.reference = request.reference();
    job.options = request.options();
    return job;
  }
};

struct Compare {
  using Request = v1::CompareRequest;
  using Answer = v1::CompareResponse;
  static constexpr Kind kKind = Kind::Compare;
  static constexpr std::string_view kAdvice = "use CompareStream";
  static constexpr auto kSubmit = &Jobs::compare;

  static Result<CompareJob> job(const Request& request) {
    CompareJob job;
    if (auto formats = set_formats(request, job); !formats) return formats.error();
    job.reference = request.reference();
    job.mesh = request.mesh();
    return job;
  }
};

/// One call. gRPC keeps the response until OnDone, which comes after Finish and after every reaction.
template <class Rpc>
class UnaryCall final : public grpc::ServerUnaryReactor {
 public:
  UnaryCall(CallHome& home, grpc::CallbackServerContext& context)
      : home_(home), caller_(caller_of(context, Rpc::kKind, home.jobs)) {
    home_.calls.enter();
  }

  /// Called within the handler, before gRPC knows the reactor: a Finish is held back until the handler
  /// returned.
  void start(grpc::ByteBuffer& bytes, grpc::ByteBuffer& response) {
    if (caller_.refusal) return refuse(*caller_.refusal);
    const auto request = std::make_shared<typename Rpc::Request>();
    const MessageLimit limit{home_.limits.max_message_bytes, "the request", "a unary call", Rpc::kAdvice};
    if (auto parsed = parse(bytes, limit, *request); !parsed) return refuse(parsed.error());
    auto job = Rpc::job(*request);
    if (!job) return refuse(job.error());
    auto done = [this, &response, request](Result<typename Rpc::Answer> result) {
      if (!result) return Finish(to_grpc_status(result.error(), caller_.request_id));
      response = serialise(std::move(*result));
      Finish(grpc::Status::OK);
    };
    auto handle = (home_.jobs.*Rpc::kSubmit)(caller_, std::move(*job), std::move(done));
    const std::lock_guard lock(mutex_);
    handle_ = std::move(handle);
  }

  void OnCancel() override {
    // The job sees its deadline itself and says so.
    if (deadline_passed(caller_)) return;
    std::unique_lock lock(mutex_);
    auto handle = handle_;
    lock.unlock();
    if (handle) handle->cancel();
  }

  void OnDone() override {
    home_.calls.leave();
    delete this;
  }

 private:
  void refuse(const Error& error) {
    home_.jobs.record_refusal(caller_, error);
    Finish(to_grpc_status(error, caller_.request_id));
  }

  CallHome& home_;
  const Caller caller_;
  std::mutex mutex_;
  std::optional<JobHandle> handle_;  ///< guarded by mutex_
};

template <class Rpc>
grpc::ServerUnaryReactor* serve(CallHome& home, grpc::CallbackServerContext& context,
                                grpc::ByteBuffer& request, grpc::ByteBuffer& response) {
  auto* call = new UnaryCall<Rpc>(home, context);  // deletes itself in OnDone
  call->start(request, response);
  return call;
}

}  // namespace

grpc::ServerUnaryReactor* smooth_unary(CallHome& home, grpc::CallbackServerContext& context,
                                       grpc::ByteBuffer& request, grpc::ByteBuffer& response) {
  return serve<Smooth>(home, context, request, response);
}

grpc::ServerUnaryReactor* compare_unary(CallHome& home, grpc::CallbackServerContext& context,
                                        grpc::ByteBuffer& request, grpc::ByteBuffer& response) {
  return serve<Compare>(home, context, request, response);
}

}  // namespace burnish
