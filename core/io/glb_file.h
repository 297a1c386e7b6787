// Private to the GLB codec: a file's JSON and buffers, and the accessors that lead from one into the other.
#pragma once

#include <cstring>
#include <span>
#include <unordered_map>

#include "core/io/codec.h"
#include "core/io/glb_container.h"
#include "core/io/glb_json.h"

namespace burnish {

enum class GlbComponent : std::uint16_t {
  Int8 = 5120,
  UInt8 = 5121,
  Int16 = 5122,
  UInt16 = 5123,
  UInt32 = 5125,
  Float = 5126
};

/// Rows of numbers in a buffer, checked against what the buffer holds.
struct GlbAccessor {
  Index number = 0;  ///< in "accessors"
  Index buffer = 0;
  std::uint64_t begin = 0, count = 0, stride = 0;  ///< row i stands at begin + i * stride
  GlbComponent component = GlbComponent::Float;
  std::size_t components = 1;
  bool normalized = false;

  std::size_t row_bytes() const;
  std::uint64_t end() const { return begin + (count - 1) * stride + row_bytes(); }
};

/// Bytes of the size of one component.
std::size_t component_bytes(GlbComponent component);
/// The integer that stands for 1 in a normalised accessor; 1 for floats.
double full_scale(GlbComponent component);
/// A component as it stands in the buffer.
double read_component(const char* at, GlbComponent component);
/// Rounds and clamps to what the component can hold.
void write_component(char* at, GlbComponent component, double value);

/// A stretch of a buffer that a buffer view names.
struct GlbView {
  Index buffer = 0;
  std::uint64_t begin = 0, length = 0, stride = 0;  ///< stride 0: rows stand close together
};

/// Views into `bytes`, which must outlive it. Immutable.
class GlbFile {
 public:
  static Result<GlbFile> read(std::string_view bytes, const RunControl& run);

  const GlbContainer& container() const { return container_; }
  std::string_view json_text() const { return json_text_; }  ///< without what fills the chunk up
  const JsonValue& json() const { return json_; }

  /// The element of one of the root's lists that `number` means. Errors: MalformedMesh.
  Result<std::pair<const JsonValue*, Index>> element(std::string_view list, const JsonValue& number,
                                                     const std::string& what) const;
  /// `what` names the user of the accessor or view in errors: "the positions of mesh 0, primitive 1".
  /// Errors: MalformedMesh, UnsupportedFormat (sparse, without data, compressed, or in another file).
  Result<GlbAccessor> accessor(const JsonValue& number, const std::string& what) const;
  Result<GlbView> view(const JsonValue& number, const std::string& what) const;

  std::string_view buffer(Index buffer) const { return buffers_[buffer].bytes; }
  bool in_json(Index buffer) const { return !buffers_[buffer].uri.empty(); }  ///< as a data: URI
  /// Of a data: URI what stands before the base64; of another file the first of its name.
  const std::string& uri_head(Index buffer) const { return buffers_[buffer].uri; }

 private:
  struct Buffer {
    std::string_view bytes;
    std::string uri = {};
    bool elsewhere = false;
  };

  Result<> read_buffers(const RunControl& run);
  Result<Buffer> read_buffer(const JsonValue& buffer, Index number);

  GlbContainer container_;
  std::string_view json_text_;
  JsonValue json_;
  std::vector<Buffer> buffers_;
  std::vector<std::unique_ptr<std::string>> decoded_;  ///< what data: URIs held
};

/// The whole number that the member `name` is; `otherwise` where it is left out, an error when that is
/// unset. `place` names the object: "accessors[3]".
Result<std::uint64_t> whole_member(const JsonValue& object, std::string_view name, const std::string& place,
                                   std::optional<std::uint64_t> otherwise = {});
Result<std::uint64_t> whole_number(const JsonValue& value, const std::string& place);

}  // namespace burnish
