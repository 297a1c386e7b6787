#include "tests/fuzz/round_trip.h"

#include <cstdio>
#include <cstdlib>

#include "core/io/estimate.h"
#include "core/io/pins.h"
#include "core/smooth/registry.h"

namespace burnish::fuzz {
namespace {

const RunControl kRun{};

[[noreturn]] void fail(const char* what, const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", what, message.c_str());
  std::abort();
}

/// Every method gets its share of the inputs.
const Method& method_for(std::string_view bytes) {
  const auto all = methods();
  return all[bytes.size() % all.size()];
}

/// Names that a mesh may have or not.
void pin(const Document& document, Surface& surface) {
  for (const PinOptions& pins : {PinOptions{.vertices = {1}, .group = "a"}, PinOptions{.group = "default"},
                                 PinOptions{.attribute = "1"}}) {
    const auto pinned = pin_vertices(document, pins, surface, kRun);
    if (!pinned && pinned.error().cause != Cause::BadOption) fail("pin", pinned.error().message);
  }
}

void smooth(Surface& surface, const Method& method) {
  const auto parameters = resolve_parameters(method, {{"iterations", std::int64_t{1}}, {"boundary", "free"}});
  if (!parameters) fail("parameters", parameters.error().message);
  if (const auto outcome = method.run(surface, *parameters, kRun); !outcome) {
    fail("smooth", outcome.error().message);
  }
}

/// Edgebreaker drops triangles without area, which may be all of them.
bool may_be_empty(const Encoded& encoded) { return encoded.draco_method == DracoMethod::Edgebreaker; }

void write_and_read(const Document& document, const MovedPositions& moved, Format target) {
  const auto encoded = encode(document, moved, {.format = target}, kRun);
  if (!encoded) {
    if (encoded.error().cause == Cause::CannotEncode) return;
    fail("encode", encoded.error().message);
  }
  const auto again = decode(encoded->bytes, target, Limits{}, kRun);
  if (!again) {
    if (again.error().cause == Cause::EmptyMesh && may_be_empty(*encoded)) return;
    fail("decode again", again.error().message);
  }
  if (may_be_empty(*encoded)) return;
  // STL shares corners by position; Draco and PLY copy vertices at seams.
  const bool same_vertices = (*again)->positions().size() == document.positions().size();
  if (!same_vertices && (target == Format::Obj || target == Format::Off))
    fail("decode again", "other vertices");
  if ((*again)->triangles().size() != document.triangles().size()) fail("decode again", "other triangles");
}

}  // namespace

void round_trip(std::string_view bytes, Format format) {
  if (estimate(bytes, format).memory_bytes == 0 && !bytes.empty()) fail("estimate", "0 bytes");
  const auto document = decode(bytes, format, kLimits, kRun);
  if (!document) return;
  const Document& file = **document;
  auto surface = prepare_surface(file.positions(), file.triangles(), kRun, file.parts());
  if (!surface) fail("prepare", surface.error().message);
  const std::vector<Vec3f> before = surface->mesh.positions;
  pin(**document, *surface);
  smooth(*surface, method_for(bytes));
  const MovedPositions moved{(*document)->positions(), surface->weld, before, surface->mesh.positions,
                             surface->mesh.frame};
  for (const Format target : {Format::Obj, Format::Draco, Format::Ply, Format::Stl, Format::Off, Format::Glb})
    write_and_read(**document, moved, target);
}

}  // namespace burnish::fuzz
