#include "core/io/estimate.h"

#include <algorithm>

#include "core/io/declared.h"
#include "core/io/draco_header.h"
#include "core/io/glb_counts.h"

namespace burnish {
namespace {

// Bytes of memory per thing in the file. Measured as the peak of `burnish smooth --threads 1` over that of a
// mesh of one triangle, with 20 thousand to 1.5 million triangles: OBJ with and without normals and texture
// coordinates, of triangles, quads and unshared vertices, and both Draco methods, lossless and quantised,
// written as they were and as the other format. From 200 thousand triangles on these give 1 to 2 times the
// peak in the same format, and 0.83 times where quantised Draco with normals and texture coordinates becomes
// OBJ.
constexpr double kObjVertex = 70, kObjTriangle = 180, kObjRow = 45, kObjCitingTriangle = 24, kObjByte = 1;
constexpr double kDracoPoint = 90, kDracoTriangle = 250, kDracoByte = 3;
// PLY, STL and OFF, text and binary, with and without attributes, measured in the same way with a million
// triangles: 1.2 to 1.7 times the peak in the same format (2.2 with attributes, which only other formats
// take memory for), and 0.9 times where attributes become OBJ.
constexpr double kOtherVertex = 70, kOtherTriangle = 180, kOtherRow = 80, kLeastPerOtherByte = 2,
                 kOtherBytesPerTriangle = 50;
// The same per byte of the file for those that are largest on disk: text, or lossless floats, with
// everything.
constexpr double kLeastPerObjByte = 2.5, kObjBytesPerTriangle = 110;
constexpr double kLeastPerDracoByte = 9, kDracoBytesPerTriangle = 25;

// GLB, measured likewise with a million triangles, bare, with normals and texture coordinates, and compressed
// by Draco: these give 0.95 to 1.7 times the peak, and 0.8 times where a file with everything becomes OBJ. Of
// its bytes the buffer is copied and the written file stands beside it; most of them may be pictures.
constexpr double kGlbVertex = 130, kGlbTriangle = 200, kGlbByte = 2;
constexpr double kLeastPerGlbByte = 2, kGlbBytesPerTriangle = 60;
constexpr double kUnknownGlbByte = 12;  // of a file with many meshes: with positions and normals 10 to 14
constexpr std::size_t kMostGlbJson = 1 << 20;

// What is free again while a mesh is smoothed, per triangle. With it the peaks of 1.1 million triangles, 258
// MB (laplacian) to 551 MB (guided), are taken for 1.01 to 1.3 times what they are.
constexpr double kSpareTriangle = 70;

constexpr std::size_t kWindows = 64, kWindowBytes = 1024;

std::uint64_t whole(double count) { return static_cast<std::uint64_t>(std::clamp(count, 0.0, 0x1p63)); }

Estimate make_estimate(double memory, double vertices, double triangles) {
  return {whole(memory), whole(vertices), whole(triangles)};
}

/// What the lines of an OBJ are, as far as they were looked at.
class LineSample {
 public:
  /// Counts the lines that stand whole in [begin, end) of the text.
  void look_at(std::string_view text, std::size_t begin, std::size_t end) {
    if (begin > 0) begin = next_line(text, begin, end);
    while (begin < end) {
      const std::size_t next = next_line(text, begin, end);
      if (next == end && end < text.size()) return;
      count(text.substr(begin, next - begin));
      begin = next;
    }
  }

  Estimate scaled_to(std::size_t size) const {
    const double scale = static_cast<double>(size) / std::max(bytes_, 1.0);
    const double per_triangle = kObjTriangle + (rows_ > 0 ? kObjCitingTriangle : 0);
    const double memory = vertices_ * kObjVertex + triangles_ * per_triangle + rows_ * kObjRow;
    return make_estimate(memory * scale + static_cast<double>(size) * kObjByte, vertices_ * scale,
                         triangles_ * scale);
  }

  bool empty() const { return bytes_ == 0; }

 private:
  static std::size_t next_line(std::string_view text, std::size_t begin, std::size_t end) {
    const std::string_view rest = text.substr(begin, end - begin);
    const std::size_t feed = std::min(rest.find('\n'), rest.size());  // find_first_of takes ten times as long
    return std::min(begin + std::min(rest.substr(0, feed).find('\r'), feed) + 1, end);
  }

  void count(std::string_view line) {
    bytes_ += static_cast<double>(line.size());
    const auto starts = [&](std::string_view keyword) {
      return line.starts_with(keyword) && line.size() > keyword.size() && is_blank(line[keyword.size()]);
    };
    if (starts("v")) vertices_ += 1;
    if (starts("vt") || starts("vn")) rows_ += 1;
    if (starts("f")) triangles_ += std::max(0.0, words(line) - 3);
  }

  static bool is_blank(char c) { return c == ' ' || c == '\t'; }

  static double words(std::string_view line) {
    double words = 0;
    bool inside = false;
    for (const char c : line) {
      const bool blank = is_blank(c) || c == '\r' || c == '\n';
      if (!blank && !inside) words += 1;
      inside = !blank;
    }
    return words;
  }

  double bytes_ = 0, vertices_ = 0, triangles_ = 0, rows_ = 0;
};

Estimate estimate_obj(std::string_view text) {
  LineSample sample;
  if (text.size() <= kWindows * kWindowBytes) {
    sample.look_at(text, 0, text.size());
  } else {
    const std::size_t last = text.size() - kWindowBytes;
    for (std::size_t w = 0; w < kWindows; ++w) {
      const std::size_t begin = last / (kWindows - 1) * w;
      sample.look_at(text, begin, begin + kWindowBytes);
    }
  }
  return sample.empty() ? estimate(text.size(), Format::Obj) : sample.scaled_to(text.size());
}

Estimate estimate_draco(std::string_view bytes) {
  const auto counts = peek_counts(bytes);
  if (!counts) return estimate(bytes.size(), Format::Draco);
  const double points = counts->points, triangles = counts->triangles;
  return make_estimate(
      points * kDracoPoint + triangles * kDracoTriangle + static_cast<double>(bytes.size()) * kDracoByte,
      points, triangles);
}

Estimate estimate_declared(std::string_view bytes, Format format) {
  const auto counts = declared_counts(behind_byte_order_mark(bytes, format), format);
  if (!counts) return estimate(bytes.size(), format);
  return make_estimate(counts->vertices * kOtherVertex + counts->triangles * kOtherTriangle +
                           counts->rows * kOtherRow +
                           static_cast<double>(bytes.size()) * counts->written_bytes,
                       counts->vertices, counts->triangles);
}

bool tells_its_counts(Format format) {
  return format == Format::Ply || format == Format::Stl || format == Format::Off;
}

Estimate estimate_glb(std::string_view bytes) {
  const auto counts = declared_glb_counts(bytes, kMostGlbJson);
  const auto size = static_cast<double>(bytes.size());
  if (!counts)
    return make_estimate(size * kUnknownGlbByte, size / kGlbBytesPerTriangle / 2,
                         size / kGlbBytesPerTriangle);
  return make_estimate(counts->vertices * kGlbVertex + counts->triangles * kGlbTriangle + size * kGlbByte,
                       counts->vertices, counts->triangles);
}

}  // namespace

std::uint64_t Estimate::memory_with(std::uint64_t smoothing_bytes) const {
  const double spare = static_cast<double>(triangles) * kSpareTriangle;
  return memory_bytes + whole(static_cast<double>(smoothing_bytes) - spare);
}

Estimate estimate(std::string_view bytes, std::optional<Format> format) {
  if (!format) format = detect_format(bytes);
  if (!format) return estimate(bytes.size(), std::nullopt);
  if (*format == Format::Obj) return estimate_obj(bytes);
  if (*format == Format::Draco) return estimate_draco(bytes);
  if (tells_its_counts(*format)) return estimate_declared(bytes, *format);
  if (*format == Format::Glb) return estimate_glb(bytes);
  return estimate(bytes.size(), format);
}

Estimate estimate(std::uint64_t bytes, std::optional<Format> format) {
  const auto size = static_cast<double>(bytes);
  if (format == Format::Draco) {
    const double triangles = size / kDracoBytesPerTriangle;
    return make_estimate(size * kLeastPerDracoByte, triangles / 2, triangles);
  }
  if (format && tells_its_counts(*format)) {
    const double triangles = size / kOtherBytesPerTriangle;
    return make_estimate(size * kLeastPerOtherByte, triangles / 2, triangles);
  }
  if (format == Format::Glb) {
    const double triangles = size / kGlbBytesPerTriangle;
    return make_estimate(size * kLeastPerGlbByte, triangles / 2, triangles);
  }
  const double triangles = size / kObjBytesPerTriangle;
  return make_estimate(size * kLeastPerObjByte, triangles / 2, triangles);
}

}  // namespace burnish
