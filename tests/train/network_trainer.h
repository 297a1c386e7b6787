// Learns the numbers of a NormalNetwork from faces whose true normal is known.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/denoise/normal_fields.h"

namespace burnish::train {

/// One column per face.
struct Samples {
  Eigen::MatrixXf inputs;  ///< as NormalFields describes the face
  Eigen::MatrixXf fields;  ///< its normals, three rows each
  Eigen::MatrixXf truth;   ///< the normal that it should have, three rows

  explicit Samples(Eigen::Index most);
  void add(const NormalFields& fields_of, const NormalFields::Whole& whole, std::size_t face,
           SimdVec3 normal);
  void finish();  ///< drops the columns that were not filled
  Eigen::Index count = 0;
};

struct TrainOptions {
  int epochs = 14;
  int batch = 256;
  float rate = 3e-3F;  ///< of Adam at the start; falls along a cosine
  std::uint32_t seed = 1;
};

/// The numbers of the network that has the least mean of sqrt(|n - truth|^2 + 1e-4) over the samples, n its
/// blend of the fields, as far as Adam (Kingma, Ba 2015) finds it. Prints the mean angle as it goes.
std::vector<float> train_network(Samples& samples, const TrainOptions& options);

}  // namespace burnish::train
