#include "core/io/glb_container.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

namespace burnish {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF's byte order is the processor's");

constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJson = 0x4E4F534A, kBin = 0x004E4942;
constexpr std::size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

void append_word(std::string& out, std::size_t word) {
  const auto value = static_cast<std::uint32_t>(word);
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_chunk(std::string& out, std::uint32_t type, std::string_view bytes, char fill) {
  const std::size_t padding = (4 - bytes.size() % 4) % 4;
  append_word(out, bytes.size() + padding);
  append_word(out, type);
  out += bytes;
  out.append(padding, fill);
}

Error cut(const std::string& what) { return {Cause::MalformedMesh, "the GLB is cut short: " + what}; }

/// The chunk of this type ahead of `rest`, which then begins behind it.
Result<std::string_view> take_chunk(std::string_view& rest, const char* name) {
  const std::size_t length = word_at(rest, 0), there = rest.size() - kChunkHeaderBytes;
  if (length > there) {
    return cut("its " + std::string(name) + " chunk declares " + std::to_string(length) + " bytes, " +
               std::to_string(there) + " are left");
  }
  const std::string_view chunk = rest.substr(kChunkHeaderBytes, length);
  rest.remove_prefix(kChunkHeaderBytes + length);
  return chunk;
}

}  // namespace

Result<GlbContainer> read_glb_container(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes) return cut("its header takes 12 bytes");
  if (word_at(bytes, 0) != kMagic) return Error{Cause::MalformedMesh, "a GLB begins with \"glTF\""};
  if (const std::uint32_t version = word_at(bytes, 4); version != kVersion) {
    return Error{Cause::UnsupportedFormat,
                 "the GLB has version " + std::to_string(version) + "; version 2 can be read"};
  }
  const std::size_t length = word_at(bytes, 8);
  if (length > bytes.size()) {
    return cut("its header declares " + std::to_string(length) + " bytes, there are " +
               std::to_string(bytes.size()));
  }
  if (length < bytes.size()) {
    return Error{Cause::MalformedMesh, "the GLB declares " + std::to_string(length) +
                                           " bytes in its header and has " + std::to_string(bytes.size())};
  }
  std::string_view rest = bytes.substr(kHeaderBytes);
  if (rest.size() < kChunkHeaderBytes) return cut("it has no chunk");
  if (word_at(rest, 4) != kJson) return Error{Cause::MalformedMesh, "the first chunk of the GLB is not JSON"};
  const auto json = take_chunk(rest, "JSON");
  if (!json) return json.error();
  GlbContainer parts{*json, std::nullopt, {}};
  if (!rest.empty() && rest.size() < kChunkHeaderBytes) return cut("a chunk ends in its header");
  if (!rest.empty() && word_at(rest, 4) == kBin) {
    const auto bin = take_chunk(rest, "BIN");
    if (!bin) return bin.error();
    parts.bin = *bin;
  }
  parts.rest = rest;
  return parts;
}

Result<std::string> write_glb_container(const GlbContainer& parts) {
  std::string out;
  const std::size_t bin = parts.bin ? parts.bin->size() + kChunkHeaderBytes + 4 : 0;
  const std::size_t most = kHeaderBytes + kChunkHeaderBytes + parts.json.size() + 4 + bin + parts.rest.size();
  if (most > std::numeric_limits<std::uint32_t>::max()) {
    return Error{Cause::CannotEncode, "a GLB holds less than 4 GiB; this one would take more"};
  }
  out.reserve(most);
  append_word(out, kMagic);
  append_word(out, kVersion);
  append_word(out, 0);
  append_chunk(out, kJson, parts.json, ' ');
  if (parts.bin) append_chunk(out, kBin, *parts.bin, '\0');
  out += parts.rest;
  const auto length = static_cast<std::uint32_t>(out.size());
  std::memcpy(out.data() + 8, &length, sizeof length);
  return out;
}

}  // namespace burnish
