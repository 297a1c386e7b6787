// Which kept job goes next: normal before low, and within a priority the owners in turn, each in the order of
// its own.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "burnish/v1/jobs.pb.h"

namespace burnish {

/// Not thread-safe.
class JobLine {
 public:
  void push_back(v1::JobPriority priority, const std::string& owner, const std::string& id) {
    lane(priority).owners[owner].push_back(id);
    ++size_;
  }
  /// A job that was next, again.
  void push_front(v1::JobPriority priority, const std::string& owner, const std::string& id) {
    lane(priority).owners[owner].push_front(id);
    ++size_;
  }

  std::optional<std::string> pop() {
    for (Lane& lane : lanes_) {
      if (lane.owners.empty()) continue;
      auto turn = lane.owners.upper_bound(lane.last);
      if (turn == lane.owners.end()) turn = lane.owners.begin();
      const std::string id = turn->second.front();
      turn->second.pop_front();
      lane.last = turn->first;
      if (turn->second.empty()) lane.owners.erase(turn);
      --size_;
      return id;
    }
    return {};
  }

  void remove(v1::JobPriority priority, const std::string& owner, const std::string& id) {
    Lane& of = lane(priority);
    const auto found = of.owners.find(owner);
    if (found == of.owners.end()) return;
    size_ -= std::erase(found->second, id);
    if (found->second.empty()) of.owners.erase(found);
  }

  std::size_t size() const { return size_; }

 private:
  struct Lane {
    std::map<std::string, std::deque<std::string>> owners;  ///< ids; never an empty one
    std::string last;                                       ///< the owner whose turn it was
  };
  Lane& lane(v1::JobPriority priority) { return lanes_[priority == v1::JOB_PRIORITY_LOW ? 1 : 0]; }

  std::array<Lane, 2> lanes_;
  std::size_t size_ = 0;
};

}  // namespace burnish
