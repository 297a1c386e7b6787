#include "core/io/draco_header.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

namespace burnish {
namespace {

constexpr std::size_t kHeaderBytes = 11;      // "DRACO", version (2), geometry, method, flags (2)
constexpr std::size_t kPeekBytes = 64 << 10;  // metadata stands before the counts, and is seldom longer

/// The library's decoder up to the counts.
template <class Base>
class CountsDecoder final : public Base {
 public:
  explicit CountsDecoder(DracoMethod method) : method_(method) {}

  std::optional<DracoCounts> peek(std::string_view bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    draco::Mesh mesh;
    static_cast<void>(this->Decode({}, &buffer, &mesh));  // fails: DecodeConnectivity() says so
    return counts_;
  }

 protected:
  bool DecodeConnectivity() override {
    counts_ = declared_counts(*this->buffer(), method_);
    return false;
  }

 private:
  DracoMethod method_;
  std::optional<DracoCounts> counts_;
};

}  // namespace

bool read_count(draco::DecoderBuffer& buffer, bool plain, std::uint32_t* count) {
  return plain ? buffer.Decode(count) : draco::DecodeVarint(count, &buffer);
}

std::optional<DracoCounts> declared_counts(draco::DecoderBuffer buffer, DracoMethod method) {
  const auto version = buffer.bitstream_version();
  const bool sequential = method == DracoMethod::Sequential;
  const bool plain = version < (sequential ? DRACO_BITSTREAM_VERSION(2, 2) : DRACO_BITSTREAM_VERSION(2, 0));
  DracoCounts counts;
  std::uint32_t skipped = 0;
  if (!sequential && version < DRACO_BITSTREAM_VERSION(2, 2) && !read_count(buffer, plain, &skipped))
    return {};
  if (!read_count(buffer, plain, sequential ? &counts.triangles : &counts.points)) return {};
  if (!read_count(buffer, plain, sequential ? &counts.points : &counts.triangles)) return {};
  return counts;
}

Result<DracoMethod> draco_method(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes || !bytes.starts_with("DRACO")) {
    return Error{Cause::MalformedMesh, "the Draco header is missing or cut short"};
  }
  if (bytes[7] == draco::POINT_CLOUD) {
    return Error{Cause::NotATriangleMesh, "the Draco file holds a point cloud, not a triangle mesh"};
  }
  if (bytes[7] != draco::TRIANGULAR_MESH)
    return Error{Cause::MalformedMesh, "the Draco file holds no known geometry"};
  if (bytes[8] == draco::MESH_SEQUENTIAL_ENCODING) return DracoMethod::Sequential;
  if (bytes[8] == draco::MESH_EDGEBREAKER_ENCODING) return DracoMethod::Edgebreaker;
  return Error{Cause::MalformedMesh, "the Draco file uses an unknown encoding method"};
}

std::optional<DracoCounts> peek_counts(std::string_view bytes) {
  const auto method = draco_method(bytes);
  if (!method) return {};
  const std::string_view head = bytes.substr(0, kPeekBytes);
  try {
    return *method == DracoMethod::Sequential
               ? CountsDecoder<draco::MeshSequentialDecoder>(*method).peek(head)
               : CountsDecoder<draco::MeshEdgebreakerDecoder>(*method).peek(head);
  } catch (const std::exception&) {  // metadata that claims more than there is
    return {};
  }
}

}  // namespace burnish
