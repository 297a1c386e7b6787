// Smooth and Compare: one message in, one out.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/grpc/call.h"

namespace burnish {

/// Both give a reactor that deletes itself. `request` and `response` belong to gRPC and live as long as it.
grpc::ServerUnaryReactor* smooth_unary(CallHome& home, grpc::CallbackServerContext& context,
                                       grpc::ByteBuffer& request, grpc::ByteBuffer& response);
grpc::ServerUnaryReactor* compare_unary(CallHome& home, grpc::CallbackServerContext& context,
                                        grpc::ByteBuffer& request, grpc::ByteBuffer& response);

}  // namespace burnish
