#include "core/io/glb_counts.h"

#include <algorithm>
#include <cstring>
#include <set>

#include "core/io/glb_json.h"

namespace burnish {
namespace {

constexpr std::size_t kJsonBegin = 20;

/// The JSON chunk, whatever the rest of the file is like.
std::string_view json_of(std::string_view bytes, std::size_t most_bytes) {
  std::uint32_t length = 0;
  if (bytes.size() < kJsonBegin) return {};
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  if (length > most_bytes || length > bytes.size() - kJsonBegin) return {};
  const std::string_view json = bytes.substr(kJsonBegin, length);
  return json.substr(0, json.find_last_not_of(std::string_view("\0 ", 2)) + 1);
}

class Counter {
 public:
  explicit Counter(const JsonValue& json) : accessors_(json.find("accessors")) {}

  void add(const JsonValue& primitive) {
    const JsonValue* const attributes = primitive.find("attributes");
    const JsonValue* const positions = attributes == nullptr ? nullptr : attributes->find("POSITION");
    const JsonValue* const mode = primitive.find("mode");
    if (positions == nullptr || (mode != nullptr && mode->number < 4)) return;
    const double points = count_of(positions);
    if (seen_.insert(positions->number).second) counts_.vertices += points;
    const JsonValue* const indices = primitive.find("indices");
    const double corners = indices == nullptr ? points : count_of(indices);
    counts_.triangles += mode != nullptr && mode->number > 4 ? corners : corners / 3;
  }

  const GlbCounts& counts() const { return counts_; }

 private:
  double count_of(const JsonValue* number) const {
    if (accessors_ == nullptr || !number->is(JsonValue::Kind::Number)) return 0;
    if (!(number->number >= 0 && number->number < static_cast<double>(accessors_->items.size()))) return 0;
    const JsonValue* const count = accessors_->items[static_cast<std::size_t>(number->number)].find("count");
    return count == nullptr ? 0 : std::clamp(count->number, 0.0, 0x1p32);
  }

  const JsonValue* accessors_;
  GlbCounts counts_;
  std::set<double> seen_;
};

}  // namespace

std::optional<GlbCounts> declared_glb_counts(std::string_view bytes, std::size_t most_bytes) {
  const std::string_view text = json_of(bytes, most_bytes);
  const auto json = parse_gltf_json(text, {});
  if (!json) return {};
  Counter counter(*json);
  const JsonValue* const meshes = json->find("meshes");
  for (std::size_t m = 0; meshes != nullptr && m < meshes->items.size(); ++m) {
    const JsonValue* const primitives = meshes->items[m].find("primitives");
    if (primitives == nullptr) continue;
    for (const JsonValue& primitive : primitives->items) counter.add(primitive);
  }
  return counter.counts();
}

}  // namespace burnish
