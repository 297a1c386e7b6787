// The methods that filter face normals again, slow and plain: double precision, sets, dense matrices.
#pragma once

#include "core/smooth/bilateral_normals.h"
#include "core/smooth/fast_effective.h"
#include "core/smooth/joint_bilateral.h"
#include "core/smooth/mean_normals.h"
#include "core/smooth/median_normals.h"
#include "core/smooth/ohtake.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

/// Smooths a shape without coinciding vertices, without non-manifold edges, all wound alike; boundary
/// vertices stay.
Shape oracle_mean_normals(const Shape& shape, const MeanNormalsParams& params, int iterations);
Shape oracle_median_normals(const Shape& shape, const MedianNormalsParams& params, int iterations);
Shape oracle_fast_effective(const Shape& shape, const FastEffectiveParams& params, int iterations);
Shape oracle_ohtake(const Shape& shape, const OhtakeParams& params, int iterations);
Shape oracle_joint_bilateral(const Shape& shape, const JointBilateralParams& params, int iterations);
/// The global scheme solves its system by elimination: for a hundred triangles or so.
Shape oracle_bilateral_normals(const Shape& shape, const BilateralNormalsParams& params, int iterations);

}  // namespace burnish::testing
