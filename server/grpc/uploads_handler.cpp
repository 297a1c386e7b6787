#include "server/grpc/uploads_handler.h"

#include <utility>

#include "server/grpc/kept_call.h"

namespace burnish {

grpc::Status UploadsHandler::CreateUpload(grpc::ServerContext* context,
                                          const v1::CreateUploadRequest* request, v1::Upload* response) {
  const KeptCall call(home_, *context, "CreateUpload");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  return call.answer(uploads_.create(call.caller(), request->bytes(), request->sha256()), response);
}

grpc::Status UploadsHandler::GetUpload(grpc::ServerContext* context, const v1::GetUploadRequest* request,
                                       v1::Upload* response) {
  const KeptCall call(home_, *context, "GetUpload");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  return call.answer(uploads_.get(call.caller(), request->id()), response);
}

grpc::Status UploadsHandler::AppendUpload(grpc::ServerContext* context,
                                          grpc::ServerReader<v1::AppendUploadRequest>* reader,
                                          v1::Upload* response) {
  const KeptCall call(home_, *context, "AppendUpload");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  v1::AppendUploadRequest message;
  if (!reader->Read(&message) || !message.has_start())
    return call.failed({Cause::BadRequest, "the first message is not a start"});
  auto append = uploads_.append(call.caller(), message.start().id(), message.start().offset());
  if (!append) return call.failed(append.error());
  bool last = false;
  while (!last && reader->Read(&message)) {
    last = message.has_end();
    if (last) break;
    if (!message.has_chunk())
      return call.failed({Cause::BadRequest, "a message after the start is neither a chunk nor the end"});
    if (auto written = (*append)->write(message.chunk()); !written) return call.failed(written.error());
  }
  if (call.over()) return call.failed(call.over_error());  // what came is kept
  return call.answer((*append)->finish(last), response);
}

grpc::Status UploadsHandler::DeleteUpload(grpc::ServerContext* context,
                                          const v1::DeleteUploadRequest* request, v1::DeleteUploadResponse*) {
  const KeptCall call(home_, *context, "DeleteUpload");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  const auto removed = uploads_.remove(call.caller(), request->id());
  return removed ? call.ok() : call.failed(removed.error());
}

}  // namespace burnish
