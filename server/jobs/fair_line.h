// Who goes next: normal before low, and within a priority the owners in turn, each in the order of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>

namespace burnish {

/// Whose turn something waits for.
struct Turn {
  std::string owner = {};  ///< empty: nobody's in particular
  bool low = false;        ///< after everything that is not
};

/// Not thread-safe.
template <class Item>
class FairLine {
 public:
  void push_back(const Turn& turn, Item item) {
    lane(turn).owners[turn.owner].push_back(std::move(item));
    ++size_;
  }
  /// What was next, again.
  void push_front(const Turn& turn, Item item) {
    lane(turn).owners[turn.owner].push_front(std::move(item));
    ++size_;
  }

  std::optional<Item> pop() {
    for (Lane& lane : lanes_) {
      if (lane.owners.empty()) continue;
      auto next = lane.owners.upper_bound(lane.last);
      if (next == lane.owners.end()) next = lane.owners.begin();
      Item item = std::move(next->second.front());
      next->second.pop_front();
      lane.last = next->first;
      if (next->second.empty()) lane.owners.erase(next);
      --size_;
      return item;
    }
    return {};
  }

  /// Whether it was there.
  bool remove(const Turn& turn, const Item& item) {
    Lane& of = lane(turn);
    const auto found = of.owners.find(turn.owner);
    if (found == of.owners.end()) return false;
    const std::size_t removed = std::erase(found->second, item);
    size_ -= removed;
    if (found->second.empty()) of.owners.erase(found);
    return removed > 0;
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  std::size_t size_of(const std::string& owner) const {
    std::size_t size = 0;
    for (const Lane& lane : lanes_) {
      if (const auto found = lane.owners.find(owner); found != lane.owners.end())
        size += found->second.size();
    }
    return size;
  }

  template <class Function>
  void for_each(Function&& function) const {
    for (const Lane& lane : lanes_) {
      for (const auto& [owner, items] : lane.owners) std::ranges::for_each(items, function);
    }
  }

  /// Those that go before one that comes now: all of its owner, and of every other as many and one.
  template <class Function>
  void for_each_before(const Turn& turn, Function&& function) const {
    if (turn.low) visit(lanes_[0], lanes_[0].longest(), function);
    const Lane& own = lanes_[turn.low ? 1 : 0];
    const auto found = own.owners.find(turn.owner);
    visit(own, found == own.owners.end() ? 1 : found->second.size() + 1, function);
  }

 private:
  struct Lane {
    std::map<std::string, std::deque<Item>> owners;  ///< never an empty one
    std::string last;                                ///< the owner whose turn it was

    std::size_t longest() const {
      std::size_t most = 0;
      for (const auto& [owner, items] : owners) most = std::max(most, items.size());
      return most;
    }
  };
  Lane& lane(const Turn& turn) { return lanes_[turn.low ? 1 : 0]; }

  /// The first `rounds` of each owner.
  template <class Function>
  static void visit(const Lane& lane, std::size_t rounds, Function&& function) {
    for (const auto& [owner, items] : lane.owners) {
      const auto end = items.begin() + static_cast<std::ptrdiff_t>(std::min(rounds, items.size()));
      std::for_each(items.begin(), end, function);
    }
  }

  std::array<Lane, 2> lanes_;
  std::size_t size_ = 0;
};

}  // namespace burnish
