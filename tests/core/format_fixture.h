// A mesh on its way through a smoothing, for the tests of codecs.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/io/codec.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

/// A file, decoded, whose vertices a test may move.
struct LoadedFile {
  std::string bytes;
  std::unique_ptr<Document> document;
  Surface surface;
  std::vector<Vec3f> after;

  explicit LoadedFile(std::string file, std::optional<Format> format = {}) : bytes(std::move(file)) {
    auto decoded = decode(bytes, format, {}, {});
    if (!decoded) {
      ADD_FAILURE() << decoded.error().message;
      std::abort();
    }
    document = std::move(*decoded);
    surface = std::move(*prepare_surface(document->positions(), document->triangles(), {}));
    after = surface.mesh.positions;
  }

  MovedPositions moved() const {
    return {document->positions(), surface.weld, surface.mesh.positions, after, surface.mesh.frame};
  }

  /// Moves a vertex of the file, and those at its place, by so much of the file's unit.
  void move(Index vertex, const Vec3d& by) {
    Vec3f& at = after[surface.weld[vertex]];
    at = to_float(to_double(at) + by * (1 / surface.mesh.frame.scale()));
  }
  void move_all() {
    for (std::size_t v = 0; v < after.size(); ++v)
      after[v] = to_float(to_double(after[v]) * (1 + 0.01 * static_cast<double>(v % 7 + 1)));
  }

  Encoded encoded(const OutputOptions& options = {}) const {
    auto written = encode(*document, moved(), options, {});
    if (!written) {
      ADD_FAILURE() << written.error().message;
      return {};
    }
    return std::move(*written);
  }
  std::string written(std::optional<Format> format = {}) const { return encoded({.format = format}).bytes; }
};

inline Error error_of(std::string_view bytes, Format format, const Limits& limits = {},
                      const RunControl& run = {}) {
  const auto result = decode(bytes, format, limits, run);
  return result ? Error{Cause::Internal, "accepted"} : result.error();
}

/// Decodes every prefix of a file: none may crash, and each error must say something.
inline void expect_prefixes_survive(const std::string& bytes, Format format) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string prefix =
        bytes.substr(0, size);  // of its own, so that a sanitizer sees what is read behind
    const auto result = decode(prefix, format, {}, {});
    ASSERT_TRUE(result || !result.error().message.empty()) << size;
  }
}

/// Positions in the order of the file, to a tolerance.
inline void expect_positions(const Document& document, const MovedPositions& moved, double tolerance) {
  ASSERT_GE(document.positions().size(), moved.original.size());
  for (Index v = 0; v < moved.original.size(); ++v) {
    const Vec3d off = document.positions()[v] - moved.at(v);
    ASSERT_LE(length(off), tolerance) << v;
  }
}

}  // namespace burnish::testing
