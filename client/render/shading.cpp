#include "client/render/shading.h"

#include <algorithm>
#include <cmath>

#include "client/render/color_map.h"
#include "core/run/math.h"

namespace burnish::render {
namespace {

constexpr float kReach = 0.35F;  ///< what hides the sky from a point is not farther, in radii
constexpr float kLift = 2e-4F;   ///< rays start so far above the surface, in radii
constexpr float kWrap = 0.15F;   ///< how far light reaches around, as from a wide lamp
constexpr float kGloss = 0.05F;

/// A lamp, in the picture's axes: right, up, towards the eye.
struct Lamp {
  Vec3f towards;
  Light light;
};
constexpr Lamp kKey = {{-0.53F, 0.60F, 0.60F}, {0.80F, 0.78F, 0.73F}};
constexpr Lamp kFill = {{0.85F, 0.05F, 0.52F}, {0.10F, 0.115F, 0.15F}};
constexpr Lamp kRim = {{0.30F, 0.45F, -0.84F}, {0.16F, 0.16F, 0.18F}};
constexpr Light kSky = {0.33F, 0.345F, 0.38F}, kGround = {0.17F, 0.16F, 0.15F};

Vec3f unit(const Vec3f& v) {
  const float size = length(v);
  return size > 0 ? v * (1 / size) : v;
}

Vec3f mix(const Vec3f& a, const Vec3f& b, const Vec3f& c, const RayScene::Hit& hit) {
  return a * (1 - hit.u - hit.v) + b * hit.u + c * hit.v;
}

float lit(const Vec3f& normal, const Vec3f& towards) {
  return std::max(0.0F, (dot(normal, towards) + kWrap) / (1 + kWrap));
}

/// Two unit vectors at right angles to a third.
struct Tangents {
  Vec3f a, b;
};
Tangents tangents(const Vec3f& normal) {
  const Vec3f away = std::abs(normal.x) < 0.6F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0};
  const Vec3f a = unit(cross(normal, away));
  return {a, cross(normal, a)};
}

/// Evenly spread by the golden angle, as many in each part of the sky as the cosine of its angle asks for.
/// Every pixel asks the same directions, so shades have no grain.
std::vector<Vec3f> sky_directions(std::size_t count) {
  std::vector<Vec3f> directions(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const double angle = 2.399963229728653 * static_cast<double>(i), out = std::sqrt(share);
    directions[i] =
        to_float({out * portable_cos(angle), out * portable_cos(angle - kPi / 2), std::sqrt(1 - share)});
  }
  return directions;
}

}  // namespace

std::vector<Vec3f> vertex_normals(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  std::vector<Vec3d> sums(positions.size());
  for (const Triangle& t : triangles) {
    const Vec3d area = cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
    for (const Index v : t) sums[v] += area;
  }
  std::vector<Vec3f> normals(sums.size());
  std::transform(sums.begin(), sums.end(), normals.begin(), [](const Vec3d& sum) {
    const double size = length(sum);
    return size > 0 ? to_float(sum * (1 / size)) : Vec3f{};
  });
  return normals;
}

Shader::Shader(const Model& model, const Look& look, const Camera& camera, const RayScene& scene)
    : model_(model), look_(look), camera_(camera), scene_(scene), paint_(to_light(look.paint)) {
  if (look.shading == Shading::Smooth) normals_ = vertex_normals(model.positions, model.triangles);
  directions_ = sky_directions(std::size_t{look.occlusion} * look.samples * look.samples);
}

Light Shader::paint(const RayScene::Hit& hit) const {
  const Triangle& t = model_.triangles[hit.triangle];
  const float first = 1 - hit.u - hit.v;
  if (!model_.heat.empty()) {
    const float share = model_.heat[t[0]] * first + model_.heat[t[1]] * hit.u + model_.heat[t[2]] * hit.v;
    return to_light(heat_color(share));
  }
  if (model_.lights.empty()) return paint_;
  return model_.lights[t[0]] * first + model_.lights[t[1]] * hit.u + model_.lights[t[2]] * hit.v;
}

/// Towards the eye's side of the triangle.
Vec3f Shader::normal(const RayScene::Hit& hit, const Vec3f& flat) const {
  if (normals_.empty()) return flat;
  const Triangle& t = model_.triangles[hit.triangle];
  const Vec3f mean = unit(mix(normals_[t[0]], normals_[t[1]], normals_[t[2]], hit));
  if (mean == Vec3f{}) return flat;
  return dot(mean, hit.normal) * dot(flat, hit.normal) < 0 ? mean * -1.0F : mean;
}

float Shader::open_sky(const Vec3f& point, const Vec3f& flat, const Vec3f& normal, unsigned sample) const {
  if (look_.occlusion == 0) return 1;
  const Tangents side = tangents(normal);
  const Vec3f from = point + flat * kLift;
  const unsigned samples = look_.samples * look_.samples;
  unsigned open = 0;
  for (unsigned i = 0; i < look_.occlusion; ++i) {
    const Vec3f& d = directions_[sample + i * samples];
    const Vec3f towards = side.a * d.x + side.b * d.y + normal * d.z;
    // Below its own triangle a ray meets the surface that the normal has smoothed away.
    if (dot(towards, flat) <= 0 || !scene_.blocked(from, towards, kReach)) ++open;
  }
  return static_cast<float>(open) / static_cast<float>(look_.occlusion);
}

Light Shader::at(const RayScene::Hit& hit, const Vec3f& point, unsigned sample) const {
  const Vec3f eye = to_float(camera_.axes.eye);
  Vec3f flat = unit(hit.normal);
  if (dot(flat, eye) < 0) flat = flat * -1.0F;
  const Vec3f n = normal(hit, flat);
  const float open = open_sky(point, flat, n, sample);
  const Vec3f turned = {dot(n, to_float(camera_.axes.right)), dot(n, to_float(camera_.axes.up)), dot(n, eye)};
  const float up = (turned.y + 1) / 2;
  const float dim = 0.45F + 0.55F * open;  // a lamp is wide as well, so a part of it is hidden with the sky
  Light light = (kSky * up + kGround * (1 - up)) * open;
  for (const Lamp& lamp : {kKey, kFill, kRim}) light += lamp.light * (lit(turned, lamp.towards) * dim);
  float gloss = std::max(0.0F, dot(turned, unit(kKey.towards + Vec3f{0, 0, 1})));
  for (int i = 0; i < 4; ++i) gloss *= gloss;
  return paint(hit) * light + Light{1, 1, 1} * (kGloss * gloss * dim);
}

}  // namespace burnish::render
