#include "server/service/measures.h"

#include <algorithm>

#include "server/service/smooth_service.h"

namespace burnish {

void fill(const ErrorMeasures& measures, std::string_view against, v1::MeshErrors& out) {
  out.set_against(std::string(against));
  out.set_ev(measures.ev);
  out.set_ev_over_edge(measures.ev_over_edge);
  out.set_ev_over_diagonal(measures.ev_over_diagonal);
  out.set_mean_distance(measures.mean_distance);
  out.set_rms_distance(measures.rms_distance);
  out.set_max_distance(measures.max_distance);
  if (measures.mean_normal_degrees) out.set_mean_normal_degrees(*measures.mean_normal_degrees);
  if (measures.max_normal_degrees) out.set_max_normal_degrees(*measures.max_normal_degrees);
  if (measures.flipped_triangles) out.set_flipped_triangles(*measures.flipped_triangles);
}

void fill(const MeshChange& change, v1::MeshChange& out) {
  out.set_rms_displacement(change.rms_displacement);
  out.set_max_displacement(change.max_displacement);
  out.set_area_percent(change.area_percent);
  out.set_volume_percent(change.volume_percent);
  out.set_smallest_angle_degrees_before(change.smallest_angle_before);
  out.set_smallest_angle_degrees_after(change.smallest_angle_after);
}

void fill(const Encoded& encoded, Format format, v1::EncodingSummary& out) {
  out.set_format(to_proto(format));
  if (encoded.draco_method) {
    out.set_draco_method(*encoded.draco_method == DracoMethod::Sequential ? v1::DRACO_METHOD_SEQUENTIAL
                                                                          : v1::DRACO_METHOD_EDGEBREAKER);
  }
  out.set_position_bits(static_cast<std::uint32_t>(encoded.position_bits));
  out.set_quantisation_error(encoded.quantisation_error);
  out.set_bytes(static_cast<std::uint32_t>(encoded.bytes.size()));
}

Warning connectivity_differs() {
  return {"connectivity_differs", "the reference has other triangles, so normals were not compared", 1};
}

bool same_connectivity(const Document& a, const Document& b) {
  return a.positions().size() == b.positions().size() && std::ranges::equal(a.triangles(), b.triangles());
}

}  // namespace burnish
