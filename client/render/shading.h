// What light a point of a surface sends to the eye: three lamps that turn with the camera, and a bright sky
// of which the surface itself hides a part.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/render/picture.h"
#include "client/render/ray_scene.h"

namespace burnish::render {

enum class Shading : std::uint8_t { Smooth, Flat };

/// One mesh and how it looks. Spans must outlive it.
struct Model {
  std::span<const Vec3d> positions;     ///< file unit
  std::span<const Triangle> triangles;  ///< in range
  std::span<const Light> lights = {};   ///< colour of each vertex; empty: `paint` is that of all
  std::span<const float> heat = {};     ///< share of the legend's range, per vertex; goes before `lights`
};

struct Look {
  Shading shading = Shading::Smooth;
  Color paint = {214, 207, 194};
  Color background = {255, 255, 255};
  unsigned samples = 4;    ///< rays per pixel, along each side
  unsigned occlusion = 4;  ///< rays per sample that ask how much of the sky is hidden; 0: none is
};

/// Normals of the vertices, from the triangles around them, weighted by area; zero where there are none.
std::vector<Vec3f> vertex_normals(std::span<const Vec3d> positions, std::span<const Triangle> triangles);

/// Light from points of a model. Thread-safe.
class Shader {
 public:
  Shader(const Model& model, const Look& look, const Camera& camera, const RayScene& scene);

  /// `sample`: its number in the pixel, below samples^2; it chooses the part of the sky to ask for.
  Light at(const RayScene::Hit& hit, const Vec3f& point, unsigned sample) const;

 private:
  Light paint(const RayScene::Hit& hit) const;
  Vec3f normal(const RayScene::Hit& hit, const Vec3f& flat) const;
  float open_sky(const Vec3f& point, const Vec3f& flat, const Vec3f& normal, unsigned sample) const;

  const Model& model_;
  const Look& look_;
  const Camera& camera_;
  const RayScene& scene_;
  Light paint_;
  std::vector<Vec3f> normals_;     // of the vertices; empty when shading is flat
  std::vector<Vec3f> directions_;  // to the sky around +z, denser near it, as a surface sees it
};

}  // namespace burnish::render
