#include "client/render/ray_scene.h"

#include <embree3/rtcore.h>

#include <cstddef>
#include <limits>
#include <new>
#include <string>

namespace burnish::render {

/// Embree's handles.
struct RayScene::Library {
  Library() = default;
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    if (all_threads != nullptr) rtcReleaseDevice(all_threads);
  }

  /// One thread and one instruction set: the same hierarchy, the same hits, the same bytes everywhere.
  RTCDevice device = rtcNewDevice("threads=1,isa=sse2");
  /// The first device holds all of oneTBB to one thread, until there is a second that asks for more.
  RTCDevice all_threads = nullptr;
  RTCScene scene = rtcNewScene(device);
};

namespace {

/// A buffer of the geometry, whose memory is Embree's.
template <class T>
T* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
  return static_cast<T*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count));
}

RTCRay ray(const Vec3f& from, const Vec3f& towards, float reach) {
  RTCRay r{};
  r.org_x = from.x, r.org_y = from.y, r.org_z = from.z;
  r.dir_x = towards.x, r.dir_y = towards.y, r.dir_z = towards.z;
  r.tfar = reach;
  r.mask = ~0U;
  return r;
}

}  // namespace

Result<RayScene> RayScene::build(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                 const Camera& camera) {
  RayScene result;
  const auto library = std::make_shared<Library>();
  if (library->device == nullptr) return Error{Cause::Internal, "Embree does not start on this processor"};
  RTCGeometry geometry = rtcNewGeometry(library->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* const points =
      new_buffer<Vec3f>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions.size());
  auto* const corners =
      new_buffer<Triangle>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles.size());
  if (points != nullptr && corners != nullptr) {
    for (std::size_t v = 0; v < positions.size(); ++v) {
      points[v] = to_float((positions[v] - camera.centre) * (1 / camera.radius));
    }
    std::copy(triangles.begin(), triangles.end(), corners);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(library->scene, geometry);
    rtcSetSceneFlags(library->scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(library->scene);
    library->all_threads = rtcNewDevice("isa=sse2");
  }
  rtcReleaseGeometry(geometry);
  switch (rtcGetDeviceError(library->device)) {
    case RTC_ERROR_NONE:
      break;
    case RTC_ERROR_OUT_OF_MEMORY:
      return Error{Cause::OutOfMemory, "the picture needs more memory than there is"};
    default:
      return Error{Cause::Internal, "Embree cannot take the mesh"};
  }
  result.library_ = library;
  return result;
}

std::optional<RayScene::Hit> RayScene::first(const Vec3f& from, const Vec3f& towards) const {
  RTCRayHit both{.ray = ray(from, towards, std::numeric_limits<float>::infinity()), .hit = {}};
  both.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(library_->scene, &context, &both);
  if (both.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return Hit{
      both.hit.primID, both.hit.u, both.hit.v, both.ray.tfar, {both.hit.Ng_x, both.hit.Ng_y, both.hit.Ng_z}};
}

bool RayScene::blocked(const Vec3f& from, const Vec3f& towards, float reach) const {
  RTCRay r = ray(from, towards, reach);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(library_->scene, &context, &r);
  return r.tfar < 0;
}

}  // namespace burnish::render
