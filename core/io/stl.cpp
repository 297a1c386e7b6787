#include "core/io/stl.h"

namespace burnish {
namespace {

constexpr std::size_t kHeaderBytes = 80, kFirstFacet = 84, kFacetBytes = 50;

}  // namespace

bool has_binary_stl_size(std::string_view bytes) {
  if (bytes.size() < kFirstFacet) return false;
  std::uint64_t facets = 0;
  for (std::size_t i = 0; i < 4; ++i)
    facets |= std::uint64_t{static_cast<unsigned char>(bytes[kHeaderBytes + i])} << (8 * i);
  const std::uint64_t size = kFirstFacet + facets * kFacetBytes;
  return size == bytes.size() || (facets > 0 && size < bytes.size() && bytes.size() - size < kFacetBytes);
}

}  // namespace burnish
