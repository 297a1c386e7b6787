#include "server/grpc/messages.h"

#include <array>
#include <utility>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/gzip_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/wire_format_lite.h>
#include <grpcpp/support/proto_buffer_reader.h>
#include <zlib.h>

namespace burnish {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;
using google::protobuf::io::GzipInputStream;
using google::protobuf::io::LimitingInputStream;

/// What gzip starts with. No message does: it would be a field of wire type 7, which does not exist.
constexpr unsigned char kGzip = 0x1f;

Error too_large(const std::string& bytes, const MessageLimit& limit) {
  return {Cause::TooLarge, std::string(limit.what) + " has " + bytes + " bytes, " +
                               std::string(limit.carrier) + " carries " + std::to_string(limit.bytes) +
                               " (max-unary-bytes); " + std::string(limit.advice)};
}

Error not_a(const google::protobuf::Message& message) {
  return {Cause::BadRequest, "the bytes are no " + message.GetTypeName()};
}

bool is_gzip(grpc::ProtoBufferReader& reader) {
  const void* data = nullptr;
  int size = 0;
  if (!reader.Next(&data, &size)) return false;
  const bool gzip = size > 0 && *static_cast<const unsigned char*>(data) == kGzip;
  reader.BackUp(size);
  return gzip;
}

Result<> parse_gzip(grpc::ProtoBufferReader& reader, const MessageLimit& limit,
                    google::protobuf::Message& message) {
  const auto most = static_cast<std::int64_t>(limit.bytes);
  GzipInputStream inflated(&reader, GzipInputStream::GZIP);
  LimitingInputStream limited(&inflated, most + 1);
  const bool whole = message.ParseFromZeroCopyStream(&limited);
  if (limited.ByteCount() > most) return too_large("more than " + std::to_string(most), limit);
  // A damaged stream looks to the parser as if it just ended.
  if (!whole || inflated.ZlibErrorCode() != Z_STREAM_END) return not_a(message);
  return {};
}

grpc::Slice share(const std::shared_ptr<const std::string>& text, std::size_t offset, std::size_t size) {
  auto* const owner = new std::shared_ptr<const std::string>(text);
  const auto release = [](void* data) { delete static_cast<std::shared_ptr<const std::string>*>(data); };
  // gRPC only reads what it sends.
  return {const_cast<char*>(text->data()) + offset, size, release, owner};
}

/// The head of a bytes field of `size` bytes: its tag and its length.
grpc::Slice bytes_head(int field, std::size_t size) {
  std::array<std::uint8_t, 16> head{};
  std::uint8_t* end = CodedOutputStream::WriteTagToArray(
      WireFormatLite::MakeTag(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED), head.data());
  end = CodedOutputStream::WriteVarint64ToArray(size, end);
  return {head.data(), static_cast<std::size_t>(end - head.data())};
}

}  // namespace

Result<> parse(grpc::ByteBuffer& buffer, const MessageLimit& limit, google::protobuf::Message& message) {
  Result<> result;
  if (buffer.Length() > limit.bytes) {
    result = too_large(std::to_string(buffer.Length()), limit);
  } else if (grpc::ProtoBufferReader reader(&buffer); is_gzip(reader)) {
    result = parse_gzip(reader, limit, message);
  } else if (!message.ParseFromZeroCopyStream(&reader)) {
    result = not_a(message);
  }
  buffer.Clear();
  return result;
}

Result<std::optional<Format>> checked_format(v1::MeshFormat format, const char* field) {
  if (v1::MeshFormat_IsValid(format)) return from_proto(format);
  return Error{Cause::BadOption,
               std::string(field) + " is " + std::to_string(format) + ", which is no format", field};
}

grpc::ByteBuffer serialise(const google::protobuf::Message& message) {
  const grpc::Slice slice(message.SerializeAsString());
  return {&slice, 1};
}

grpc::ByteBuffer serialise(SmoothResult&& result) {
  v1::SmoothResponse rest;
  rest.set_format(to_proto(result.format));
  rest.mutable_report()->Swap(&result.report);
  const auto mesh = std::make_shared<const std::string>(std::move(result.mesh));
  // Fields of a message may follow each other in any pieces: the mesh's, then all others.
  const std::array slices{bytes_head(v1::SmoothResponse::kMeshFieldNumber, mesh->size()),
                          share(mesh, 0, mesh->size()), grpc::Slice(rest.SerializeAsString())};
  return {slices.data(), slices.size()};
}

grpc::ByteBuffer mesh_chunk(const std::shared_ptr<const std::string>& mesh, std::size_t offset,
                            std::size_t size) {
  const std::array slices{bytes_head(v1::SmoothStreamResponse::kMeshChunkFieldNumber, size),
                          share(mesh, offset, size)};
  return {slices.data(), slices.size()};
}

}  // namespace burnish
