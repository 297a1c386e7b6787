#include "tests/train/network_trainer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "core/denoise/normal_network.h"

namespace burnish::train {
namespace {

using Eigen::Index, Eigen::MatrixXf, Eigen::Vector3f, Eigen::VectorXf;

constexpr Index kFields = NormalFields::kFields;
constexpr float kLeak = 0.1F;

/// A matrix or a bias, its gradient, and Adam's means of it and of its squares.
struct Parameter {
  MatrixXf value, gradient, mean, square;

  Parameter(Index rows, Index columns)
      : value(MatrixXf::Zero(rows, columns)), gradient(value), mean(value), square(value) {}

  void step(float rate, float unbiased_mean, float unbiased_square) {
    mean += 0.1F * (gradient - mean);
    square.array() += 0.001F * (gradient.array().square() - square.array());
    value.array() -=
        rate * (mean.array() / unbiased_mean) / ((square.array() / unbiased_square).sqrt() + 1e-8F);
  }
};

struct Layer {
  Parameter matrix, bias;
  bool rectified;
  MatrixXf in, out;

  Layer(Index inputs, Index outputs, bool rectify, float scale, std::mt19937& random)
      : matrix(outputs, inputs), bias(outputs, 1), rectified(rectify) {
    std::normal_distribution<float> normal(0, scale * std::sqrt(2 / static_cast<float>(inputs)));
    for (Index i = 0; i < matrix.value.size(); ++i) matrix.value.data()[i] = normal(random);
  }

  const MatrixXf& forward(const MatrixXf& input) {
    in = input;
    out = (matrix.value * in).colwise() + bias.value.col(0);
    if (rectified) out = out.cwiseMax(kLeak * out);
    return out;
  }

  /// From the gradient by `out` to that by `in`.
  MatrixXf backward(MatrixXf gradient) {
    if (rectified) gradient = (out.array() > 0).select(gradient, kLeak * gradient);
    matrix.gradient = gradient * in.transpose();
    bias.gradient = gradient.rowwise().sum();
    return matrix.value.transpose() * gradient;
  }
};

/// Per column the gradient of the loss by the weights of the fields. Adds up losses and angles.
struct Loss {
  double loss = 0, radians = 0;

  MatrixXf gradient(const MatrixXf& weights, const MatrixXf& fields, const MatrixXf& truth) {
    MatrixXf result(weights.rows(), weights.cols());
    for (Index i = 0; i < weights.cols(); ++i) {
      const Eigen::Map<const Eigen::Matrix<float, 3, kFields>> normals(fields.col(i).data());
      const Vector3f sum = normals * weights.col(i);
      const float size = std::max(sum.norm(), 1e-6F);
      const Vector3f unit = sum / size, off = unit - truth.col(i);
      const float distance = std::sqrt(off.squaredNorm() + 1e-4F);
      loss += static_cast<double>(distance);
      radians += 2 * std::asin(std::min(1.0, static_cast<double>(off.norm()) / 2));
      const Vector3f by_unit = off / distance;
      // The second part keeps the length of the sum near 1, where nothing else holds it.
      const Vector3f by_sum =
          (by_unit - unit * unit.dot(by_unit)) / size + sum * (0.004F * (size * size - 1));
      result.col(i) = normals.transpose() * by_sum / static_cast<float>(weights.cols());
    }
    return result;
  }
};

void append_by_rows(const MatrixXf& matrix, std::vector<float>& to) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index column = 0; column < matrix.cols(); ++column) to.push_back(matrix(row, column));
  }
}

}  // namespace

Samples::Samples(Index most)
    : inputs(static_cast<Index>(NormalFields::kInputs), most), fields(3 * kFields, most), truth(3, most) {}

void Samples::add(const NormalFields& fields_of, const NormalFields::Whole& whole, std::size_t face,
                  SimdVec3 normal) {
  NormalFields::Inputs described;
  fields_of.describe(face, 1, whole, described);
  for (Index i = 0; i < inputs.rows(); ++i) inputs(i, count) = described[static_cast<std::size_t>(i)][0];
  for (Index k = 0; k < kFields; ++k) {
    const SimdVec3 n = fields_of.field(static_cast<std::size_t>(k), face);
    fields.col(count).segment<3>(3 * k) << n.x(), n.y(), n.z();
  }
  truth.col(count++) << normal.x(), normal.y(), normal.z();
}

void Samples::finish() {
  inputs.conservativeResize(Eigen::NoChange, count);
  fields.conservativeResize(Eigen::NoChange, count);
  truth.conservativeResize(Eigen::NoChange, count);
}

std::vector<float> train_network(Samples& samples, const TrainOptions& options) {
  std::mt19937 random(options.seed);
  const VectorXf mean = samples.inputs.rowwise().mean();
  samples.inputs.colwise() -= mean;
  const VectorXf per_deviation = (samples.inputs.array().square().rowwise().mean() + 1e-6F).rsqrt().matrix();
  samples.inputs.array().colwise() *= per_deviation.array();

  constexpr Index kFirst = NormalNetwork::kFirst, kSecond = NormalNetwork::kSecond;
  Layer layers[] = {{samples.inputs.rows(), kFirst, true, 1, random},
                    {kFirst, kSecond, true, 1, random},
                    {kSecond, kFields, false, 0.1F, random}};
  layers[2].bias.value.setConstant(1.0F / kFields);

  std::vector<Index> order(static_cast<std::size_t>(samples.count));
  std::iota(order.begin(), order.end(), Index{0});
  const Index batches = samples.count / options.batch;
  const double steps = static_cast<double>(options.epochs) * static_cast<double>(batches);
  double step = 0;
  for (int epoch = 1; epoch <= options.epochs; ++epoch) {
    std::shuffle(order.begin(), order.end(), random);
    Loss loss;
    for (Index b = 0; b < batches; ++b) {
      const std::vector<Index> chosen(order.begin() + b * options.batch,
                                      order.begin() + (b + 1) * options.batch);
      const MatrixXf fields = samples.fields(Eigen::all, chosen), truth = samples.truth(Eigen::all, chosen);
      const MatrixXf weights =
          layers[2].forward(layers[1].forward(layers[0].forward(samples.inputs(Eigen::all, chosen))));
      layers[0].backward(layers[1].backward(layers[2].backward(loss.gradient(weights, fields, truth))));
      ++step;
      const auto rate = options.rate * static_cast<float>(0.5 * (1 + std::cos(M_PI * step / steps)) + 0.002);
      const auto unbiased = [&](double share) { return static_cast<float>(1 - std::pow(share, step)); };
      for (Layer& layer : layers) {
        layer.matrix.step(rate, unbiased(0.9), unbiased(0.999));
        layer.bias.step(rate, unbiased(0.9), unbiased(0.999));
      }
    }
    const double count = static_cast<double>(batches * options.batch);
    std::printf("  epoch %2d: loss %.4f, %.3f degrees\n", epoch, loss.loss / count,
                loss.radians / count * 180 / M_PI);
    std::fflush(stdout);
  }

  // The network takes the inputs as they are: their means and deviations go into the first layer.
  MatrixXf& first = layers[0].matrix.value;
  first = first * per_deviation.asDiagonal();
  layers[0].bias.value -= first * mean;
  std::vector<float> numbers;
  for (const Layer& layer : layers) {
    append_by_rows(layer.matrix.value, numbers);
    append_by_rows(layer.bias.value, numbers);
  }
  return numbers;
}

}  // namespace burnish::train
