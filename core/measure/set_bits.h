// Private to the nearest-triangle search: the bits that are set, as numbers.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace burnish::nearest_group {

inline constexpr std::size_t kBits = 8;

/// For each set of eight their numbers, side by side: 8 KiB that stay in the cache.
inline constexpr auto kNumbersOf = [] {
  std::array<std::array<std::uint32_t, kBits>, std::size_t{1} << kBits> numbers{};
  for (unsigned bits = 0; bits < numbers.size(); ++bits) {
    for (std::uint32_t k = 0, count = 0; k < kBits; ++k) {
      if ((bits >> k & 1) != 0) numbers[bits][count++] = k;
    }
  }
  return numbers;
}();

/// Writes `first` plus the number of each bit that is set, and says how many. Writes all eight places: no
/// branch to mispredict.
[[gnu::always_inline]] inline std::size_t keep(std::size_t first, unsigned bits, std::uint32_t* to) {
  using Eight = std::uint32_t __attribute__((vector_size(sizeof kNumbersOf[0])));
  Eight places;
  std::memcpy(&places, &kNumbersOf[bits], sizeof places);
  places += static_cast<std::uint32_t>(first);
  std::memcpy(to, &places, sizeof places);
  return static_cast<std::size_t>(std::popcount(bits));
}

}  // namespace burnish::nearest_group
