// A GLB on its way through a smoothing, for the codec's tests.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>

#include "core/io/codec.h"
#include "core/io/glb.h"
#include "tests/support/glb.h"

namespace burnish::testing {

inline std::unique_ptr<Document> decoded_glb(std::string_view bytes) {
  auto document = decode_glb(bytes, Limits{}, {});
  EXPECT_TRUE(document.ok()) << (document.ok() ? "" : document.error().message);
  return document.ok() ? std::move(document).value() : nullptr;
}

inline Error glb_error(std::string_view bytes, const Limits& limits = {}) {
  const auto document = decode_glb(bytes, limits, {});
  EXPECT_FALSE(document.ok());
  return document.ok() ? Error{Cause::Internal, "no error"} : document.error();
}

/// A document's surface with positions that a test moves.
struct MovedGlb {
  const Document& document;
  Surface surface;
  std::vector<Vec3f> after;

  explicit MovedGlb(const Document& of)
      : document(of),
        surface(std::move(*prepare_surface(of.positions(), of.triangles(), {}, of.parts()))),
        after(surface.mesh.positions) {}

  /// Every vertex a different way, except those that `still` tells.
  template <class Still>
  MovedGlb& shake(float by, Still still) {
    for (std::size_t v = 0; v < after.size(); ++v) {
      if (still(surface.mesh.frame.to_file(to_double(after[v])))) continue;
      const auto i = static_cast<float>(v);
      after[v] += Vec3f{std::sin(i), std::sin(2 * i + 1), std::cos(3 * i)} * by;
    }
    return *this;
  }
  MovedGlb& shake(float by = 0.01f) {
    return shake(by, [](const Vec3d&) { return false; });
  }

  MovedPositions view() const {
    return {document.positions(), surface.weld, surface.mesh.positions, after, surface.mesh.frame};
  }
  Encoded encoded(const OutputOptions& options = {}) const {
    auto result = encode(document, view(), options, {});
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
    return result.ok() ? std::move(result).value() : Encoded{};
  }
  /// Where a vertex should be, as 32 bit floats say it.
  Vec3f wanted(Index vertex) const { return to_float(view().at(vertex)); }
};

template <class T>
T value_at(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.substr(at, sizeof value).data(), sizeof value);
  return value;
}

inline const Warning* find_warning(const Encoded& encoded, std::string_view code) {
  for (const Warning& warning : encoded.warnings) {
    if (warning.code == code) return &warning;
  }
  return nullptr;
}

}  // namespace burnish::testing
