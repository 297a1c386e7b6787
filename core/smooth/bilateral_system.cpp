#include "core/smooth/bilateral_system.h"

namespace burnish {

BilateralSystem::BilateralSystem(const Faces& faces)
    : neighbours_(faces.surface().topology.face_neighbours),
      weights_(faces.size()),
      transposed_(faces.size()),
      areas_(faces.size()),
      per_sum_(faces.size()),
      inverse_diagonal_(faces.size()),
      inverse_mass_(faces.size()),
      residuals_(faces.size()),
      right_side_(faces.size()),
      correction_(faces.size()),
      gradients_(faces.size()) {}

bool BilateralSystem::weigh(const Faces& faces, const BilateralExponent& exponent, float lambda) {
  const auto rows = [&](std::size_t begin, std::size_t end) {
    constexpr float kNothing = 1e-12F;
    for (std::size_t i = begin; i < end; ++i) {
      FourFloats gaussians{}, areas{};
      for (std::size_t side = 0; side < 3; ++side) {
        const Index j = neighbours_[i][side];
        if (j == kNone) continue;
        gaussians[side] = exponent(j, i);
        areas[side] = faces.twice_area(j);
      }
      gaussians = portable_exp(gaussians);
      const FourFloats weights = gaussians * areas;
      const float sum = weights[0] + weights[1] + weights[2];
      areas_[i] = faces.twice_area(i);
      per_sum_[i] = sum > kNothing * (areas[0] + areas[1] + areas[2]) ? 1 / sum : 0;
      for (std::size_t side = 0; side < 3; ++side) {
        weights_[i][side] = weights[side] * per_sum_[i];
        transposed_[i][side] = weights[side];  // times 1 / sum of the neighbour, below
      }
    }
  };
  const auto columns = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      float smooth = per_sum_[i] > 0 ? 1.0F : 0.0F;  // diagonal of (I - W)^T A (I - W), over A(i)
      for (std::size_t side = 0; side < 3; ++side) {
        const Index j = neighbours_[i][side];
        float& weight = transposed_[i][side];
        weight = j != kNone && areas_[j] > 0 ? weight * per_sum_[j] : 0;
        if (weight > 0) smooth += weight * weight * areas_[i] / areas_[j];
      }
      const float area = areas_[i];
      inverse_mass_[i] = area > 0 ? 1 / (lambda * area) : 0;
      inverse_diagonal_[i] = area > 0 ? 1 / (((1 - lambda) * smooth + lambda) * area) : 0;
    }
  };
  return faces.for_each_block(rows) && faces.for_each_block(columns);
}

SimdVec3 BilateralSystem::weighted_sum(std::span<const SimdVec3> of, const std::array<float, 3>& weights,
                                       std::size_t i) const {
  SimdVec3 sum;
  for (std::size_t side = 0; side < 3; ++side) {
    const Index j = neighbours_[i][side];
    if (j != kNone) sum += of[j] * weights[side];
  }
  return sum;
}

bool BilateralSystem::gather_residuals(std::span<const SimdVec3> m, const Faces& faces) {
  return faces.for_each_block([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      residuals_[i] = per_sum_[i] > 0 ? m[i] - weighted_sum(m, weights_[i], i) : SimdVec3{};
    }
  });
}

/// Row i of (I - W)^T A (I - W) m, for the m whose residuals were gathered.
SimdVec3 BilateralSystem::smoothness_row(std::size_t i) const {
  return (residuals_[i] - weighted_sum(residuals_, transposed_[i], i)) * areas_[i];
}

bool BilateralSystem::solve(Faces& faces, const BilateralWidths& widths, double lambda) {
  const float keep = static_cast<float>(lambda), smooth = 1 - keep;
  if (!weigh(faces, BilateralExponent(widths, faces, faces.normals()), keep)) return false;

  // For the correction m - n the right side is what n leaves of the equations:
  // -(1 - lambda) (I - W)^T A (I - W) n.
  if (!gather_residuals(faces.normals(), faces)) return false;
  const bool ready = faces.for_each_block([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) right_side_[i] = smoothness_row(i) * -smooth;
  });
  if (!ready) return false;

  struct Product {
    BilateralSystem& system;
    const Faces& faces;
    float keep, smooth;

    bool gather(std::span<const SimdVec3> p) const { return system.gather_residuals(p, faces); }
    void operator()(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin,
                    std::size_t end) const {
      for (std::size_t i = begin; i < end; ++i) {
        q[i] = system.smoothness_row(i) * smooth + p[i] * (keep * system.areas_[i]);
      }
    }
  };
  constexpr double kTolerance = 1e-5;
  constexpr std::uint32_t kMostSteps = 1000;
  const double area = parallel_sum(areas_.size(), faces.run(), [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += static_cast<double>(areas_[i]);
    return sum;
  });
  const auto report = gradients_.solve(
      Product{*this, faces, keep, smooth}, {.inverse = inverse_diagonal_, .inverse_mass = inverse_mass_},
      right_side_, correction_, kTolerance * kTolerance * lambda * area, kMostSteps, faces.run());
  return report && faces.filter([&](std::size_t i) {
    return unit_or(faces.normal(i) + correction_[i], 1, faces.normal(i));
  });
}

}  // namespace burnish
