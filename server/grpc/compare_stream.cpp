#include "server/grpc/compare_stream.h"

#include <memory>
#include <optional>
#include <utility>

#include "server/grpc/stream_call.h"

namespace burnish {
namespace {

using Reactor = grpc::ServerReadReactor<grpc::ByteBuffer>;

class CompareStream final : public StreamCall<Reactor> {
 public:
  CompareStream(CallHome& home, grpc::CallbackServerContext& context, grpc::ByteBuffer& response)
      : StreamCall(home, Kind::Compare, context), response_(response) {}

 private:
  Result<> take(grpc::ByteBuffer& bytes) override {
    v1::CompareStreamRequest message;
    if (auto parsed = parse_part(bytes, message); !parsed) return parsed;
    switch (message.part_case()) {
      case v1::CompareStreamRequest::kStart:
        return start(message.start());
      case v1::CompareStreamRequest::kMeshChunk:
        return upload_->append(UploadPart::Mesh, message.mesh_chunk());
      case v1::CompareStreamRequest::kReferenceChunk:
        return upload_->append(UploadPart::Reference, message.reference_chunk());
      case v1::CompareStreamRequest::PART_NOT_SET:
        break;
    }
    return Upload::empty_message();
  }

  Result<> start(const v1::CompareStart& start) {
    const UploadSizes sizes{start.mesh_bytes(), start.reference_bytes()};
    if (auto started = upload_->start(sizes); !started) return started;
    if (auto formats = set_formats(start, job_); !formats) return formats;
    return home_.jobs.expect(caller_, sizes.mesh, sizes.reference);
  }

  bool needs_reference() const override { return true; }

  std::optional<JobHandle> submit_upload(std::shared_ptr<Upload> upload) override {
    const auto self = std::static_pointer_cast<CompareStream>(shared_from_this());
    CompareJob job = std::move(job_);
    job.reference = upload->reference();
    job.mesh = upload->mesh();
    return home_.jobs.compare(
        caller_, std::move(job),
        [self, upload](const Result<v1::CompareResponse>& result) { self->answer(result); });
  }

  void answer(const Result<v1::CompareResponse>& result) {
    const std::lock_guard lock(mutex_);
    if (!result) return finish(status_of_error(result.error()));
    response_ = serialise(*result);
    finish(grpc::Status::OK);
  }

  grpc::ByteBuffer& response_;
  CompareJob job_;  ///< without its meshes, until submit()
};

}  // namespace

Reactor* compare_stream(CallHome& home, grpc::CallbackServerContext& context, grpc::ByteBuffer& response) {
  const auto call = std::make_shared<CompareStream>(home, context, response);  // keeps itself until OnDone
  call->begin();
  return call.get();
}

}  // namespace burnish
