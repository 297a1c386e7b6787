#include "core/denoise/normal_network.h"

#include <algorithm>

#include "core/denoise/normal_weights.h"

namespace burnish {
namespace {

constexpr std::size_t kInputs = NormalFields::kInputs, kFields = NormalFields::kFields;
constexpr std::size_t kFirst = NormalNetwork::kFirst, kSecond = NormalNetwork::kSecond;
/// Units that are computed together, and faces: one per lane.
constexpr std::size_t kTogether = 4, kFaces = NormalFields::kTogether;
/// Rows of the last layer, filled up with zeros.
constexpr std::size_t kOutputs = (kFields + kTogether - 1) / kTogether * kTogether;

using Lanes = NormalFields::Lanes;

/// Rows by fours: the four biases, then for each input the four factors.
void regroup(std::span<const float> matrix, std::span<const float> bias, std::size_t outputs,
             std::vector<float>& to) {
  const std::size_t inputs = matrix.size() / bias.size();
  for (std::size_t row = 0; row < outputs; row += kTogether) {
    for (std::size_t k = row; k < row + kTogether; ++k) to.push_back(k < bias.size() ? bias[k] : 0);
    for (std::size_t i = 0; i < inputs; ++i) {
      for (std::size_t k = row; k < row + kTogether; ++k) {
        to.push_back(k < bias.size() ? matrix[k * inputs + i] : 0);
      }
    }
  }
}

template <std::size_t kIn, std::size_t kOut, bool kRectified>
[[gnu::always_inline]] inline const float* layer(const float* numbers, const Lanes* in, Lanes* out) {
  for (std::size_t row = 0; row < kOut; row += kTogether) {
    Lanes sums[kTogether];
    for (std::size_t k = 0; k < kTogether; ++k) sums[k] = Lanes{} + numbers[k];
    numbers += kTogether;
    for (std::size_t i = 0; i < kIn; ++i, numbers += kTogether) {
      for (std::size_t k = 0; k < kTogether; ++k) sums[k] += in[i] * numbers[k];
    }
    for (std::size_t k = 0; k < kTogether; ++k) {
      out[row + k] = kRectified ? (sums[k] > 0 ? sums[k] : sums[k] * 0.1F) : sums[k];
    }
  }
  return numbers;
}

/// in[kInputs], out[kOutputs]: a lane per face.
[[gnu::always_inline]] inline void network(const float* numbers, const Lanes* in, Lanes* out) {
  Lanes first[kFirst], second[kSecond];
  numbers = layer<kInputs, kFirst, true>(numbers, in, first);
  numbers = layer<kFirst, kSecond, true>(numbers, first, second);
  layer<kSecond, kOutputs, false>(numbers, second, out);
}

void network_128(const float* numbers, const Lanes* in, Lanes* out) { network(numbers, in, out); }
#if defined(__x86_64__)
[[gnu::target("avx2")]] void network_256(const float* numbers, const Lanes* in, Lanes* out) {
  network(numbers, in, out);
}
#endif

using Network = void (*)(const float* numbers, const Lanes* in, Lanes* out);
Network widest() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return network_256;
#endif
  return network_128;
}

}  // namespace

NormalNetwork::NormalNetwork(std::span<const float> numbers) {
  const auto take = [&](std::size_t count) {
    const auto taken = numbers.first(count);
    numbers = numbers.subspan(count);
    return taken;
  };
  const auto add = [&](std::size_t inputs, std::size_t outputs, std::size_t rows) {
    const auto matrix = take(inputs * outputs);
    regroup(matrix, take(outputs), rows, numbers_);
  };
  add(kInputs, kFirst, kFirst);
  add(kFirst, kSecond, kSecond);
  add(kSecond, kFields, kOutputs);
}

bool NormalNetwork::predict(const NormalFields& fields, const NormalFields::Whole& whole,
                            const RunControl& run, std::span<SimdVec3> normals) const {
  static const Network kNetwork = widest();
  return parallel_for(fields.size(), run, [&](std::size_t begin, std::size_t end) {
    NormalFields::Inputs inputs;
    Lanes out[kOutputs];
    for (std::size_t first = begin; first < end; first += kFaces) {
      const std::size_t faces = std::min(kFaces, end - first);
      fields.describe(first, faces, whole, inputs);
      kNetwork(numbers_.data(), inputs.data(), out);
      for (std::size_t lane = 0; lane < faces; ++lane) {
        NormalFields::Weights weights;
        for (std::size_t k = 0; k < kFields; ++k) weights[k] = out[k][lane];
        normals[fields.number(first + lane)] = fields.blend(first + lane, weights);
      }
    }
  });
}

std::span<const NormalNetwork> normal_networks() {
  static const std::vector<NormalNetwork> kNetworks = [] {
    std::vector<NormalNetwork> networks;
    for (std::span<const float> left = normal_weights(); left.size() >= NormalNetwork::kNumbers;
         left = left.subspan(NormalNetwork::kNumbers)) {
      networks.emplace_back(left.first(NormalNetwork::kNumbers));
    }
    return networks;
  }();
  return kNetworks;
}

}  // namespace burnish
