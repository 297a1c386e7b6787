#include "core/io/glb_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <absl/strings/escaping.h>

#include "core/io/pins.h"

namespace burnish {
namespace {

using Kind = JsonValue::Kind;

constexpr std::uint64_t kMostBytes = 0xFFFFFFFF;  // of a GLB; a product of two fits, with a few more

Error malformed(const std::string& what) { return {Cause::MalformedMesh, what}; }

std::string named(std::string_view list, std::uint64_t number) {
  return std::string(list) + '[' + std::to_string(number) + ']';
}

Result<GlbComponent> component_of(const JsonValue& accessor, const std::string& place) {
  const auto type = whole_member(accessor, "componentType", place);
  if (!type) return type.error();
  for (const auto known : {GlbComponent::Int8, GlbComponent::UInt8, GlbComponent::Int16, GlbComponent::UInt16,
                           GlbComponent::UInt32, GlbComponent::Float}) {
    if (*type == static_cast<std::uint64_t>(known)) return known;
  }
  return malformed(place + ".componentType is " + std::to_string(*type) + ", which glTF does not know");
}

Result<std::size_t> components_of(const JsonValue& accessor, const std::string& place) {
  constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  const JsonValue* const type = accessor.find("type");
  for (std::size_t i = 0; i < std::size(kTypes); ++i) {
    if (type != nullptr && type->text == kTypes[i]) return i + 1;
  }
  return malformed(place + ".type must be SCALAR, VEC2, VEC3 or VEC4");
}

bool names_meshopt(const JsonValue& view) {
  const JsonValue* const extensions = view.find("extensions");
  return extensions != nullptr && (extensions->find("EXT_meshopt_compression") != nullptr ||
                                   extensions->find("KHR_meshopt_compression") != nullptr);
}

/// Whether JSON writes it as it is.
bool is_plain(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c > ' ' && c < 127 && c != '"' && c != '\\'; });
}

template <class T>
double as_double(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

template <class T>
void put_rounded(char* at, double value) {
  constexpr double kLow = std::numeric_limits<T>::min(), kHigh = std::numeric_limits<T>::max();
  const T whole = static_cast<T>(std::clamp(std::round(value), kLow, kHigh));
  std::memcpy(at, &whole, sizeof whole);
}

}  // namespace

std::size_t component_bytes(GlbComponent component) {
  switch (component) {
    case GlbComponent::Int8:
    case GlbComponent::UInt8:
      return 1;
    case GlbComponent::Int16:
    case GlbComponent::UInt16:
      return 2;
    default:
      return 4;
  }
}

double full_scale(GlbComponent component) {
  switch (component) {
    case GlbComponent::Int8:
      return 127;
    case GlbComponent::UInt8:
      return 255;
    case GlbComponent::Int16:
      return 32767;
    case GlbComponent::UInt16:
      return 65535;
    case GlbComponent::UInt32:
      return 4294967295.0;
    default:
      return 1;
  }
}

double read_component(const char* at, GlbComponent component) {
  switch (component) {
    case GlbComponent::Int8:
      return as_double<std::int8_t>(at);
    case GlbComponent::UInt8:
      return as_double<std::uint8_t>(at);
    case GlbComponent::Int16:
      return as_double<std::int16_t>(at);
    case GlbComponent::UInt16:
      return as_double<std::uint16_t>(at);
    case GlbComponent::UInt32:
      return as_double<std::uint32_t>(at);
    default:
      return as_double<float>(at);
  }
}

void write_component(char* at, GlbComponent component, double value) {
  switch (component) {
    case GlbComponent::Int8:
      return put_rounded<std::int8_t>(at, value);
    case GlbComponent::UInt8:
      return put_rounded<std::uint8_t>(at, value);
    case GlbComponent::Int16:
      return put_rounded<std::int16_t>(at, value);
    case GlbComponent::UInt16:
      return put_rounded<std::uint16_t>(at, value);
    case GlbComponent::UInt32:
      return put_rounded<std::uint32_t>(at, value);
    default:
      const auto number = static_cast<float>(value);
      std::memcpy(at, &number, sizeof number);
  }
}

std::size_t GlbAccessor::row_bytes() const { return components * component_bytes(component); }

Result<std::uint64_t> whole_number(const JsonValue& value, const std::string& place) {
  const double number = value.is(Kind::Number) ? value.number : -1;
  if (number >= 0 && number <= static_cast<double>(kMostBytes) && std::floor(number) == number) {
    return static_cast<std::uint64_t>(number);
  }
  return malformed(place + " must be a whole number from 0 to 4294967295");
}

Result<std::uint64_t> whole_member(const JsonValue& object, std::string_view name, const std::string& place,
                                   std::optional<std::uint64_t> otherwise) {
  const JsonValue* const value = object.find(name);
  if (value == nullptr && otherwise) return *otherwise;
  if (value == nullptr) return malformed(place + " has no " + std::string(name));
  return whole_number(*value, place + '.' + std::string(name));
}

Result<std::pair<const JsonValue*, Index>> GlbFile::element(std::string_view list, const JsonValue& number,
                                                            const std::string& what) const {
  const auto index = whole_number(number, what);
  if (!index) return index.error();
  const JsonValue* const all = json_.find(list);
  const std::size_t count = all != nullptr && all->is(Kind::Array) ? all->items.size() : 0;
  if (*index >= count) {
    return malformed(what + " cites " + named(list, *index) + " of " + std::to_string(count));
  }
  return std::pair{&all->items[*index], static_cast<Index>(*index)};
}

Result<GlbFile> GlbFile::read(std::string_view bytes, const RunControl& run) {
  GlbFile file;
  const auto container = read_glb_container(bytes);
  if (!container) return container.error();
  file.container_ = *container;
  // Spaces fill the chunk up; some writers take zeros.
  const std::size_t last = container->json.find_last_not_of(std::string_view("\0 ", 2));
  file.json_text_ = container->json.substr(0, last == std::string_view::npos ? 0 : last + 1);
  auto json = parse_gltf_json(file.json_text_, run);
  if (!json) return json.error();
  file.json_ = std::move(*json);
  const JsonValue* const asset = file.json_.find("asset");
  const JsonValue* const version = asset == nullptr ? nullptr : asset->find("version");
  if (version == nullptr || !version->is(Kind::String)) return malformed("the glTF has no asset.version");
  if (!version->text.starts_with("2.")) {
    return Error{Cause::UnsupportedFormat, "asset.version is " + quote(version->text) + "; 2.x can be read"};
  }
  if (auto ok = file.read_buffers(run); !ok) return ok.error();
  return file;
}

Result<> GlbFile::read_buffers(const RunControl& run) {
  const JsonValue* const all = json_.find("buffers");
  if (all == nullptr) return {};
  for (const JsonValue& each : all->items) {
    if (auto ok = run.check(); !ok) return ok;
    auto buffer = read_buffer(each, static_cast<Index>(buffers_.size()));
    if (!buffer) return buffer.error();
    buffers_.push_back(std::move(*buffer));
  }
  return {};
}

Result<GlbFile::Buffer> GlbFile::read_buffer(const JsonValue& buffer, Index number) {
  const std::string place = named("buffers", number);
  const auto length = whole_member(buffer, "byteLength", place);
  if (!length) return length.error();
  const JsonValue* const uri = buffer.find("uri");
  if (uri != nullptr && !uri->is(Kind::String)) return malformed(place + ".uri must be a string");
  Buffer result;
  if (uri == nullptr) {
    if (number > 0 || !container_.bin) return malformed(place + " has neither a uri nor a BIN chunk");
    result.bytes = *container_.bin;
  } else if (!uri->text.starts_with("data:")) {
    return Buffer{{}, uri->text.substr(0, 64), true};
  } else {
    const std::size_t comma = uri->text.find(',');
    std::string decoded;
    if (comma == std::string::npos || !uri->text.substr(0, comma).ends_with(";base64") ||
        !is_plain(uri->text.substr(0, comma)) ||
        !absl::Base64Unescape(absl::string_view(uri->text).substr(comma + 1), &decoded)) {
      return malformed(place + ".uri holds no base64");
    }
    decoded_.push_back(std::make_unique<std::string>(std::move(decoded)));
    result = {*decoded_.back(), uri->text.substr(0, comma + 1)};
  }
  if (*length > result.bytes.size()) {
    return malformed(place + " declares " + std::to_string(*length) + " bytes and has " +
                     std::to_string(result.bytes.size()));
  }
  result.bytes = result.bytes.substr(0, *length);
  return result;
}

Result<GlbView> GlbFile::view(const JsonValue& number, const std::string& what) const {
  const auto found = element("bufferViews", number, what);
  if (!found) return found.error();
  const auto& [view, index] = *found;
  const std::string place = named("bufferViews", index);
  if (names_meshopt(*view)) {
    return Error{Cause::UnsupportedFormat, what + ": " + place +
                                               " is compressed by EXT_meshopt_compression, which cannot be "
                                               "read; write the file without it"};
  }
  const auto begin = whole_member(*view, "byteOffset", place, 0);
  if (!begin) return begin.error();
  const auto length = whole_member(*view, "byteLength", place);
  if (!length) return length.error();
  const auto stride = whole_member(*view, "byteStride", place, 0);
  if (!stride) return stride.error();
  const JsonValue* const of = view->find("buffer");
  if (of == nullptr) return malformed(place + " has no buffer");
  const auto buffer = element("buffers", *of, place + ".buffer");
  if (!buffer) return buffer.error();
  const Buffer& holder = buffers_[buffer->second];
  if (holder.elsewhere) {
    return Error{Cause::UnsupportedFormat, what + ": " + named("buffers", buffer->second) + " (" +
                                               quote(holder.uri) +
                                               ") is another file, which a service cannot follow; put it "
                                               "into the GLB"};
  }
  if (*begin + *length > holder.bytes.size()) {
    return malformed(place + " ends at byte " + std::to_string(*begin + *length) + " of the " +
                     std::to_string(holder.bytes.size()) + " of " + named("buffers", buffer->second));
  }
  return GlbView{buffer->second, *begin, *length, *stride};
}

Result<GlbAccessor> GlbFile::accessor(const JsonValue& number, const std::string& what) const {
  const auto found = element("accessors", number, what);
  if (!found) return found.error();
  const JsonValue& json = *found->first;
  const std::string place = named("accessors", found->second);
  GlbAccessor accessor{.number = found->second};
  const auto component = component_of(json, place);
  if (!component) return component.error();
  accessor.component = *component;
  const auto components = components_of(json, place);
  if (!components) return components.error();
  accessor.components = *components;
  const auto count = whole_member(json, "count", place);
  if (!count) return count.error();
  if (*count == 0) return malformed(place + ".count must be at least 1");
  accessor.count = *count;
  const JsonValue* const normalized = json.find("normalized");
  accessor.normalized = normalized != nullptr && normalized->number != 0;
  if (json.find("sparse") != nullptr) {
    return Error{Cause::UnsupportedFormat,
                 what + ": " + place + " is sparse, which cannot be written back; store it in full"};
  }
  const JsonValue* const view_number = json.find("bufferView");
  if (view_number == nullptr) {
    return Error{Cause::UnsupportedFormat, what + ": " + place + " has no bufferView, so no data"};
  }
  const auto offset = whole_member(json, "byteOffset", place, 0);
  if (!offset) return offset.error();
  const auto view = this->view(*view_number, what);
  if (!view) return view.error();
  accessor.buffer = view->buffer;
  accessor.begin = view->begin + *offset;
  accessor.stride = view->stride == 0 ? accessor.row_bytes() : view->stride;
  if (accessor.stride < accessor.row_bytes()) {
    return malformed(place + " has rows of " + std::to_string(accessor.row_bytes()) + " bytes in steps of " +
                     std::to_string(accessor.stride));
  }
  if (accessor.end() > view->begin + view->length) {
    return malformed(place + " has " + std::to_string(*count) + " rows, which end at byte " +
                     std::to_string(accessor.end() - view->begin) + " of the " +
                     std::to_string(view->length) + " of its bufferView");
  }
  return accessor;
}

}  // namespace burnish
