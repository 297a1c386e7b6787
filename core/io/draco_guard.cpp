#include "core/io/draco_guard.h"

#include <draco/compression/attributes/sequential_attribute_decoders_controller.h>
#include <draco/compression/attributes/sequential_integer_attribute_decoder.h>
#include <draco/compression/attributes/sequential_quantization_attribute_decoder.h>
#include <draco/compression/mesh/mesh_decoder.h>

#include <cstring>

#include "core/io/draco_header.h"

namespace burnish {
namespace {

using Controller = draco::SequentialAttributeDecodersController;
using Prediction = draco::PredictionSchemeTypedDecoderInterface<std::int32_t>;

/// The order of the points is computed behind the library's closed doors, and the class that holds it gives
/// it to nobody. Explicit instantiation is the language's one way to name a private member.
template <auto Member>
struct Opened {
  friend std::unique_ptr<draco::PointsSequencer>& sequencer_of(Controller& controller) {
    return controller.*Member;
  }
};
std::unique_ptr<draco::PointsSequencer>& sequencer_of(Controller& controller);
template struct Opened<&Controller::sequencer_>;

/// The library's prediction, which first has to state a believable count.
class GuardedPrediction final : public Prediction {
 public:
  GuardedPrediction(std::unique_ptr<Prediction> inner, std::uint32_t corners)
      : inner_(std::move(inner)), corners_(corners) {}

  bool DecodePredictionData(draco::DecoderBuffer* buffer) override {
    return believable(*buffer) && inner_->DecodePredictionData(buffer);
  }

  bool ComputeOriginalValues(const std::int32_t* in_corr, std::int32_t* out_data, int size,
                             int num_components, const draco::PointIndex* entry_to_point_id_map) override {
    return inner_->ComputeOriginalValues(in_corr, out_data, size, num_components, entry_to_point_id_map);
  }
  draco::PredictionSchemeMethod GetPredictionMethod() const override { return inner_->GetPredictionMethod(); }
  const draco::PointAttribute* GetAttribute() const override { return inner_->GetAttribute(); }
  bool IsInitialized() const override { return inner_->IsInitialized(); }
  int GetNumParentAttributes() const override { return inner_->GetNumParentAttributes(); }
  draco::GeometryAttribute::Type GetParentAttributeType(int i) const override {
    return inner_->GetParentAttributeType(i);
  }
  bool SetParentAttribute(const draco::PointAttribute* attribute) override {
    return inner_->SetParentAttribute(attribute);
  }
  bool AreCorrectionsPositive() override { return inner_->AreCorrectionsPositive(); }
  draco::PredictionSchemeTransformType GetTransformType() const override {
    return inner_->GetTransformType();
  }

 private:
  /// `buffer` is a copy.
  bool believable(draco::DecoderBuffer buffer) const {
    const auto method = inner_->GetPredictionMethod();
    const bool old = method == draco::MESH_PREDICTION_TEX_COORDS_DEPRECATED;
    if (!old && method != draco::MESH_PREDICTION_TEX_COORDS_PORTABLE) return true;
    const bool plain = !old || buffer.bitstream_version() < DRACO_BITSTREAM_VERSION(2, 2);
    std::uint32_t orientations = 0;
    return read_count(buffer, plain, &orientations) && orientations <= corners_;
  }

  std::unique_ptr<Prediction> inner_;
  std::uint32_t corners_;
};

/// The library casts whatever the file says to its enum, and takes what it does not know for a difference. A
/// reference and its bytes, because even copying such a value is undefined.
draco::PredictionSchemeMethod known(const draco::PredictionSchemeMethod& method) {
  int number = 0;
  static_assert(sizeof(number) == sizeof(method));
  std::memcpy(&number, &method, sizeof(number));
  const bool in_range = number >= draco::PREDICTION_NONE && number < draco::NUM_PREDICTION_SCHEMES;
  return in_range ? method : draco::PREDICTION_DIFFERENCE;
}

template <class Base>
class GuardedAttribute final : public Base {
 protected:
  std::unique_ptr<Prediction> CreateIntPredictionScheme(
      draco::PredictionSchemeMethod method, draco::PredictionSchemeTransformType transform) override {
    auto prediction = Base::CreateIntPredictionScheme(known(method), transform);
    if (!prediction) return prediction;
    const auto* decoder = static_cast<const draco::MeshDecoder*>(this->decoder());
    return std::make_unique<GuardedPrediction>(std::move(prediction), 3 * decoder->mesh()->num_faces());
  }
};

class GuardedController final : public Controller {
 public:
  using Controller::Controller;

 protected:
  std::unique_ptr<draco::SequentialAttributeDecoder> CreateSequentialDecoder(std::uint8_t kind) override {
    switch (kind) {
      case draco::SEQUENTIAL_ATTRIBUTE_ENCODER_INTEGER:
        return std::make_unique<GuardedAttribute<draco::SequentialIntegerAttributeDecoder>>();
      case draco::SEQUENTIAL_ATTRIBUTE_ENCODER_QUANTIZATION:
        return std::make_unique<GuardedAttribute<draco::SequentialQuantizationAttributeDecoder>>();
      default:  // raw values, and normals: these have no prediction that counts anything
        return Controller::CreateSequentialDecoder(kind);
    }
  }
};

}  // namespace

std::unique_ptr<draco::AttributesDecoderInterface> guarded(const draco::AttributesDecoderInterface* made) {
  // The library hands out what its caller owns as const.
  auto* const plain = dynamic_cast<Controller*>(const_cast<draco::AttributesDecoderInterface*>(made));
  if (plain == nullptr) return nullptr;
  return std::make_unique<GuardedController>(std::move(sequencer_of(*plain)));
}

}  // namespace burnish
