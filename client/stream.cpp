#include "client/stream.h"

#include <algorithm>
#include <exception>
#include <future>
#include <string_view>

#include "client/status_error.h"

namespace burnish::client {
namespace {

/// Cancels the call when an exception leaves the scope, or the other direction would wait for ever.
class CancelOnException {
 public:
  explicit CancelOnException(grpc::ClientContext& context) : context_(context) {}
  ~CancelOnException() {
    if (std::uncaught_exceptions() > before_) context_.TryCancel();
  }
  CancelOnException(const CancelOnException&) = delete;
  CancelOnException& operator=(const CancelOnException&) = delete;

 private:
  grpc::ClientContext& context_;
  const int before_ = std::uncaught_exceptions();
};

v1::SmoothStreamRequest start_of(const v1::SmoothRequest& request) {
  v1::SmoothStreamRequest message;
  v1::SmoothStart& start = *message.mutable_start();
  start.set_format(request.format());
  start.set_reference_format(request.reference_format());
  *start.mutable_options() = request.options();
  start.set_mesh_bytes(request.mesh().size());
  start.set_reference_bytes(request.reference().size());
  return message;
}

v1::CompareStreamRequest start_of(const v1::CompareRequest& request) {
  v1::CompareStreamRequest message;
  v1::CompareStart& start = *message.mutable_start();
  start.set_format(request.format());
  start.set_reference_format(request.reference_format());
  start.set_mesh_bytes(request.mesh().size());
  start.set_reference_bytes(request.reference().size());
  return message;
}

/// Calls send(chunk) for each, until it says that the call is over.
template <class Send>
bool send_chunks(std::string_view bytes, Send&& send) {
  for (; !bytes.empty(); bytes.remove_prefix(std::min(kChunkBytes, bytes.size()))) {
    if (!send(bytes.substr(0, kChunkBytes))) return false;
  }
  return true;
}

/// One write at a time. A write that fails only says that the call is over: why, its status says.
template <class Message, class Request, class Stream>
void upload(Stream& stream, const Request& request) {
  Message message = start_of(request);
  const auto send_mesh = [&](std::string_view chunk) {
    message.set_mesh_chunk(chunk.data(), chunk.size());
    return stream.Write(message);
  };
  const auto send_reference = [&](std::string_view chunk) {
    message.set_reference_chunk(chunk.data(), chunk.size());
    return stream.Write(message);
  };
  if (stream.Write(message) && send_chunks(request.mesh(), send_mesh) &&
      send_chunks(request.reference(), send_reference)) {
    stream.WritesDone();
  }
}

/// The parts of the server's answer, put together.
class Download {
 public:
  explicit Download(const ProgressFunction& progress) : progress_(progress) {}

  /// False when the answer cannot be carried.
  bool take(v1::SmoothStreamResponse& part) {
    if (part.has_progress() && progress_) progress_(part.progress());
    if (part.has_report()) *response_.mutable_report() = std::move(*part.mutable_report());
    if (!part.has_mesh_chunk()) return true;
    if (part.mesh_chunk().size() > kLargestMeshBytes - response_.mesh().size()) return false;
    if (response_.mesh().empty()) {
      response_.mutable_mesh()->swap(*part.mutable_mesh_chunk());
    } else {
      response_.mutable_mesh()->append(part.mesh_chunk());
    }
    return true;
  }

  Result<v1::SmoothResponse> finish() && {
    if (!response_.has_report()) {
      return Error{grpc::StatusCode::INTERNAL, "internal", "the server's answer ended before its report"};
    }
    response_.set_format(response_.report().encoding().format());
    return std::move(response_);
  }

 private:
  const ProgressFunction& progress_;
  v1::SmoothResponse response_;
};

}  // namespace

Result<v1::SmoothResponse> smooth_by_stream(v1::SmoothingService::Stub& stub, grpc::ClientContext& context,
                                            const v1::SmoothRequest& request,
                                            const ProgressFunction& progress) {
  const auto stream = stub.SmoothStream(&context);
  // Reads go on meanwhile: a server that refuses early, or talks before it listens, is heard at once.
  auto uploaded = std::async(std::launch::async, [&] {
    const CancelOnException cancel(context);
    upload<v1::SmoothStreamRequest>(*stream, request);
  });
  const CancelOnException cancel(context);  // before the future, whose destructor waits for the upload
  Download download(progress);
  v1::SmoothStreamResponse part;
  bool carried = true;
  while (carried && stream->Read(&part)) carried = download.take(part);
  if (!carried) context.TryCancel();
  uploaded.get();
  const grpc::Status status = stream->Finish();
  if (!carried) {
    return Error{grpc::StatusCode::RESOURCE_EXHAUSTED, "too_large",
                 "the answer has more than " + std::to_string(kLargestMeshBytes) + " bytes"};
  }
  if (!status.ok()) return error_from(status);
  return std::move(download).finish();
}

Result<v1::CompareResponse> compare_by_stream(v1::SmoothingService::Stub& stub, grpc::ClientContext& context,
                                              const v1::CompareRequest& request) {
  v1::CompareResponse response;
  const auto stream = stub.CompareStream(&context, &response);
  upload<v1::CompareStreamRequest>(*stream, request);
  const grpc::Status status = stream->Finish();
  if (!status.ok()) return error_from(status);
  return response;
}

}  // namespace burnish::client
