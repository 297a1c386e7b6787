#include "tests/support/glb.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace burnish::testing {
namespace {

void append_word(std::string& out, std::size_t word) {
  const auto value = static_cast<std::uint32_t>(word);
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_chunk(std::string& out, const char* type, std::string_view bytes, char fill) {
  const std::size_t padding = (4 - bytes.size() % 4) % 4;
  append_word(out, bytes.size() + padding);
  out.append(type, 4).append(bytes).append(padding, fill);
}

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.substr(at, 4).data(), sizeof word);
  return word;
}

}  // namespace

std::string to_glb(std::string_view json, std::optional<std::string_view> bin, std::string_view rest) {
  std::string out = "glTF";
  append_word(out, 2);
  append_word(out, 0);
  append_chunk(out, "JSON", json, ' ');
  if (bin) append_chunk(out, "BIN\0", *bin, '\0');
  out += rest;
  const auto length = static_cast<std::uint32_t>(out.size());
  std::memcpy(out.data() + 8, &length, sizeof length);
  return out;
}

GlbChunks split_glb(std::string_view bytes) {
  if (bytes.size() < 20 || word_at(bytes, 8) != bytes.size()) throw std::runtime_error("no GLB");
  GlbChunks chunks;
  std::size_t at = 12;
  chunks.json = bytes.substr(at + 8, word_at(bytes, at));
  at += 8 + chunks.json.size();
  if (at + 8 <= bytes.size() && bytes.substr(at + 4, 3) == "BIN") {
    chunks.bin = bytes.substr(at + 8, word_at(bytes, at));
    at += 8 + chunks.bin.size();
  }
  chunks.rest = bytes.substr(at);
  return chunks;
}

std::vector<Vec3f> float_positions(const Shape& shape) {
  std::vector<Vec3f> values;
  for (const Vec3d& p : shape.positions) values.push_back(to_float(p));
  return values;
}

std::vector<Vec3f> directions(const Shape& shape) {
  std::vector<Vec3f> values;
  for (const Vec3d& p : shape.positions) values.push_back(to_float(p * (1 / length(p))));
  return values;
}

int TestGlb::view(std::string_view bytes, int stride) {
  bin.append((4 - bin.size() % 4) % 4, '\0');
  nlohmann::ordered_json view = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}};
  if (stride > 0) view["byteStride"] = stride;
  bin += bytes;
  json["bufferViews"].push_back(view);
  return static_cast<int>(json["bufferViews"].size()) - 1;
}

int TestGlb::accessor(int view, std::size_t offset, std::size_t count, int component, const char* type) {
  json["accessors"].push_back({{"bufferView", view},
                               {"byteOffset", offset},
                               {"componentType", component},
                               {"count", count},
                               {"type", type}});
  return static_cast<int>(json["accessors"].size()) - 1;
}

int TestGlb::vectors(const std::vector<Vec3f>& values) {
  return accessor(view(bytes_of(values)), 0, values.size(), kGlbFloat, "VEC3");
}

int TestGlb::positions(const std::vector<Vec3f>& values) {
  const int number = vectors(values);
  Vec3f low = values.front(), high = low;
  for (const Vec3f& p : values) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  json["accessors"][static_cast<std::size_t>(number)]["min"] = {low.x, low.y, low.z};
  json["accessors"][static_cast<std::size_t>(number)]["max"] = {high.x, high.y, high.z};
  return number;
}

int TestGlb::mesh(const nlohmann::ordered_json& primitives, const char* name) {
  nlohmann::ordered_json mesh = {{"primitives", primitives}};
  if (name != nullptr) mesh["name"] = name;
  json["meshes"].push_back(mesh);
  return static_cast<int>(json["meshes"].size()) - 1;
}

int TestGlb::mesh(const Shape& shape, const char* name) {
  const int position = positions(float_positions(shape)), normal = vectors(directions(shape));
  const int index = indices(indices_of<std::uint32_t>(shape));
  return mesh({{{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}, {"indices", index}}}, name);
}

std::string TestGlb::bytes() const {
  nlohmann::ordered_json whole = json;
  if (!bin.empty()) whole["buffers"] = {{{"byteLength", bin.size()}}};
  return to_glb(whole.dump(), bin.empty() ? std::nullopt : std::optional<std::string_view>(bin));
}

}  // namespace burnish::testing
