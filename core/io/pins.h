// Vertices that must not move, as callers name them in a file's own terms.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// What any of the members names is pinned.
struct PinOptions {
  std::vector<Index> vertices = {};  ///< of the file, from 0: `v` lines of an OBJ, points of a Draco mesh
  std::string group = {};            ///< see Document::group_vertices(); "": none
  std::string attribute = {};        ///< see Document::attribute_vertices(); "": none
};

/// Fills surface.pinned; `surface` must come from `document`. File vertices that share their position are one
/// vertex of the surface, so all of them are pinned as soon as one is. Gives how many vertices of the file
/// are pinned then. Errors: BadOption, its field "pinned.vertices[3]", "pinned.group" or "pinned.attribute";
/// Cancelled, DeadlineExceeded.
Result<std::uint32_t> pin_vertices(const Document& document, const PinOptions& options, Surface& surface,
                                   const RunControl& run);

/// The names of one kind that a file holds, for the error that says so: the first few, each once.
class KnownNames {
 public:
  void add(std::string_view name);
  /// `the mesh has no group "a"; it has "b", "c" and more`
  Error missing(std::string_view kind, std::string_view wanted) const;

 private:
  std::vector<std::string> names_;
  bool more_ = false;
};

/// Text of a file or a caller as a message quotes it: its first bytes, printable.
std::string quote(std::string_view text);

}  // namespace burnish
