// The Draco codec: what comes in, and that everything but the moved positions goes out again.
#include <algorithm>
#include <set>
#include <tuple>

#include "tests/core/draco_fixture.h"

namespace burnish::testing {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(BURNISH_MESHES) / "draco";

struct FileRow {
  const char* name;
  std::optional<Cause> failure;
  std::size_t points, triangles;
  DracoMethod method;
  int position_bits;
};

constexpr FileRow kFiles[] = {
    {"bunny_gltf.drc", {}, 34834, 69451, DracoMethod::Edgebreaker, 14},
    {"car.drc", {}, 1856, 1744, DracoMethod::Sequential, 0},
    {"cube_att.drc", {}, 24, 12, DracoMethod::Edgebreaker, 14},
    {"cube_att.obj.edgebreaker.cl10.2.2.drc", {}, 24, 12, DracoMethod::Edgebreaker, 20},
    {"cube_att.obj.edgebreaker.cl4.2.2.drc", {}, 24, 12, DracoMethod::Edgebreaker, 20},
    {"cube_att.obj.sequential.cl3.2.2.drc", {}, 24, 12, DracoMethod::Sequential, 20},
    {"cube_att_sub_o_2.drc", {}, 26, 12, DracoMethod::Edgebreaker, 14},
    {"cube_pc.drc", Cause::NotATriangleMesh, 0, 0, DracoMethod::Sequential, 0},
};

TEST(Draco, EveryBundledFileHasItsExpectedOutcome) {
  if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "no meshes in " << kFolder;
  for (const FileRow& row : kFiles) {
    SCOPED_TRACE(row.name);
    const std::string bytes = read_file(kFolder / row.name);
    const auto document = decode_draco(bytes, Limits{}, kRun);
    ASSERT_EQ(document.ok(), !row.failure) << (document.ok() ? "" : document.error().message);
    if (row.failure) {
      EXPECT_EQ(document.error().cause, *row.failure);
      continue;
    }
    EXPECT_EQ((*document)->positions().size(), row.points);
    EXPECT_EQ((*document)->triangles().size(), row.triangles);
    const auto encoded = (*document)->encode_same(Moved(**document).view(), {}, kRun);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    EXPECT_EQ(encoded->draco_method, row.method);
    EXPECT_EQ(encoded->position_bits, row.position_bits);
    EXPECT_EQ(encoded->quantisation_error, 0);
    const auto again = decoded(encoded->bytes);
    ASSERT_NE(again, nullptr);
    EXPECT_EQ(again->triangles().size(), row.triangles);
  }
}

TEST(Draco, PositionsAreThoseThatTheLibraryReads) {
  for (const auto method : kMethods) {
    const std::string bytes = write_with_library(*seamed_sphere(), {.method = method, .position_bits = 12});
    const auto document = decoded(bytes);
    const auto mesh = read_with_library(bytes);
    ASSERT_EQ(document->positions().size(), mesh->num_points());
    for (std::uint32_t p = 0; p < mesh->num_points(); ++p) {
      const auto v = at_point(*mesh, DracoAttribute::POSITION, p);
      ASSERT_EQ(document->positions()[p], (Vec3d{v[0], v[1], v[2]}));
    }
  }
}

/// What makes up a corner of a triangle, whatever the order of the file: texture, colour and the generic
/// value.
using Corner = std::tuple<std::array<float, 2>, std::array<std::uint8_t, 3>, std::int16_t>;

std::multiset<Corner> corners_of(const draco::Mesh& mesh) {
  std::multiset<Corner> corners;
  for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& p : mesh.face(f)) {
      Corner c;
      mesh.GetNamedAttribute(DracoAttribute::TEX_COORD)->GetMappedValue(p, std::get<0>(c).data());
      mesh.GetNamedAttribute(DracoAttribute::COLOR)->GetMappedValue(p, std::get<1>(c).data());
      mesh.GetNamedAttribute(DracoAttribute::GENERIC)->GetMappedValue(p, &std::get<2>(c));
      corners.insert(c);
    }
  }
  return corners;
}

TEST(Draco, SeamsColoursIdsAndMetadataSurvive) {
  for (const auto method : kMethods) {
    for (const int bits : {0, 12}) {
      for (const int speed : {0, 5, 7, 10}) {
        SCOPED_TRACE(std::to_string(static_cast<int>(method)) + ", " + std::to_string(bits) +
                     " bits, speed " + std::to_string(speed));
        const std::string bytes = write_with_library(
            *seamed_sphere(),
            {.method = method, .position_bits = bits, .normal_bits = bits, .texture_bits = bits});
        const auto document = decoded(bytes);
        Moved moved(*document);
        for (Vec3f& p : moved.after) p *= 0.97f;
        OutputOptions options;
        options.draco.speed = speed;
        const auto encoded = document->encode_same(moved.view(), options, kRun);
        ASSERT_TRUE(encoded.ok()) << encoded.error().message;

        const auto before = read_with_library(bytes), after = read_with_library(encoded->bytes);
        EXPECT_EQ(corners_of(*before), corners_of(*after));
        ASSERT_EQ(after->num_attributes(), before->num_attributes());
        const draco::PointAttribute* color = after->GetAttributeByUniqueId(kColorId);
        ASSERT_NE(color, nullptr);
        EXPECT_EQ(color->attribute_type(), DracoAttribute::COLOR);
        EXPECT_EQ(color->data_type(), draco::DT_UINT8);
        EXPECT_TRUE(color->normalized());
        const draco::PointAttribute* generic = after->GetAttributeByUniqueId(kGenericId);
        ASSERT_NE(generic, nullptr);
        EXPECT_EQ(generic->data_type(), draco::DT_INT16);
        std::string scanner;
        std::int32_t gamma = 0;
        ASSERT_NE(after->GetMetadata(), nullptr);
        EXPECT_TRUE(after->GetMetadata()->GetEntryString("scanner", &scanner));
        EXPECT_EQ(scanner, "bench 3");
        ASSERT_NE(after->GetAttributeMetadataByAttributeId(after->GetNamedAttributeId(DracoAttribute::COLOR)),
                  nullptr);
        after->GetAttributeMetadataByAttributeId(after->GetNamedAttributeId(DracoAttribute::COLOR))
            ->GetEntryInt("gamma", &gamma);
        EXPECT_EQ(gamma, 22);
      }
    }
  }
}

TEST(Draco, SeamsStayClosed) {
  const std::string bytes = write_with_library(*seamed_sphere(), {.position_bits = 10});
  const auto document = decoded(bytes);
  Moved moved(*document);
  ASSERT_EQ(moved.surface.welded_vertices, static_cast<std::uint32_t>(kRings - 1));
  for (std::size_t v = 0; v < moved.after.size(); ++v) moved.after[v].x += 0.01f * static_cast<float>(v % 7);
  const auto encoded = document->encode_same(moved.view(), {}, kRun);
  ASSERT_TRUE(encoded.ok());
  const auto again = decoded(encoded->bytes);
  for (std::size_t ring = 0; ring + 1 < kRings; ++ring) {
    const std::size_t first = ring * (kSegments + 1);
    EXPECT_EQ(again->positions()[first], again->positions()[first + kSegments]);
  }
}

TEST(Draco, OptionsChooseMethodAndBits) {
  const auto document = decoded(write_with_library(*seamed_sphere(), {.position_bits = 10}));
  const Moved moved(*document);
  OutputOptions options;
  options.draco.method = DracoMethod::Edgebreaker;
  options.draco.position_bits = 0;
  auto encoded = document->encode_same(moved.view(), options, kRun);
  ASSERT_TRUE(encoded.ok());
  EXPECT_EQ(encoded->draco_method, DracoMethod::Edgebreaker);
  EXPECT_EQ(encoded->position_bits, 0);
  EXPECT_EQ(encoded->quantisation_error, 0);
  options.draco.position_bits = 16;
  encoded = document->encode_same(moved.view(), options, kRun);
  ASSERT_TRUE(encoded.ok());
  EXPECT_EQ(encoded->position_bits, 16);
  EXPECT_LE(encoded->quantisation_error, 2.0 / 65535);
}

TEST(Draco, OptionsOutOfRangeAreNamed) {
  const auto document = decoded(write_with_library(*seamed_sphere(), {}));
  const Moved moved(*document);
  const std::pair<const char*, DracoOptions> rows[] = {{"position_bits", {.position_bits = 31}},
                                                       {"position_bits", {.position_bits = -1}},
                                                       {"normal_bits", {.normal_bits = 1}},
                                                       {"speed", {.speed = 11}}};
  for (const auto& [field, draco] : rows) {
    OutputOptions options;
    options.draco = draco;
    const auto encoded = document->encode_same(moved.view(), options, kRun);
    ASSERT_FALSE(encoded.ok());
    EXPECT_EQ(encoded.error().cause, Cause::BadOption);
    EXPECT_EQ(encoded.error().field, field);
  }
}

TEST(Draco, NormalsFollowTheSurfaceOnlyWhereItMoved) {
  for (const int bits : {0, 10}) {
    const std::string bytes = write_with_library(*seamed_sphere(), {.normal_bits = bits});
    const auto document = decoded(bytes);
    Moved moved(*document);
    constexpr Index kPoint = 4 * (kSegments + 1);  // on the seam
    moved.after[moved.surface.weld[kPoint]] *= 1.2f;
    const auto encoded = document->encode_same(moved.view(), {}, kRun);
    ASSERT_TRUE(encoded.ok());
    const auto before = read_with_library(bytes), after = read_with_library(encoded->bytes);
    std::set<Index> touched;
    for (const Triangle& t : document->triangles()) {
      if (std::ranges::any_of(t, [&](Index p) { return moved.view().moved(p); }))
        touched.insert(t.begin(), t.end());
    }
    for (Index p = 0; p < before->num_points(); ++p) {
      // A seam point's twin sees the same triangles, whichever side of the seam they are on.
      const Index ring = p / (kSegments + 1), segment = p % (kSegments + 1);
      const Index twin = segment == 0 ? p + kSegments : segment == kSegments ? ring * (kSegments + 1) : p;
      const auto now = at_point(*after, DracoAttribute::NORMAL, p);
      EXPECT_EQ(now, at_point(*after, DracoAttribute::NORMAL, twin)) << p;
      if (!touched.contains(p) && !touched.contains(twin)) {
        EXPECT_EQ(now, at_point(*before, DracoAttribute::NORMAL, p)) << p;
      }
    }
    const auto a = at_point(*before, DracoAttribute::NORMAL, kPoint + 1);
    const auto b = at_point(*after, DracoAttribute::NORMAL, kPoint + 1);
    EXPECT_GT(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]), 0.05);
  }
}

TEST(Draco, SharedAttributesAreWhatAnObjCanHold) {
  const auto document = decoded(write_with_library(*seamed_sphere(), {}));
  const auto shared = document->shared_attributes(Moved(*document).view(), kRun);
  ASSERT_TRUE(shared.ok());
  ASSERT_TRUE(shared->normals && shared->texture_coordinates);
  EXPECT_EQ(shared->normals->components, 3);
  EXPECT_EQ(shared->normals->corners.size(), document->triangles().size());
  EXPECT_EQ(shared->texture_coordinates->components, 2);
  const Triangle first = document->triangles()[0];
  const Index row = shared->texture_coordinates->corners[0][1];
  EXPECT_EQ(shared->texture_coordinates->values[2 * row], 0.0f);
  EXPECT_EQ(shared->texture_coordinates->values[2 * row + 1], 2.0f / kRings);
  ASSERT_EQ(shared->colors.size(), 3 * document->positions().size());
  EXPECT_EQ(shared->colors[3 * first[1]], 20.0f / 255);
  EXPECT_EQ(shared->colors[3 * first[1] + 2], 1.0f);
  EXPECT_EQ(shared->dropped, (std::vector<std::string>{"generic attribute 31 (1 component)", "metadata"}));
}

TEST(Draco, IntegersThatSpanAllOfThirtyTwoBitsSurvive) {
  // The library's default coding of these takes 8 GiB or cannot be read again.
  for (const auto method : kMethods) {
    auto mesh = seamed_sphere();
    std::vector<std::int32_t> ids(mesh->num_points());
    for (std::size_t p = 0; p < ids.size(); ++p) ids[p] = static_cast<std::int32_t>(0x9E3779B9u * (p + 1));
    const int id = add_point_attribute(*mesh, DracoAttribute::GENERIC, draco::DT_INT32, 1, false, ids);
    draco::ExpertEncoder encoder(*mesh);
    encoder.SetEncodingMethod(method == DracoMethod::Sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                                                : draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetUseBuiltInAttributeCompression(false);
    ASSERT_TRUE(encoder.SetAttributePredictionScheme(id, draco::PREDICTION_NONE).ok());
    draco::EncoderBuffer buffer;
    ASSERT_TRUE(encoder.EncodeToBuffer(&buffer).ok());

    const auto document = decoded({buffer.data(), buffer.size()});
    const auto encoded = document->encode_same(Moved(*document).view(), {}, kRun);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    const auto again = read_with_library(encoded->bytes);
    const draco::PointAttribute* read = again->GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
    ASSERT_NE(read, nullptr);
    std::multiset<std::int32_t> found;
    for (draco::PointIndex p(0); p < again->num_points(); ++p) {
      std::int32_t value = 0;
      read->GetMappedValue(p, &value);
      found.insert(value);
    }
    EXPECT_EQ(found, std::multiset<std::int32_t>(ids.begin(), ids.end()));
  }
}

TEST(Draco, StopEndsTheEncoding) {
  const auto document = decoded(write_with_library(*seamed_sphere(), {}));
  const Moved moved(*document);
  std::stop_source stop;
  stop.request_stop();
  const RunControl stopped{.stop = stop.get_token()};
  const auto same = document->encode_same(moved.view(), {}, stopped);
  ASSERT_FALSE(same.ok());
  EXPECT_EQ(same.error().cause, Cause::Cancelled);
  EXPECT_FALSE(document->shared_attributes(moved.view(), stopped).ok());
}

}  // namespace
}  // namespace burnish::testing
