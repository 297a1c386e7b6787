// SmoothStream: a mesh of any size up, progress, the result and the report down.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/grpc/call.h"

namespace burnish {

/// A reactor that deletes itself.
grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* smooth_stream(
    CallHome& home, grpc::CallbackServerContext& context);

}  // namespace burnish
