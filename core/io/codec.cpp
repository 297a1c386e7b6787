#include "core/io/codec.h"

#include <map>

#include "core/io/draco.h"
#include "core/io/glb.h"
#include "core/io/obj.h"
#include "core/io/off.h"
#include "core/io/ply.h"
#include "core/io/stl.h"

namespace burnish {
namespace {

/// How one format is read and how a mesh of another becomes one.
struct Codec {
  Result<std::unique_ptr<Document>> (*decode)(std::string_view, const Limits&, const RunControl&) = nullptr;
  Result<Encoded> (*encode_as)(const MovedPositions&, std::span<const Triangle>, const SharedAttributes&,
                               const OutputOptions&, const RunControl&) = nullptr;
};

const Codec& codec_of(Format format) {
  static const std::map<Format, Codec> kCodecs = {
      {Format::Obj,
       {.decode = [](std::string_view bytes, const Limits& limits,
                     const RunControl& run) { return decode_obj(bytes, limits, run); },
        .encode_as = [](const MovedPositions& moved, std::span<const Triangle> triangles,
                        const SharedAttributes& attributes, const OutputOptions&,
                        const RunControl& run) { return encode_as_obj(moved, triangles, attributes, run); }}},
      {Format::Draco,
       {.decode = decode_draco,
        .encode_as =
            [](const MovedPositions& moved, std::span<const Triangle> triangles,
               const SharedAttributes& attributes, const OutputOptions& options, const RunControl& run) {
              return encode_as_draco(moved, triangles, attributes, options.draco, run);
            }}},
      {Format::Ply,
       {.decode = decode_ply,
        .encode_as = [](const MovedPositions& moved, std::span<const Triangle> triangles,
                        const SharedAttributes& attributes, const OutputOptions&,
                        const RunControl& run) { return encode_as_ply(moved, triangles, attributes, run); }}},
      {Format::Stl,
       {.decode = decode_stl,
        .encode_as = [](const MovedPositions& moved, std::span<const Triangle> triangles,
                        const SharedAttributes&, const OutputOptions&,
                        const RunControl& run) { return encode_as_stl(moved, triangles, run); }}},
      {Format::Off,
       {.decode = decode_off,
        .encode_as = [](const MovedPositions& moved, std::span<const Triangle> triangles,
                        const SharedAttributes& attributes, const OutputOptions&,
                        const RunControl& run) { return encode_as_off(moved, triangles, attributes, run); }}},
      {Format::Glb,
       {.decode = decode_glb,
        .encode_as = [](const MovedPositions& moved, std::span<const Triangle> triangles,
                        const SharedAttributes& attributes, const OutputOptions&,
                        const RunControl& run) { return encode_as_glb(moved, triangles, attributes, run); }}},
  };
  return kCodecs.at(format);
}

/// Takes out what the target has no place for, and remembers that.
void drop_what_cannot_be_held(SharedAttributes& attributes, const FormatTraits& target) {
  if (!target.carries_normals && attributes.normals) {
    attributes.normals.reset();
    attributes.dropped.emplace_back("normals");
  }
  if (!target.carries_texture_coordinates && attributes.texture_coordinates) {
    attributes.texture_coordinates.reset();
    attributes.dropped.emplace_back("texture coordinates");
  }
  if (!target.carries_colors && !attributes.colors.empty()) {
    attributes.colors.clear();
    attributes.dropped.emplace_back("colours");
  }
}

std::string joined(const std::vector<std::string>& items) {
  std::string list;
  for (const std::string& item : items) list += (list.empty() ? "" : "; ") + item;
  return list;
}

}  // namespace

Result<std::unique_ptr<Document>> decode(std::string_view bytes, std::optional<Format> format,
                                         const Limits& limits, const RunControl& run) {
  if (bytes.size() > limits.max_bytes) {
    return Error{Cause::TooLarge, "the mesh has " + std::to_string(bytes.size()) + " bytes; the limit is " +
                                      std::to_string(limits.max_bytes) + " (max-bytes)"};
  }
  if (!format) format = detect_format(bytes);
  if (!format) {
    return Error{
        Cause::UnsupportedFormat,
        "the mesh is in none of the formats that are known by their content: " + list_of_format_names()};
  }
  const std::string_view mesh = behind_byte_order_mark(bytes, *format);
  auto document = codec_of(*format).decode(mesh, limits, run);
  if (document) (*document)->has_byte_order_mark_ = mesh.size() < bytes.size();
  return document;
}

Result<Encoded> encode(const Document& document, const MovedPositions& moved, const OutputOptions& options,
                       const RunControl& run) {
  const Format target = options.format.value_or(document.format());
  if (target == document.format()) {
    auto encoded = document.encode_same(moved, options, run);
    if (encoded && document.has_byte_order_mark()) encoded->bytes.insert(0, kByteOrderMark);
    return encoded;
  }
  auto attributes = document.shared_attributes(moved, run);
  if (!attributes) return attributes.error();
  return encode_as(target, moved, document.triangles(), std::move(*attributes), options, run);
}

Result<Encoded> encode_as(Format format, const MovedPositions& moved, std::span<const Triangle> triangles,
                          SharedAttributes attributes, const OutputOptions& options, const RunControl& run) {
  drop_what_cannot_be_held(attributes, traits_of(format));
  auto encoded = codec_of(format).encode_as(moved, triangles, attributes, options, run);
  if (encoded && !attributes.dropped.empty()) {
    encoded->warnings.push_back({"attributes_dropped",
                                 "the other format cannot carry: " + joined(attributes.dropped),
                                 static_cast<std::uint32_t>(attributes.dropped.size())});
  }
  return encoded;
}

}  // namespace burnish
