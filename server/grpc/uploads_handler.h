// burnish.v1.UploadService.
#pragma once

#include "burnish/v1/jobs.grpc.pb.h"
#include "server/grpc/call.h"
#include "server/jobs/uploads.h"

namespace burnish {

class UploadsHandler final : public v1::UploadService::Service {
 public:
  UploadsHandler(CallHome& home, Uploads& uploads) : home_(home), uploads_(uploads) {}

  grpc::Status CreateUpload(grpc::ServerContext* context, const v1::CreateUploadRequest* request,
                            v1::Upload* response) override;
  grpc::Status GetUpload(grpc::ServerContext* context, const v1::GetUploadRequest* request,
                         v1::Upload* response) override;
  grpc::Status AppendUpload(grpc::ServerContext* context, grpc::ServerReader<v1::AppendUploadRequest>* reader,
                            v1::Upload* response) override;
  grpc::Status DeleteUpload(grpc::ServerContext* context, const v1::DeleteUploadRequest* request,
                            v1::DeleteUploadResponse* response) override;

 private:
  CallHome& home_;
  Uploads& uploads_;
};

}  // namespace burnish
