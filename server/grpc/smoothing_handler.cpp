#include "server/grpc/smoothing_handler.h"

#include <spdlog/spdlog.h>

#include "server/grpc/compare_stream.h"
#include "server/grpc/grpc_status.h"
#include "server/grpc/messages.h"
#include "server/grpc/smooth_stream.h"

namespace burnish {
namespace {

/// The request is the call's own object, which gRPC never reads again.
grpc::ByteBuffer& own(const grpc::ByteBuffer* request) { return *const_cast<grpc::ByteBuffer*>(request); }

}  // namespace

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* SmoothingHandler::SmoothStream(
    grpc::CallbackServerContext* context) {
  return smooth_stream(home_, *context);
}

grpc::ServerReadReactor<grpc::ByteBuffer>* SmoothingHandler::CompareStream(
    grpc::CallbackServerContext* context, grpc::ByteBuffer* response) {
  return compare_stream(home_, *context, *response);
}

grpc::ServerUnaryReactor* SmoothingHandler::ListMethods(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request,
                                                        grpc::ByteBuffer* response) {
  const Caller caller = caller_of(*context, Kind::Smooth, home_.jobs);
  v1::ListMethodsRequest nothing;
  const auto parsed =
      caller.refusal
          ? Result<>(*caller.refusal)
          : parse(own(request),
                  {home_.limits.max_message_bytes, "the request", "a unary call", "it needs no bytes"},
                  nothing);
  spdlog::info("request id={} transport=grpc call=ListMethods", caller.request_id);
  if (parsed) *response = serialise(list_methods());
  auto* reactor = context->DefaultReactor();
  reactor->Finish(parsed ? grpc::Status::OK : to_grpc_status(parsed.error(), caller.request_id));
  return reactor;
}

}  // namespace burnish
