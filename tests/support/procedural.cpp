#include "tests/support/procedural.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tests/support/procedural_kinds.h"

namespace burnish::testing {
namespace {

struct Kind {
  const char* name;
  Family family;
  bool closed;
  Shape (*make)(double edge, Random& random);
};

constexpr Kind kKinds[] = {
    {"chamfered_box", Family::Machined, true, chamfered_box},
    {"stairs", Family::Machined, true, stairs},
    {"star_prism", Family::Machined, true, star_prism},
    {"bracket", Family::Machined, true, bracket},
    {"block", Family::Machined, true, block},
    {"cylinder", Family::Machined, true, cylinder},
    {"cone", Family::Machined, true, cone},
    {"shaft", Family::Machined, true, shaft},
    {"gear", Family::Machined, true, gear},
    {"gem", Family::Machined, true, gem},
    {"coarse_bumps", Family::FreeForm, true, coarse_bumps},
    {"fine_bumps", Family::FreeForm, true, fine_bumps},
    {"knot", Family::FreeForm, true, knot},
    {"blobs", Family::FreeForm, true, blobs},
    {"ridges", Family::FreeForm, false, ridges},
    {"cloth", Family::FreeForm, false, cloth},
    {"hair", Family::FreeForm, false, hair},
    {"relief", Family::Mixed, true, relief},
    {"vase", Family::Mixed, true, vase},
    {"twisted_star", Family::Mixed, true, twisted_star},
};

/// Makes it coarse, counts, and makes it again with edges that give the count asked for.
Shape of_size(const Kind& kind, std::uint64_t seed, std::size_t resolution) {
  double edge = 0.1;
  const auto make = [&] {
    Random random(seed);
    return kind.make(edge, random);
  };
  Shape shape = make();
  const auto wanted = static_cast<double>(resolution);
  for (int again = 0; again < 4; ++again) {
    const auto count = static_cast<double>(shape.triangles.size());
    if (std::abs(count - wanted) < 0.07 * wanted) break;
    edge *= std::sqrt(count / wanted);
    shape = make();
  }
  return shape;
}

}  // namespace

std::vector<std::string> procedural_names() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

NamedShape procedural_shape(std::string_view name, std::uint64_t seed, std::size_t resolution) {
  const auto kind = std::ranges::find_if(kKinds, [&](const Kind& k) { return name == k.name; });
  if (kind == std::end(kKinds)) std::abort();
  return {kind->name, kind->family, kind->closed, of_size(*kind, seed, resolution)};
}

std::vector<NamedShape> procedural_shapes(std::uint64_t seed, std::size_t resolution) {
  std::vector<NamedShape> shapes;
  for (const Kind& kind : kKinds) shapes.push_back(procedural_shape(kind.name, seed, resolution));
  return shapes;
}

}  // namespace burnish::testing
