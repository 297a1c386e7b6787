// The call of Draco's encoder, around what Draco 1.5.5 does badly.
#include <draco/compression/expert_encode.h>

#include <charconv>
#include <string>

#include "core/io/draco_document.h"

namespace burnish {
namespace {

/// The entropy coder allocates four bytes per possible symbol, 4 GiB at 30 bits; beyond this many integers
/// are stored as they are.
constexpr std::int64_t kMostSymbols = std::int64_t{1} << 24;
/// The decoder refuses predicted integers that span more than this.
constexpr std::int64_t kMostPredicted = (std::int64_t{1} << 31) - 2;

void append_exactly(std::string& text, float value) {
  char digits[32];
  const auto end = std::to_chars(std::begin(digits), std::end(digits), static_cast<double>(value)).ptr;
  text.append(text.empty() ? "" : " ").append(digits, end);
}

/// The encoder's options are text. Its own setters keep six decimals, which moves the grid of a small mesh.
draco::Options quantisation_options(const DracoCoding& coding) {
  draco::Options options;
  options.SetInt("quantization_bits", coding.bits);
  if (!coding.grid) return options;
  std::string origin, range;
  for (const float o : coding.grid->origin()) append_exactly(origin, o);
  append_exactly(range, coding.grid->range());
  options.SetString("quantization_origin", origin);
  options.SetString("quantization_range", range);
  return options;
}

/// How many different integers an attribute's values may be coded as.
std::int64_t integer_span(const draco::PointAttribute& attribute, const DracoCoding& coding) {
  if (coding.bits > 0) return std::int64_t{1} << coding.bits;
  if (attribute.data_type() != draco::DT_INT32 && attribute.data_type() != draco::DT_UINT32) return 0;
  std::vector<std::int64_t> value(static_cast<std::size_t>(attribute.num_components()));
  std::int64_t low = 0, high = 0;
  for (draco::AttributeValueIndex i(0); i < static_cast<std::uint32_t>(attribute.size()); ++i) {
    attribute.ConvertValue<std::int64_t>(i, value.data());
    const auto [least, most] = std::minmax_element(value.begin(), value.end());
    low = std::min(low, *least);
    high = std::max(high, *most);
  }
  return high - low + 1;
}

}  // namespace

Result<DracoFile> encode_with_library(const draco::Mesh& mesh, std::span<const DracoCoding> codings,
                                      DracoMethod method, int speed, const RunControl& run) {
  const bool edgebreaker = method == DracoMethod::Edgebreaker;
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetTrackEncodedProperties(edgebreaker);
  for (int id = 0; id < mesh.num_attributes(); ++id) {
    const DracoCoding& coding = codings[static_cast<std::size_t>(id)];
    if (coding.bits > 0) encoder.options().SetAttributeOptions(id, quantisation_options(coding));
    const std::int64_t span = integer_span(*mesh.attribute(id), coding);
    if (span > kMostSymbols) encoder.SetUseBuiltInAttributeCompression(false);
    if (span > kMostPredicted)
      encoder.options().SetAttributeInt(id, "prediction_scheme", draco::PREDICTION_NONE);
  }
  if (auto ok = run.check(); !ok) return ok.error();
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (auto ok = run.check(); !ok) return ok.error();
  if (!status.ok()) {
    return Error{Cause::CannotEncode, "Draco cannot write this mesh: " + status.error_msg_string()};
  }
  return DracoFile{{buffer.data(), buffer.size()}, encoder.num_encoded_points(), encoder.num_encoded_faces()};
}

}  // namespace burnish
