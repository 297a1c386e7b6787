// A new GLB from positions and corner attributes of another format.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/io/glb_edits.h"
#include "core/io/seams.h"

namespace burnish {
namespace {

constexpr std::size_t kMostShortIndices = 65535;  // the last index of a type is no vertex

/// Collects accessors and their data, each in a view of its own.
class GlbBuilder {
 public:
  /// `type` is "VEC3", `more` further members such as min and max. `target`: 34962 vertices, 34963 indices.
  template <class T>
  std::size_t add(std::span<const T> values, std::size_t components, GlbComponent component, int target,
                  const std::string& more = {}) {
    static constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    bin_.append((4 - bin_.size() % 4) % 4, '\0');
    list(views_) += R"({"buffer":0,"byteOffset":)" + std::to_string(bin_.size()) + R"(,"byteLength":)" +
                    std::to_string(values.size_bytes()) + R"(,"target":)" + std::to_string(target) + '}';
    bin_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    list(accessors_) += R"({"bufferView":)" + std::to_string(count_) + R"(,"componentType":)" +
                        std::to_string(static_cast<int>(component)) + R"(,"count":)" +
                        std::to_string(values.size() / components) + R"(,"type":")" +
                        std::string(kTypes[components - 1]) + '"' + more + '}';
    return count_++;
  }

  template <class T>
  void add_attribute(const std::string& name, std::span<const T> values, std::size_t components,
                     GlbComponent component, const std::string& more = {}) {
    list(attributes_) += '"' + name + "\":" + std::to_string(add(values, components, component, 34962, more));
  }

  Result<std::string> finish(std::size_t indices) && {
    const std::string json =
        R"({"asset":{"version":"2.0","generator":"Burnish"},"scene":0,"scenes":[{"nodes":[0]}],)"
        R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{)" +
        attributes_ + R"(},"indices":)" + std::to_string(indices) + R"(}]}],"accessors":[)" + accessors_ +
        R"(],"bufferViews":[)" + views_ + R"(],"buffers":[{"byteLength":)" + std::to_string(bin_.size()) +
        "}]}";
    return write_glb_container({json, bin_, {}});
  }

 private:
  static std::string& list(std::string& items) { return items.empty() ? items : items += ','; }

  std::string bin_, views_, accessors_, attributes_;
  std::size_t count_ = 0;
};

float finite(float value) { return std::isfinite(value) ? value : 0.0f; }

std::string vector_text(const char* name, const Vec3d& v) {
  return std::string(",\"") + name + "\":[" + json_number(v.x) + ',' + json_number(v.y) + ',' +
         json_number(v.z) + ']';
}

class GlbMaker {
 public:
  GlbMaker(const MovedPositions& moved, const SharedAttributes& attributes, SeamPoints made,
           const RunControl& run)
      : moved_(moved), attributes_(attributes), made_(std::move(made)), run_(run) {}

  Result<Encoded> make() {
    if (auto ok = add_positions(); !ok) return ok.error();
    if (attributes_.normals && !add_normals()) return run_.stop_error();
    if (attributes_.texture_coordinates && !add_texture_coordinates()) return run_.stop_error();
    if (!attributes_.colors.empty() && !add_colors()) return run_.stop_error();
    const std::size_t indices = made_.points.size() > kMostShortIndices
                                    ? add_indices<std::uint32_t>(GlbComponent::UInt32)
                                    : add_indices<std::uint16_t>(GlbComponent::UInt16);
    if (auto ok = run_.check(); !ok) return ok.error();
    auto bytes = std::move(builder_).finish(indices);
    if (!bytes) return bytes.error();
    encoded_.bytes = std::move(*bytes);
    encoded_.format = Format::Glb;
    encoded_.vertices = static_cast<std::uint32_t>(made_.points.size());
    encoded_.triangles = static_cast<std::uint32_t>(made_.triangles.size());
    return std::move(encoded_);
  }

 private:
  template <class Body>
  bool for_points(Body body) {
    return for_each(made_.points.size(), run_, [&](std::size_t p) { body(p, made_.points[p]); });
  }

  Result<> add_positions() {
    std::vector<Vec3f> values(made_.points.size());
    if (!for_points(
            [&](std::size_t p, const SeamPoint& point) { values[p] = to_float(moved_.at(point.vertex)); })) {
      return run_.stop_error();
    }
    Vec3d low = to_double(values.front()), high = low;
    for (std::size_t p = 0; p < values.size(); ++p) {
      const Index vertex = made_.points[p].vertex;
      if (!is_finite(values[p])) {
        return Error{Cause::CannotEncode,
                     "vertex " + std::to_string(vertex) + " is beyond the range of GLB's 32 bit floats"};
      }
      const Vec3d value = to_double(values[p]);
      encoded_.quantisation_error = std::max(encoded_.quantisation_error, length(value - moved_.at(vertex)));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], value[axis]);
        high[axis] = std::max(high[axis], value[axis]);
      }
    }
    add_floats("POSITION", values, 3, vector_text("min", low) + vector_text("max", high));
    return {};
  }

  /// glTF wants unit normals; what has no direction gets one all the same.
  bool add_normals() {
    std::vector<Vec3f> values(made_.points.size());
    const std::vector<float>& rows = attributes_.normals->values;
    const bool done = for_points([&](std::size_t p, const SeamPoint& point) {
      Vec3d n;
      if (point.normal != kNone) {
        const std::size_t at = 3 * std::size_t{point.normal};
        n = {rows[at], rows[at + 1], rows[at + 2]};
      }
      const double size = length(n);
      values[p] = std::isfinite(size) && size > 0 ? to_float(n * (1 / size)) : Vec3f{0, 0, 1};
    });
    if (done) add_floats("NORMAL", values, 3);
    return done;
  }

  bool add_texture_coordinates() {
    std::vector<std::array<float, 2>> values(made_.points.size());
    const std::vector<float>& rows = attributes_.texture_coordinates->values;
    const bool done = for_points([&](std::size_t p, const SeamPoint& point) {
      values[p] = {0, 0};
      if (point.texture == kNone) return;
      const std::size_t at = 2 * std::size_t{point.texture};
      values[p] = {finite(rows[at]), finite(1 - rows[at + 1])};
    });
    if (done) add_floats("TEXCOORD_0", values, 2);
    return done;
  }

  /// As bytes when that loses nothing.
  bool add_colors() {
    std::vector<std::array<float, 3>> values(made_.points.size());
    std::vector<std::array<std::uint8_t, 4>> bytes(made_.points.size());
    std::vector<std::uint8_t> exact(made_.points.size());
    const bool done = for_points([&](std::size_t p, const SeamPoint& point) {
      bytes[p][3] = 255;
      exact[p] = 1;
      for (std::size_t c = 0; c < 3; ++c) {
        const float color =
            std::clamp(finite(attributes_.colors[3 * std::size_t{point.vertex} + c]), 0.0f, 1.0f);
        values[p][c] = color;
        bytes[p][c] = static_cast<std::uint8_t>(std::round(color * 255));
        if (std::abs(color * 255 - static_cast<float>(bytes[p][c])) > 1e-4f) exact[p] = 0;
      }
    });
    if (!done) return false;
    if (std::ranges::find(exact, 0) != exact.end()) {
      add_floats("COLOR_0", values, 3);
    } else {
      const std::span<const std::uint8_t> flat(bytes.front().data(), 4 * bytes.size());
      builder_.add_attribute("COLOR_0", flat, 4, GlbComponent::UInt8, ",\"normalized\":true");
    }
    return true;
  }

  template <class Row>
  void add_floats(const std::string& name, const std::vector<Row>& rows, std::size_t components,
                  const std::string& more = {}) {
    static_assert(sizeof(Row) % sizeof(float) == 0);
    const std::span<const float> flat(reinterpret_cast<const float*>(rows.data()), components * rows.size());
    builder_.add_attribute(name, flat, components, GlbComponent::Float, more);
  }

  template <class T>
  std::size_t add_indices(GlbComponent component) {
    std::vector<T> indices;
    indices.reserve(3 * made_.triangles.size());
    for (const Triangle& t : made_.triangles) {
      for (const Index v : t) indices.push_back(static_cast<T>(v));
    }
    return builder_.add(std::span<const T>(indices), 1, component, 34963);
  }

  const MovedPositions& moved_;
  const SharedAttributes& attributes_;
  SeamPoints made_;
  const RunControl& run_;
  GlbBuilder builder_;
  Encoded encoded_;
};

}  // namespace

Result<Encoded> encode_as_glb(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run) {
  auto made = split_at_seams(moved.original.size(), triangles, attributes, run);
  if (!made) return made.error();
  return GlbMaker(moved, attributes, std::move(*made), run).make();
}

}  // namespace burnish
