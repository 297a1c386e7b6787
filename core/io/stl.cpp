#include "core/io/stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>

#include "core/io/stl_document.h"
#include "core/io/text_scan.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

std::uint32_t declared_facets(std::string_view bytes) {
  std::uint32_t facets = 0;
  std::memcpy(&facets, bytes.data() + kStlHeaderBytes, sizeof facets);
  return facets;
}

bool is_word(std::string_view word, std::string_view lower_case) {
  return std::ranges::equal(word, lower_case,
                            [](unsigned char a, unsigned char b) { return std::tolower(a) == b; });
}

/// The distinct positions so far: an open-addressing table that grows.
class VertexTable {
 public:
  explicit VertexTable(std::vector<Vec3d>& positions) : positions_(positions), slots_(1024, kNone) {}

  /// The vertex at a finite position; a new one when there is none yet.
  Index find_or_add(const Vec3d& position) {
    if (2 * positions_.size() >= slots_.size()) grow();
    Index& slot = slot_of(position);
    if (slot == kNone) {
      slot = static_cast<Index>(positions_.size());
      positions_.push_back(position);
    }
    return slot;
  }

 private:
  Index& slot_of(const Vec3d& p) {
    // Adding zero turns -0 into +0, which compares equal and must hash equal.
    const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value + 0.0); };
    std::uint64_t hash = bits(p.x) + std::rotl(bits(p.y) * 0x9fb21c651e98df25U, 21) +
                         std::rotl(bits(p.z) * 0xd6e8feb86659fd93U, 43);
    hash = (hash ^ (hash >> 32)) * 0x9e3779b97f4a7c15U;
    hash ^= hash >> 29;
    for (std::size_t slot = hash & (slots_.size() - 1);; slot = (slot + 1) & (slots_.size() - 1)) {
      if (slots_[slot] == kNone || positions_[slots_[slot]] == p) return slots_[slot];
    }
  }

  void grow() {
    slots_.assign(slots_.size() * 2, kNone);
    for (Index v = 0; v < positions_.size(); ++v) slot_of(positions_[v]) = v;
  }

  std::vector<Vec3d>& positions_;
  std::vector<Index> slots_;
};

}  // namespace

class StlReader {
 public:
  StlReader(std::string_view bytes, bool text, const Limits& limits, const RunControl& run)
      : bytes_(bytes),
        limits_(limits),
        run_(run),
        document_(std::make_unique<StlDocument>(bytes, text)),
        table_(document_->positions_) {}

  Result<std::unique_ptr<Document>> read() {
    if (auto ok = document_->text_ ? read_text() : read_binary(); !ok) return ok.error();
    if (document_->triangles_.empty()) return Error{Cause::EmptyMesh, "the STL file has no facet"};
    return std::unique_ptr<Document>(std::move(document_));
  }

 private:
  Result<> read_binary() {
    if (bytes_.size() < kFirstStlFacet) {
      return Error{Cause::MalformedMesh,
                   "a binary STL has at least 84 bytes; this file has " + std::to_string(bytes_.size())};
    }
    const std::uint64_t facets = declared_facets(bytes_);
    if (facets > limits_.max_triangles) return too_many("triangles", limits_.max_triangles, "max-triangles");
    if (!has_binary_stl_size(bytes_)) {
      return Error{Cause::MalformedMesh, "the file declares " + std::to_string(facets) +
                                             " facets, which are " +
                                             std::to_string(kFirstStlFacet + facets * kStlFacetBytes) +
                                             " bytes; it has " + std::to_string(bytes_.size())};
    }
    document_->triangles_.reserve(facets);
    for (std::uint64_t f = 0; f < facets; ++f) {
      if (f % kBlockSize == 0 && run_.stopped()) return run_.stop_error();
      std::array<float, 12> numbers{};
      std::memcpy(numbers.data(), bytes_.data() + kFirstStlFacet + f * kStlFacetBytes, sizeof numbers);
      std::array<Vec3d, 3> corners;
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          corners[c][axis] = static_cast<double>(numbers[3 + 3 * c + axis]);
          if (!std::isfinite(corners[c][axis])) return not_finite(f, c, axis);
        }
      }
      if (auto ok = add_facet(corners); !ok) return ok;
    }
    return {};
  }

  Result<> read_text() {
    if (auto ok = check_line_lengths(bytes_, 0, limits_); !ok) return ok;
    TextScanner scanner(bytes_, 0, false);
    for (std::uint64_t solids = 0; scanner.find_word();) {
      const TextScanner before = scanner;
      const std::string_view word = scanner.word();
      if (is_word(word, "solid")) {
        document_->has_names_ |= ++solids > 1 || scanner.find_word_of_line();
        scanner.skip_line();
      } else if (is_word(word, "endsolid")) {
        scanner.skip_line();
      } else if (is_word(word, "facet")) {
        if (auto ok = read_facet(scanner); !ok) return ok;
      } else {
        return before.fail(Cause::MalformedMesh,
                           "expected \"facet\" or \"endsolid\" instead of " + before.quoted());
      }
    }
    return run_.check();
  }

  /// "normal nx ny nz outer loop vertex x y z vertex x y z vertex x y z endloop endfacet".
  Result<> read_facet(TextScanner& scanner) {
    const std::size_t facet = document_->triangles_.size();
    if (facet % kBlockSize == 0 && run_.stopped()) return run_.stop_error();
    if (facet >= limits_.max_triangles) return too_many("triangles", limits_.max_triangles, "max-triangles");
    document_->facet_begins_.push_back(scanner.offset());
    if (auto ok = expect(scanner, "normal"); !ok) return ok;
    for (int axis = 0; axis < 3; ++axis) {
      if (!scanner.find_word()) return ends_in_facet(scanner);
      scanner.word();
    }
    for (const std::string_view word : {"outer", "loop"}) {
      if (auto ok = expect(scanner, word); !ok) return ok;
    }
    std::array<Vec3d, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      if (auto ok = expect(scanner, "vertex"); !ok) return ok;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (scanner.coordinate(corners[c][axis])) continue;
        return scanner.coordinate_error(facet_name(facet) + ", vertex " + std::to_string(c + 1), axis);
      }
    }
    for (const std::string_view word : {"endloop", "endfacet"}) {
      if (auto ok = expect(scanner, word); !ok) return ok;
    }
    return add_facet(corners);
  }

  Result<> expect(TextScanner& scanner, std::string_view word) const {
    if (!scanner.find_word()) return ends_in_facet(scanner);
    const TextScanner before = scanner;
    if (is_word(scanner.word(), word)) return {};
    return before.fail(Cause::MalformedMesh, facet_name(document_->triangles_.size()) + ": expected \"" +
                                                 std::string(word) + "\" instead of " + before.quoted());
  }

  Error ends_in_facet(const TextScanner& scanner) const {
    return scanner.fail(Cause::MalformedMesh, "the file ends in " + facet_name(document_->triangles_.size()));
  }

  Result<> add_facet(const std::array<Vec3d, 3>& corners) {
    Triangle triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      triangle[c] = table_.find_or_add(corners[c]);
      if (triangle[c] == document_->first_facet_.size())
        document_->first_facet_.push_back(static_cast<Index>(document_->triangles_.size()));
    }
    if (document_->positions_.size() > limits_.max_vertices)
      return too_many("vertices", limits_.max_vertices, "max-vertices");
    document_->triangles_.push_back(triangle);
    return {};
  }

  static std::string facet_name(std::uint64_t facet) { return "facet " + std::to_string(facet + 1); }

  static Error not_finite(std::uint64_t facet, std::size_t corner, std::size_t axis) {
    return {Cause::NonFinitePosition,
            facet_name(facet) + ", vertex " + std::to_string(corner + 1) + ": coordinate " + "xyz"[axis] +
                " is not a finite number (byte " +
                std::to_string(kFirstStlFacet + facet * kStlFacetBytes + 12 * (corner + 1) + 4 * axis) + ')'};
  }

  static Error too_many(const std::string& what, std::uint64_t limit, const std::string& name) {
    return {Cause::TooLarge,
            "the mesh has more than " + std::to_string(limit) + ' ' + what + " (" + name + ')'};
  }

  std::string_view bytes_;
  const Limits& limits_;
  const RunControl& run_;
  std::unique_ptr<StlDocument> document_;
  VertexTable table_;
};

bool has_binary_stl_size(std::string_view bytes) {
  if (bytes.size() < kFirstStlFacet) return false;
  const std::uint64_t facets = declared_facets(bytes);
  const std::uint64_t size = kFirstStlFacet + facets * kStlFacetBytes;
  return size == bytes.size() || (facets > 0 && size < bytes.size() && bytes.size() - size < kStlFacetBytes);
}

bool is_cut_binary_stl(std::string_view bytes) {
  if (bytes.size() < kFirstStlFacet) return false;
  const std::string_view header = bytes.substr(0, kStlHeaderBytes);
  const std::size_t end = std::min(header.find('\0'), header.size());
  return looks_like_text(header.substr(0, end)) && header.find_first_not_of('\0', end) == header.npos &&
         kFirstStlFacet + declared_facets(bytes) * std::uint64_t{kStlFacetBytes} > bytes.size();
}

Result<std::unique_ptr<Document>> decode_stl(std::string_view bytes, const Limits& limits,
                                             const RunControl& run) {
  const bool text = looks_like_text(bytes) && !has_binary_stl_size(bytes);
  return StlReader(bytes, text, limits, run).read();
}

}  // namespace burnish
