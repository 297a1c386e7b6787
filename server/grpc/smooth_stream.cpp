#include "server/grpc/smooth_stream.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/grpc/stream_call.h"

namespace burnish {
namespace {

using Reactor = grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
constexpr std::chrono::milliseconds kProgressEvery{50};

class SmoothStream final : public StreamCall<Reactor> {
 public:
  SmoothStream(CallHome& home, grpc::CallbackServerContext& context)
      : StreamCall(home, Kind::Smooth, context) {}

  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    broken_ = !ok;
    moved_at_ = Clock::now();
    pump();
  }

 private:
  Result<> take(grpc::ByteBuffer& bytes) override {
    v1::SmoothStreamRequest message;
    if (auto parsed = parse_part(bytes, message); !parsed) return parsed;
    switch (message.part_case()) {
      case v1::SmoothStreamRequest::kStart:
        return start(std::move(*message.mutable_start()));
      case v1::SmoothStreamRequest::kMeshChunk:
        return upload_->append(UploadPart::Mesh, message.mesh_chunk());
      case v1::SmoothStreamRequest::kReferenceChunk:
        return upload_->append(UploadPart::Reference, message.reference_chunk());
      case v1::SmoothStreamRequest::PART_NOT_SET:
        break;
    }
    return Upload::empty_message();
  }

  /// Whatever can be refused without the mesh is refused here.
  Result<> start(v1::SmoothStart start) {
    const UploadSizes sizes{start.mesh_bytes(), start.reference_bytes()};
    if (auto started = upload_->start(sizes); !started) return started;
    if (auto formats = set_formats(start, job_); !formats) return formats;
    if (auto fine = home_.jobs.service().check(start.options()); !fine) return fine;
    job_.options.Swap(start.mutable_options());
    return home_.jobs.expect(caller_, sizes.mesh, sizes.reference);
  }

  bool needs_reference() const override { return false; }

  std::optional<JobHandle> submit_upload(std::shared_ptr<Upload> upload) override {
    const auto self = std::static_pointer_cast<SmoothStream>(shared_from_this());
    SmoothJob job = std::move(job_);
    job.mesh = upload->mesh();
    job.reference = upload->reference();
    job.progress = [self](v1::SmoothStage stage, double fraction) { self->report_progress(stage, fraction); };
    return home_.jobs.smooth(caller_, std::move(job), [self, upload](Result<SmoothResult> result) {
      self->answer(std::move(result));
    });
  }

  void submitted() override {
    if (!progress_) show(v1::SMOOTH_STAGE_QUEUE, 0);
  }

  void report_progress(v1::SmoothStage stage, double fraction) {
    const std::lock_guard lock(mutex_);
    show(stage, fraction);
  }

  /// The latest state only: a caller that reads slowly must not slow the worker or fill the memory.
  void show(v1::SmoothStage stage, double fraction) {
    if (phase_ != Phase::Running) return;
    progress_.emplace();
    progress_->set_stage(stage);
    progress_->set_fraction(fraction);
    unsent_progress_ = true;
    pump();
  }

  void answer(Result<SmoothResult> result) {
    const std::lock_guard lock(mutex_);
    phase_ = Phase::Answering;
    moved_at_ = Clock::now();
    if (result) {
      if (!result->mesh.empty()) mesh_ = std::make_shared<const std::string>(std::move(result->mesh));
      report_.Swap(&result->report);
    } else {
      error_ = std::move(result).error();
    }
    pump();
  }

  /// Sends what comes next, unless a write is under way: then OnWriteDone comes back here.
  void pump() {
    if (writing_) return;
    if (phase_ == Phase::Running) return pump_progress();
    if (phase_ != Phase::Answering) return;
    if (error_) return finish(status_of_error(*error_));
    if (broken_) return finish(status_of_error({Cause::Cancelled, "the caller went away"}));
    if (!mesh_) return write_report();
    const std::size_t size = std::min(kChunkBytes, mesh_->size() - sent_);
    out_ = mesh_chunk(mesh_, sent_, size);
    sent_ += size;
    if (sent_ == mesh_->size()) mesh_.reset();  // gRPC frees the rest as it leaves
    write();
  }

  void pump_progress() {
    if (broken_ || !unsent_progress_) return;
    const auto early = next_progress_ - Clock::now();
    if (early > Clock::duration::zero())
      return pump_later(std::chrono::ceil<std::chrono::milliseconds>(early));
    next_progress_ = Clock::now() + kProgressEvery;
    unsent_progress_ = false;
    v1::SmoothStreamResponse message;
    *message.mutable_progress() = *progress_;
    out_ = serialise(message);
    write();
  }

  /// The worker may have nothing more to tell for long, so the latest state goes out by itself.
  void pump_later(std::chrono::milliseconds delay) {
    if (std::exchange(later_, true)) return;
    const auto self = std::static_pointer_cast<SmoothStream>(shared_from_this());
    progress_timer_.set(delay, [weak = std::weak_ptr(self)] {
      const auto stream = weak.lock();
      if (!stream) return;
      const std::lock_guard lock(stream->mutex_);
      stream->later_ = false;
      stream->pump();
    });
  }

  void write() {
    writing_ = true;
    StartWrite(&out_);
  }

  void write_report() {
    v1::SmoothStreamResponse message;
    message.mutable_report()->Swap(&report_);
    out_ = serialise(message);
    phase_ = Phase::Finished;
    StartWriteAndFinish(&out_, grpc::WriteOptions(), grpc::Status::OK);
  }

  // Guarded by mutex_, except job_, which submit() alone takes after the upload.
  SmoothJob job_;
  grpc::ByteBuffer out_;  ///< what is being written
  bool writing_ = false;
  bool broken_ = false;  ///< a write failed: the caller is gone
  std::optional<v1::SmoothProgress> progress_;
  bool unsent_progress_ = false, later_ = false;
  Clock::time_point next_progress_ = {};
  Timer progress_timer_;
  std::optional<Error> error_;
  std::shared_ptr<const std::string> mesh_;  ///< null once all of it was handed to gRPC
  std::size_t sent_ = 0;
  v1::SmoothReport report_;
};

}  // namespace

Reactor* smooth_stream(CallHome& home, grpc::CallbackServerContext& context) {
  const auto call = std::make_shared<SmoothStream>(home, context);  // keeps itself until OnDone
  call->begin();
  return call.get();
}

}  // namespace burnish
