// What `smooth` is called with.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "burnish/v1/smoothing.pb.h"
#include "client/cli/place.h"

namespace burnish::cli {

struct SmoothArguments {
  std::vector<std::string> files;  ///< IN and OUT; with an output folder, or in a dry run, those to smooth
  std::string output_folder, reference, report, method;
  Place place;
  std::optional<std::uint32_t> iterations;
  std::vector<std::string> assignments;  ///< name=value
  std::vector<std::uint32_t> pinned_vertices;
  std::string pinned_group, pinned_attribute;
  std::optional<v1::MeshFormat> output_format;
  v1::DracoMethod draco_method = v1::DRACO_METHOD_UNSPECIFIED;
  std::optional<std::uint32_t> position_bits, normal_bits, texture_coordinate_bits, color_bits, generic_bits,
      speed;
  bool json = false, dry_run = false;
};

/// For a mesh that is written to `out`, whose name may ask for a format. Errors: BadOption.
Result<v1::SmoothOptions> smooth_options(const SmoothArguments& arguments, const std::string& out);

}  // namespace burnish::cli
