// What tests of methods ask of results: where vertices went, by how much two shapes differ, what became of
// volume and edges.
#pragma once

#include <functional>

#include "core/smooth/iteration.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

using Smooth = std::function<Result<SmoothOutcome>(Surface&, const IterationOptions&)>;

/// The shape smoothed, in its own unit and order; a failure of the test when the method fails.
Shape smoothed(const Shape& shape, const Smooth& smooth, const IterationOptions& options = {});
/// Where the vertices of `shape` are on a surface that was made of it.
Shape shape_on(const Surface& surface, Shape shape);

/// Largest distance between vertices of the same number.
double largest_distance(const Shape& a, const Shape& b);
/// The same in mean edge lengths of `shape`.
double deviation(const Shape& shape, const Shape& a, const Shape& b);
double mean_edge_of(const Shape& shape);
/// Signed; of a closed shape.
double volume(const Shape& shape);
/// Of the vertices that were on the edges of cube(n): root mean square of how far they are from both planes
/// there.
double edge_error(const Shape& cube, const Shape& result);

/// Closed, open and with sharp edges, all rough: none is symmetric.
const std::vector<Shape>& rough_shapes();
/// The same and a smooth one.
const std::vector<Shape>& various_shapes();

}  // namespace burnish::testing
