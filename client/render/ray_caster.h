// One mesh into a part of a picture.
#pragma once

#include "client/render/shading.h"
#include "core/run/run_control.h"

namespace burnish::render {

/// Draws the model into the camera's cell, whose top left pixel is (left, top): every pixel is the mean of
/// its samples; those that meet nothing are the background. The same bytes for any number of threads. Errors:
/// OutOfMemory, Internal, Cancelled, DeadlineExceeded.
Result<> draw(Picture& picture, unsigned left, unsigned top, const Camera& camera, const Model& model,
              const Look& look, const RunControl& run);

}  // namespace burnish::render
