// An STL file in memory: its bytes, and where in them each facet stands.
#pragma once

#include "core/io/stl.h"

namespace burnish {

inline constexpr std::size_t kStlHeaderBytes = 80, kFirstStlFacet = 84, kStlFacetBytes = 50;

class StlDocument final : public Document {
 public:
  StlDocument(std::string_view bytes, bool text) : Document(Format::Stl), bytes_(bytes), text_(text) {}

  std::string vertex_place(Index vertex) const override;
  std::string triangle_place(Index triangle) const override;
  Result<Encoded> encode_same(const MovedPositions& moved, const OutputOptions& options,
                              const RunControl& run) const override;
  Result<SharedAttributes> shared_attributes(const MovedPositions& moved,
                                             const RunControl& run) const override;

 private:
  friend class StlReader;

  std::uint64_t facet_begin(Index facet) const {
    return text_ ? facet_begins_[facet] : kFirstStlFacet + facet * std::uint64_t{kStlFacetBytes};
  }
  bool moved_facet(const MovedPositions& moved, Index facet) const;
  Result<std::string> patch_text(const MovedPositions& moved, const RunControl& run) const;

  std::string_view bytes_;
  const bool text_;
  std::vector<std::uint64_t> facet_begins_;  // of text: behind each word "facet"
  std::vector<Index> first_facet_;           // of each vertex
  bool has_names_ = false;                   // of text: a solid has one, or there are several
};

/// Unit normal of a facet of moved positions; zero when it has no area.
Vec3f stl_normal(const MovedPositions& moved, const Triangle& facet);

/// The nearest float; never infinite.
float stl_float(double value);

}  // namespace burnish
