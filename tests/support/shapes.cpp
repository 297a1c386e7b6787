#include "tests/support/shapes.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>
#include <random>
#include <sstream>

namespace burnish::testing {
namespace {

constexpr double kPhi = 1.6180339887498949;

Vec3d normalised(const Vec3d& p) { return p * (1 / length(p)); }

double uniform(std::mt19937_64& random) {  // in [-1, 1), the same on every machine
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1;
}

}  // namespace

Shape sphere(int levels) {
  Shape shape;
  for (const Vec3d& p : {Vec3d{-1, kPhi, 0},
                         {1, kPhi, 0},
                         {-1, -kPhi, 0},
                         {1, -kPhi, 0},
                         {0, -1, kPhi},
                         {0, 1, kPhi},
                         {0, -1, -kPhi},
                         {0, 1, -kPhi},
                         {kPhi, 0, -1},
                         {kPhi, 0, 1},
                         {-kPhi, 0, -1},
                         {-kPhi, 0, 1}}) {
    shape.positions.push_back(normalised(p));
  }
  shape.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [at, added] =
          middles.try_emplace(std::minmax(a, b), static_cast<Index>(shape.positions.size()));
      if (added) shape.positions.push_back(normalised(shape.positions[a] + shape.positions[b]));
      return at->second;
    };
    std::vector<Triangle> split;
    for (const auto& [a, b, c] : shape.triangles) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const Triangle& t : {Triangle{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
        split.push_back(t);
    }
    shape.triangles = std::move(split);
  }
  return shape;
}

Shape grid(int n) {
  Shape shape;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) shape.positions.push_back({double(x), double(y), 0});
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const Index a = static_cast<Index>(y * (n + 1) + x), b = a + 1, c = a + static_cast<Index>(n) + 1,
                  d = c + 1;
      shape.triangles.push_back({a, b, d});
      shape.triangles.push_back({a, d, c});
    }
  }
  return shape;
}

Shape cube(int n) {
  Shape shape;
  std::map<std::array<int, 3>, Index> known;
  const auto corner = [&](std::array<int, 3> at) {
    const auto [entry, added] = known.try_emplace(at, static_cast<Index>(shape.positions.size()));
    const auto place = [&](int i) { return 2.0 * i / n - 1; };
    if (added) shape.positions.push_back({place(at[0]), place(at[1]), place(at[2])});
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, n}) {
      for (int u = 0; u < n; ++u) {
        for (int v = 0; v < n; ++v) {
          const auto at = [&](int du, int dv) {
            std::array<int, 3> p{};
            p[axis] = side;
            p[(axis + 1) % 3] = u + du;
            p[(axis + 2) % 3] = v + dv;
            return corner(p);
          };
          Triangle one{at(0, 0), at(1, 0), at(1, 1)}, two{at(0, 0), at(1, 1), at(0, 1)};
          if (side == 0) std::swap(one[1], one[2]), std::swap(two[1], two[2]);
          shape.triangles.push_back(one);
          shape.triangles.push_back(two);
        }
      }
    }
  }
  return shape;
}

Shape with_noise(Shape shape, double amplitude, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (Vec3d& p : shape.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += amplitude * uniform(random);
  }
  return shape;
}

Shape scaled(Shape shape, double factor) {
  for (Vec3d& p : shape.positions) p *= factor;
  return shape;
}

Shape moved(Shape shape, const Vec3d& by) {
  for (Vec3d& p : shape.positions) p += by;
  return shape;
}

Vec3d rotated(const Vec3d& p) {  // Rodrigues' formula
  const Vec3d axis = normalised({1, 2, 3});
  const double c = std::cos(1.0), s = std::sin(1.0);
  return p * c + cross(axis, p) * s + axis * (dot(axis, p) * (1 - c));
}

Shape rotated(Shape shape) {
  for (Vec3d& p : shape.positions) p = rotated(p);
  return shape;
}

Shape with_vertex_order(const Shape& shape, const std::vector<Index>& order) {
  Shape result = shape;
  for (std::size_t v = 0; v < order.size(); ++v) result.positions[order[v]] = shape.positions[v];
  for (Triangle& t : result.triangles) t = {order[t[0]], order[t[1]], order[t[2]]};
  return result;
}

std::vector<Index> shuffled(std::size_t n) {
  std::vector<Index> order(n);
  std::iota(order.begin(), order.end(), Index{0});
  std::mt19937_64 random(7);
  for (std::size_t i = n; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return order;
}

Surface surface_of(const Shape& shape) {
  auto surface = prepare_surface(shape.positions, shape.triangles, {});
  if (!surface) std::abort();
  return std::move(*surface);
}

std::string to_obj(const Shape& shape) {
  std::ostringstream text;
  text.precision(17);
  for (const Vec3d& p : shape.positions) text << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const Triangle& t : shape.triangles)
    text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return text.str();
}

std::filesystem::path real_mesh(const std::string& name) {
  return std::filesystem::path(BURNISH_MESHES) / name;
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  return text.str();
}

}  // namespace burnish::testing
