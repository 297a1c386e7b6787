// The parts of the gRPC side that need no server.
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "server/grpc/grpc_status.h"
#include "server/grpc/upload.h"
#include "tests/server/running_grpc.h"

namespace burnish {
namespace {

using testing::detail_of;

TEST(GrpcStatus, SaysWhenToTryAgain) {
  const auto delay = [](const Error& error) {
    const auto retry = detail_of<google::rpc::RetryInfo>(to_grpc_status(error, "id"));
    return retry ? retry->retry_delay().seconds() * 1000 + retry->retry_delay().nanos() / 1'000'000 : -1;
  };
  EXPECT_EQ(delay({Cause::QueueFull, "full", "", std::chrono::milliseconds(2500)}), 2500);
  EXPECT_EQ(delay({Cause::Internal, "odd", "", std::chrono::milliseconds(7)}), 7);
  for (const Cause cause : all_causes()) {
    const bool passes =
        cause == Cause::QueueFull || cause == Cause::MemoryFull || cause == Cause::ShuttingDown;
    EXPECT_EQ(delay({cause, "no time known"}), passes ? 1000 : -1) << cause_code(cause);
  }
}

TEST(GrpcStatus, FitsForeignTextIntoMetadata) {
  const grpc::Status status = to_grpc_status({Cause::BadOption, std::string(100'000, '\xff'), "f\n"}, "id");
  EXPECT_LT(status.error_message().size() + status.error_details().size(), 8000u);
  EXPECT_EQ(detail_of<google::rpc::BadRequest>(status)->field_violations(0).field(), "f?");
}

TEST(Upload, KeepsBothPartsApart) {
  Spool spool;
  Upload upload(spool, 100);
  ASSERT_TRUE(upload.start({}).ok());
  ASSERT_TRUE(upload.append(UploadPart::Mesh, "me").ok());
  ASSERT_TRUE(upload.append(UploadPart::Reference, "ref").ok());
  ASSERT_TRUE(upload.append(UploadPart::Mesh, "sh").ok());
  ASSERT_TRUE(upload.finish(true).ok());
  EXPECT_EQ(upload.mesh(), "mesh");
  EXPECT_EQ(upload.reference(), "ref");
}

}  // namespace
}  // namespace burnish
