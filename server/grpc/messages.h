// Messages of the contract from and to gRPC's bytes. Calls are raw because gRPC's own parsing would answer a
// message that is too long, or that is none, in words of its own, and would copy every mesh twice.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <grpcpp/support/byte_buffer.h>

#include "burnish/v1/smoothing.pb.h"
#include "server/service/smooth_service.h"

namespace burnish {

/// How long a message may be, and the words for one that is longer.
struct MessageLimit {
  std::uint64_t bytes = 0;
  std::string_view what = {};     ///< "the request"
  std::string_view carrier = {};  ///< "a unary call"
  std::string_view advice = {};   ///< "use SmoothStream"
};

/// Reads a message, gzip or plain, and empties the buffer. Errors: TooLarge when it is longer than the limit,
/// compressed or not; BadRequest when it is no such message.
Result<> parse(grpc::ByteBuffer& buffer, const MessageLimit& limit, google::protobuf::Message& message);

/// Errors: BadOption for a number that the enum does not know.
Result<std::optional<Format>> checked_format(v1::MeshFormat format, const char* field);

/// The formats of a request or a start into a job; errors as above.
template <class Message, class Job>
Result<> set_formats(const Message& message, Job& job) {
  auto format = checked_format(message.format(), "format");
  if (!format) return format.error();
  auto reference_format = checked_format(message.reference_format(), "reference_format");
  if (!reference_format) return reference_format.error();
  job.format = *format;
  job.reference_format = *reference_format;
  return {};
}

grpc::ByteBuffer serialise(const google::protobuf::Message& message);

/// A SmoothResponse; the mesh is moved, not copied.
grpc::ByteBuffer serialise(SmoothResult&& result);

/// A SmoothStreamResponse with `size` bytes of the mesh from `offset` on; they are shared, not copied.
grpc::ByteBuffer mesh_chunk(const std::shared_ptr<const std::string>& mesh, std::size_t offset,
                            std::size_t size);

}  // namespace burnish
