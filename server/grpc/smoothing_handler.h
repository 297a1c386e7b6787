// burnish.v1.SmoothingService on gRPC's callback API. Nothing here blocks: jobs run on the runner's workers.
#pragma once

#include "burnish/v1/smoothing.grpc.pb.h"
#include "server/grpc/call.h"

namespace burnish {

/// Every method gets its requests as bytes; messages.h says why. Smooth and Compare are in unary.h.
template <class Service>
using WithRawMethods = typename Service::template WithGenericMethod_Smooth<
    typename Service::template WithRawCallbackMethod_SmoothStream<
        typename Service::template WithGenericMethod_Compare<
            typename Service::template WithRawCallbackMethod_CompareStream<
                typename Service::template WithRawCallbackMethod_ListMethods<typename Service::Service>>>>>;

class SmoothingHandler final : public WithRawMethods<v1::SmoothingService> {
 public:
  SmoothingHandler(Jobs& jobs, const CallLimits& limits) : home_{jobs, limits} {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* SmoothStream(
      grpc::CallbackServerContext* context) override;
  grpc::ServerReadReactor<grpc::ByteBuffer>* CompareStream(grpc::CallbackServerContext* context,
                                                           grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListMethods(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;

  CallHome& home() { return home_; }
  CallCount& calls() { return home_.calls; }
  const CallCount& calls() const { return home_.calls; }
  OpenUploads& uploads() { return home_.uploads; }

 private:
  CallHome home_;
};

}  // namespace burnish
