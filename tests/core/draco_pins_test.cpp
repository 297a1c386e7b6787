// Pinning the points that an attribute of a Draco mesh chooses.
#include <gmock/gmock.h>

#include "core/io/pins.h"
#include "tests/core/draco_fixture.h"

namespace burnish::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::uint32_t kPoints = 6, kBytesId = 20, kFloatsId = 21, kNothingId = 22, kNamedId = 23;

void name_attribute(draco::Mesh& mesh, int id, const std::string& name) {
  auto metadata = std::make_unique<draco::AttributeMetadata>();
  metadata->AddEntryString("name", name);
  mesh.AddAttributeMetadata(id, std::move(metadata));
}

/// Two triangles that share an edge in space but no point, with attributes of several kinds; the last one's
/// name is another one's number.
std::string two_triangles() {
  draco::Mesh mesh;
  mesh.set_num_points(kPoints);
  mesh.AddFace({draco::PointIndex(0), draco::PointIndex(1), draco::PointIndex(2)});
  mesh.AddFace({draco::PointIndex(3), draco::PointIndex(4), draco::PointIndex(5)});
  add_point_attribute<float>(mesh, DracoAttribute::POSITION, draco::DT_FLOAT32, 3, false,
                             {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  const int bytes = add_point_attribute<std::uint8_t>(mesh, DracoAttribute::GENERIC, draco::DT_UINT8, 2,
                                                      false, {0, 0, 0, 9, 0, 0, 7, 0, 1, 1, 0, 0});
  const int floats = add_point_attribute<float>(mesh, DracoAttribute::GENERIC, draco::DT_FLOAT32, 1, false,
                                                {0, -0.0F, 1e-30F, NAN, -2, 0});
  const int nothing = add_point_attribute<std::int16_t>(mesh, DracoAttribute::GENERIC, draco::DT_INT16, 1,
                                                        false, {0, 0, 0, 0, 0, 0});
  const int named = add_point_attribute<std::uint8_t>(mesh, DracoAttribute::GENERIC, draco::DT_UINT8, 1,
                                                      false, {1, 0, 0, 0, 0, 0});
  mesh.attribute(bytes)->set_unique_id(kBytesId);
  mesh.attribute(floats)->set_unique_id(kFloatsId);
  mesh.attribute(nothing)->set_unique_id(kNothingId);
  mesh.attribute(named)->set_unique_id(kNamedId);
  name_attribute(mesh, bytes, "selected");
  name_attribute(mesh, named, std::to_string(kNothingId));
  return write_with_library(mesh, {});
}

TEST(DracoPins, ChoosePointsWhereAComponentIsNotZero) {
  const std::string file = two_triangles();
  const auto document = decoded(file);
  EXPECT_THAT(*document->attribute_vertices("selected", kRun), ElementsAre(1, 3, 4));
  EXPECT_THAT(*document->attribute_vertices("20", kRun), ElementsAre(1, 3, 4));
  EXPECT_THAT(*document->attribute_vertices("21", kRun), ElementsAre(2, 3, 4)) << "-0 is 0, NaN is not";
  EXPECT_THAT(*document->attribute_vertices("22", kRun), ElementsAre(0)) << "a name goes before a number";
  EXPECT_THAT(*document->attribute_vertices("0", kRun), ElementsAre(1, 2, 3, 4, 5)) << "positions, too";
}

TEST(DracoPins, SurviveTheEncodersOfTheLibrary) {
  for (const auto method : kMethods) {
    const std::string file = write_with_library(*seamed_sphere(), {.method = method, .position_bits = 12});
    const auto document = decoded(file);
    const auto mesh = read_with_library(file);
    const auto chosen = document->attribute_vertices(std::to_string(kGenericId), kRun);
    ASSERT_TRUE(chosen.ok()) << chosen.error().message;
    std::vector<Index> expected;
    for (std::uint32_t p = 0; p < mesh->num_points(); ++p) {
      std::int16_t value = 0;
      mesh->GetAttributeByUniqueId(kGenericId)->GetMappedValue(draco::PointIndex(p), &value);
      if (value != 0) expected.push_back(p);
    }
    EXPECT_EQ(*chosen, expected);
    EXPECT_LT(chosen->size(), mesh->num_points());
    EXPECT_GT(chosen->size(), mesh->num_points() / 2);
  }
}

TEST(DracoPins, PinEveryPointAtThePlace) {
  const std::string file = two_triangles();
  const auto document = decoded(file);
  Surface surface = *prepare_surface(document->positions(), document->triangles(), kRun);
  EXPECT_EQ(*pin_vertices(*document, {.attribute = "selected"}, surface, kRun), 3U);
  EXPECT_EQ(*pin_vertices(*document, {.vertices = {2}}, surface, kRun), 2U) << "point 5 lies there as well";
  EXPECT_THAT(surface.pinned[surface.weld[5]], 1);
}

TEST(DracoPins, NameWhatThereIs) {
  const std::string file = two_triangles();
  const auto document = decoded(file);
  EXPECT_EQ(
      document->attribute_vertices("chosen", kRun).error(),
      (Error{Cause::BadOption, R"(the mesh has no attribute "chosen"; it has "0", "selected", "21", "22")",
             "pinned.attribute"}));
  for (const char* not_a_number : {"020", "20 ", "-1", "4294967316", ""}) {
    EXPECT_FALSE(document->attribute_vertices(not_a_number, kRun)) << not_a_number;
  }
  Surface surface = *prepare_surface(document->positions(), document->triangles(), kRun);
  EXPECT_EQ(pin_vertices(*document, {.group = "a"}, surface, kRun).error(),
            (Error{Cause::BadOption, "a Draco mesh has no groups to pin by", "pinned.group"}));
}

TEST(DracoPins, StopWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const std::string file = two_triangles();
  const auto document = decoded(file);
  EXPECT_EQ(document->attribute_vertices("selected", {.stop = source.get_token()}).error().cause,
            Cause::Cancelled);
}

}  // namespace
}  // namespace burnish::testing
