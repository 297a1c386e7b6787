// The half that SmoothStream and CompareStream share: the mesh and its reference come in chunks.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "server/grpc/upload.h"
#include "server/grpc/upload_call.h"

namespace burnish {

/// A small limit for unary calls must not keep streams from sending chunks of 1 MiB.
inline constexpr std::uint64_t kLeastStreamMessage = std::uint64_t{2} << 20;

template <class Reactor>
class StreamCall : public UploadCall<Reactor> {
 public:
  StreamCall(CallHome& home, Kind kind, grpc::CallbackServerContext& context)
      : UploadCall<Reactor>(home, kind, context, home.limits.idle),
        upload_(std::make_shared<Upload>(home.jobs.spool(), home.jobs.limits().mesh.max_bytes)) {}

 protected:
  virtual bool needs_reference() const = 0;
  virtual std::optional<JobHandle> submit_upload(std::shared_ptr<Upload> upload) = 0;

  Result<> parse_part(grpc::ByteBuffer& bytes, google::protobuf::Message& message) const {
    return parse(bytes,
                 {std::max(this->home_.limits.max_message_bytes, kLeastStreamMessage),
                  "a message of the stream", "one message", "send chunks of at most 1 MiB"},
                 message);
  }

  std::shared_ptr<Upload> upload_;  ///< while Uploading

 private:
  Result<> finish_upload() final { return upload_->finish(needs_reference()); }
  void drop_upload() final { upload_.reset(); }
  std::optional<JobHandle> submit() final { return submit_upload(std::move(upload_)); }
};

}  // namespace burnish
