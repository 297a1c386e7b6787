// The learned part of method `auto`: from how the fields of a face differ, the weights with which to add them
// up. One small network per stage: two hidden layers of leaky rectified units,
//     w = C r(B r(A x + a) + b) + c,   r(x) = max(x, x / 10),
// x the inputs of NormalFields, w the weights of its fields. Trained by tests/train on made-up shapes and
// public meshes with artificial noise.
#pragma once

#include <span>
#include <vector>

#include "core/denoise/normal_fields.h"

namespace burnish {

class NormalNetwork {
 public:
  static constexpr std::size_t kFirst = 48, kSecond = 32;  ///< hidden units
  /// Numbers that make up a network: A, a, B, b, C, c, matrices by rows.
  static constexpr std::size_t kNumbers =
      kFirst * (NormalFields::kInputs + 1) + kSecond * (kFirst + 1) + NormalFields::kFields * (kSecond + 1);

  /// `numbers` must be kNumbers of them.
  explicit NormalNetwork(std::span<const float> numbers);

  /// normals[f] = the blend of the fields of each face f of the mesh that the fields are of. The same bits on
  /// every processor and for any number of threads. False when stopped.
  bool predict(const NormalFields& fields, const NormalFields::Whole& whole, const RunControl& run,
               std::span<SimdVec3> normals) const;

 private:
  std::vector<float> numbers_;  // regrouped: what is read together lies together
};

/// Those that come with the library, one per stage of the cascade.
std::span<const NormalNetwork> normal_networks();

}  // namespace burnish
