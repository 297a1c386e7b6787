#include "server/grpc/unary.h"

#include <memory>
#include <optional>
#include <utility>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "server/grpc/upload_call.h"
#include "server/observe/log.h"

namespace burnish {
namespace {

using Reactor = grpc::ServerGenericBidiReactor;
using std::chrono::milliseconds;

struct Smooth {
  using Request = v1::SmoothRequest;
  using Answer = SmoothResult;
  using Job = SmoothJob;
  static constexpr Kind kKind = Kind::Smooth;
  static constexpr std::string_view kAdvice = "use SmoothStream";

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
  using Job = CompareJob;
  static constexpr Kind kKind = Kind::Compare;
  static constexpr std::string_view kAdvice = "use CompareStream";

  static Result<CompareJob> job(const Request& request) {
    CompareJob job;
    if (auto formats = set_formats(request, job); !formats) return formats.error();
    job.reference = request.reference();
    job.mesh = request.mesh();
    return job;
  }
};

template <class Rpc>
class UnaryCall final : public UploadCall<Reactor> {
 public:
  /// Idle for ever: nobody tells how much of the one message has come, and a slow one is not idle.
  UnaryCall(CallHome& home, grpc::CallbackServerContext& context)
      : UploadCall(home, Rpc::kKind, context, milliseconds::zero()) {}

 private:
  Result<> take(grpc::ByteBuffer& bytes) override {
    if (request_) return Error{Cause::BadRequest, "a unary call has one message, and a second one came"};
    request_ = std::make_shared<typename Rpc::Request>();
    const MessageLimit limit{home_.limits.max_message_bytes, "the request", "a unary call", Rpc::kAdvice};
    if (auto parsed = parse(bytes, limit, *request_); !parsed) return parsed;
    auto job = Rpc::job(*request_);
    if (!job) return std::move(job).error();
    job_ = std::move(job).value();
    return {};
  }

  Result<> finish_upload() override {
    if (!request_) return Error{Cause::BadRequest, "the call ended before its message"};
    return {};
  }

  void drop_upload() override { request_.reset(); }

  std::optional<JobHandle> submit() override {
    const auto self = std::static_pointer_cast<UnaryCall>(shared_from_this());
    Jobs::Done<typename Rpc::Answer> done = [self, request = std::move(request_)](auto result) {
      self->answer(std::move(result));
    };
    if constexpr (Rpc::kKind == Kind::Smooth) {
      return home_.jobs.smooth(caller_, std::move(job_), std::move(done));
    } else {
      return home_.jobs.compare(caller_, std::move(job_), std::move(done));
    }
  }

  void answer(Result<typename Rpc::Answer> result) {
    const std::lock_guard lock(mutex_);
    if (!result) return finish(status_of_error(result.error()));
    response_ = serialise(std::move(*result));
    phase_ = Phase::Finished;
    StartWriteAndFinish(&response_, grpc::WriteOptions(), grpc::Status::OK);
  }

  std::shared_ptr<typename Rpc::Request> request_;  ///< the job's views point to it
  typename Rpc::Job job_;
  grpc::ByteBuffer response_;
};

class UnknownMethod final : public Reactor {
 public:
  explicit UnknownMethod(const std::string& method) {
    Finish({grpc::StatusCode::UNIMPLEMENTED, "there is no method " + printable(method, 100)});
  }
  void OnDone() override { delete this; }
};

/// Keeps itself until OnDone.
template <class Rpc>
Reactor* serve(CallHome& home, grpc::CallbackServerContext& context) {
  const auto call = std::make_shared<UnaryCall<Rpc>>(home, context);
  call->begin();
  return call.get();
}

}  // namespace

Reactor* UnaryCalls::CreateReactor(grpc::GenericCallbackServerContext* context) {
  const std::string service = std::string("/") + v1::SmoothingService::service_full_name() + "/";
  if (context->method() == service + "Smooth") return serve<Smooth>(home_, *context);
  if (context->method() == service + "Compare") return serve<Compare>(home_, *context);
  return new UnknownMethod(context->method());
}

}  // namespace burnish
