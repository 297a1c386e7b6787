// Smooth and Compare: one message in, one out.
#pragma once

#include <grpcpp/generic/async_generic_service.h>

#include "server/grpc/call.h"

namespace burnish {

/// As what a unary call is on the wire: a stream with one message each way. gRPC hands over a call that is
/// registered as unary when its message is here, but a refusal must not wait for one, nor hold its memory.
/// Any other method that nobody serves comes here as well, and is told so.
class UnaryCalls final : public grpc::CallbackGenericService {
 public:
  explicit UnaryCalls(CallHome& home) : home_(home) {}

  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext* context) override;

 private:
  CallHome& home_;
};

}  // namespace burnish
