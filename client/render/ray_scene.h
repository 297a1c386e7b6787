// The triangles of one mesh, and what a ray meets among them. Embree finds it.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "client/render/camera.h"
#include "core/run/error.h"

namespace burnish::render {

/// Immutable after build, so many threads may ask. Lengths are in radii of the camera, around its centre. The
/// same answers on every x86-64 processor.
class RayScene {
 public:
  /// `triangles` must be in range. Errors: OutOfMemory, Internal.
  static Result<RayScene> build(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                const Camera& camera);

  struct Hit {
    Index triangle;
    float u, v;  ///< shares of the triangle's second and third corner
    float distance;
    Vec3f normal;  ///< of the triangle, by its winding, not of unit length
  };
  std::optional<Hit> first(const Vec3f& from, const Vec3f& towards) const;
  /// Whether anything is within `reach`.
  bool blocked(const Vec3f& from, const Vec3f& towards, float reach) const;

 private:
  struct Library;
  std::shared_ptr<const Library> library_;
};

}  // namespace burnish::render
