#include "core/io/codec.h"

#include <algorithm>

#include "core/io/draco.h"
#include "core/io/obj.h"

namespace burnish {
namespace {

bool looks_like_text(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, 4096);
  return std::ranges::none_of(head, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 32 && c != '\t' && c != '\n' && c != '\r' && c != '\f' && c != '\v';
  });
}

std::string joined(const std::vector<std::string>& items) {
  std::string list;
  for (const std::string& item : items) list += (list.empty() ? "" : "; ") + item;
  return list;
}

}  // namespace

std::string_view format_name(Format format) { return format == Format::Obj ? "obj" : "drc"; }

std::optional<Format> detect_format(std::string_view bytes) {
  if (bytes.starts_with("DRACO")) return Format::Draco;
  if (looks_like_text(bytes)) return Format::Obj;
  return std::nullopt;
}

Result<std::unique_ptr<Document>> decode(std::string_view bytes, std::optional<Format> format,
                                         const Limits& limits, const RunControl& run) {
  if (bytes.size() > limits.max_bytes) {
    return Error{Cause::TooLarge, "the mesh has " + std::to_string(bytes.size()) + " bytes; the limit is " +
                                      std::to_string(limits.max_bytes) + " (max-bytes)"};
  }
  if (!format) format = detect_format(bytes);
  if (!format) return Error{Cause::UnsupportedFormat, "the mesh is neither OBJ text nor Draco"};
  return *format == Format::Obj ? decode_obj(bytes, limits, run) : decode_draco(bytes, limits, run);
}

Result<Encoded> encode(const Document& document, const MovedPositions& moved, const OutputOptions& options,
                       const RunControl& run) {
  const Format target = options.format.value_or(document.format());
  if (target == document.format()) return document.encode_same(moved, options, run);
  auto attributes = document.shared_attributes(moved, run);
  if (!attributes) return attributes.error();
  auto encoded = target == Format::Obj
                     ? encode_as_obj(moved, document.triangles(), *attributes, run)
                     : encode_as_draco(moved, document.triangles(), *attributes, options.draco, run);
  if (encoded && !attributes->dropped.empty()) {
    encoded->warnings.push_back({"attributes_dropped",
                                 "the other format cannot carry: " + joined(attributes->dropped),
                                 static_cast<std::uint32_t>(attributes->dropped.size())});
  }
  return encoded;
}

}  // namespace burnish
