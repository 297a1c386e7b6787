// Memory that its first user fills: a std::vector would be filled with zeros before, on one thread, which for
// two million triangles takes longer than an iteration and hears no stop.
#pragma once

#include <memory>
#include <type_traits>
#include <vector>

namespace burnish {

template <class Item>
struct Unfilled : std::allocator<Item> {
  static_assert(std::is_trivially_copyable_v<Item> && std::is_trivially_destructible_v<Item>);
  template <class Other>
  struct rebind {
    using other = Unfilled<Other>;
  };
  template <class Other>
  void construct(Other*) const noexcept {}
  template <class Other, class... Arguments>
  void construct(Other* at, Arguments&&... arguments) const {
    std::construct_at(at, static_cast<Arguments&&>(arguments)...);
  }
};

/// A vector whose resize() and Buffer(size) leave new items as they are in memory: write each before it is
/// read.
template <class Item>
using Buffer = std::vector<Item, Unfilled<Item>>;

}  // namespace burnish
