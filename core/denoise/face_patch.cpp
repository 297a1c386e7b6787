#include "core/denoise/face_patch.h"

namespace burnish {

bool FacePatch::surround(std::span<const Index> own, std::uint32_t rings) {
  if (local_.empty()) local_.assign(mesh_.size(), kNone);
  for (const Index f : faces_) local_[f] = kNone;
  faces_.assign(own.begin(), own.end());
  for (std::size_t i = 0; i < faces_.size(); ++i) local_[faces_[i]] = static_cast<Index>(i);
  ends_.assign(1, static_cast<Index>(faces_.size()));
  while (ends_.size() <= rings) {
    if (!grow()) return false;
  }
  return list_neighbours();
}

/// One ring more.
bool FacePatch::grow() {
  const RunControl& run = mesh_.run();
  const std::size_t last = ends_.size() > 1 ? ends_[ends_.size() - 2] : 0, end = faces_.size();
  for (std::size_t i = last; i < end && end < mesh_.size(); ++i) {
    if (i % kBlockSize == 0 && run.stopped()) return false;
    mesh_.for_each_neighbour(faces_[i], [&](Index n) {
      if (local_[n] != kNone) return;
      local_[n] = static_cast<Index>(faces_.size());
      faces_.push_back(n);
    });
  }
  ends_.push_back(static_cast<Index>(faces_.size()));
  return !run.stopped();
}

bool FacePatch::list_neighbours() {
  const RunControl& run = mesh_.run();
  const std::size_t listed = ends_.size() > 1 ? ends_[ends_.size() - 2] : faces_.size();
  offsets_.resize(listed + 1);
  offsets_[0] = 0;
  const bool counted = for_each(listed, run, [&](std::size_t i) {
    std::size_t count = 0;
    mesh_.for_each_neighbour(faces_[i], [&](Index) { ++count; });
    offsets_[i + 1] = count;
  });
  if (!counted) return false;
  for (std::size_t i = 0; i < listed; ++i) offsets_[i + 1] += offsets_[i];
  items_.resize(offsets_[listed]);
  return for_each(listed, run, [&](std::size_t i) {
    std::size_t at = offsets_[i];
    mesh_.for_each_neighbour(faces_[i], [&](Index n) { items_[at++] = local_[n]; });
  });
}

}  // namespace burnish
