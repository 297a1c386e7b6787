// NearestTriangle beside Embree's point query, for docs/decisions/0006-nearest-triangle.md: same process,
// same thread, same points, same first bound, same triangle test, in turns, so that the ratio survives a
// noisy machine. Times are CPU milliseconds for the build and for one query per vertex.
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <type_traits>

#include "core/measure/nearest.h"
#include "tests/support/shapes.h"

namespace burnish::bench {
namespace {

/// Subdivision levels: 20480, 81920 and 327680 triangles.
constexpr int kLevels[] = {5, 6, 7};

/// What a query knows beforehand.
enum class Start {
  Corresponding,  ///< a triangle at the reference's vertex of the same number: a result against its input
  LastHit,        ///< the triangle that the previous vertex found: a reference of other connectivity
  None,           ///< always the first triangle
};
constexpr const char* kStartNames[] = {"corresponding", "last_hit", "none"};

struct Task {
  std::vector<Vec3f> points;  // of the clean sphere, in the reference's frame
  const Surface& reference;   // the noisy sphere
  Start start;

  Index first_triangle(std::size_t point, Index last_hit) const {
    if (start == Start::Corresponding) return reference.topology.vertex_faces[point].front();
    return start == Start::LastHit ? last_hit : 0;
  }
};

double cpu_milliseconds() { return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double distance_to(const Surface& surface, const Vec3d& point, Index triangle) {
  const auto& [a, b, c] = surface.mesh.triangles[triangle];
  const auto& positions = surface.mesh.positions;
  return squared_distance(point, to_double(positions[a]), to_double(positions[b]), to_double(positions[c]));
}

struct Times {
  double build = 0, query = 0;
  double total() const { return build + query; }
};

Times ask_ours(const Task& task, std::vector<double>& squared) {
  Times times;
  const double begin = cpu_milliseconds();
  const auto nearest =
      NearestTriangle::build(task.reference.mesh.positions, task.reference.mesh.triangles, {});
  const double built = cpu_milliseconds();
  Index last = 0;
  for (std::size_t i = 0; i < task.points.size(); ++i) {
    const auto hit = nearest->find(task.points[i], task.first_triangle(i, last));
    squared[i] = hit.squared_distance;
    last = hit.triangle;
  }
  return {built - begin, cpu_milliseconds() - built};
}

struct Best {
  const Surface& surface;
  double squared_distance;
  Index triangle;
};

bool closer(RTCPointQueryFunctionArguments* arguments) {
  Best& best = *static_cast<Best*>(arguments->userPtr);
  const RTCPointQuery& q = *arguments->query;
  const double candidate = distance_to(best.surface, {q.x, q.y, q.z}, arguments->primID);
  if (candidate >= best.squared_distance) return false;
  best.squared_distance = candidate;
  best.triangle = arguments->primID;
  arguments->query->radius = static_cast<float>(std::sqrt(candidate));
  return true;
}

using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)>;

Scene embree_scene(RTCDevice device, RTCBuildQuality quality, const Surface& surface) {
  Scene scene(rtcNewScene(device), rtcReleaseScene);
  rtcSetSceneBuildQuality(scene.get(), quality);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto& [positions, triangles, frame] = surface.mesh;
  // Embree's own buffer, because it reads 16 bytes per vertex, beyond the end of ours.
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(Vec3f), positions.size());
  std::copy(positions.begin(), positions.end(), static_cast<Vec3f*>(vertices));
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                             sizeof(Triangle), triangles.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  return scene;
}

Times ask_embree(const Task& task, RTCBuildQuality quality, std::vector<double>& squared) {
  static const Device device(rtcNewDevice("threads=1"), rtcReleaseDevice);
  const double begin = cpu_milliseconds();
  const Scene scene = embree_scene(device.get(), quality, task.reference);
  const double built = cpu_milliseconds();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  Index last = 0;
  for (std::size_t i = 0; i < task.points.size(); ++i) {
    const Vec3f& p = task.points[i];
    const Index first = task.first_triangle(i, last);
    Best best{task.reference, distance_to(task.reference, to_double(p), first), first};
    // Rounded up, so that the bound is never below the distance.
    const float radius = std::nextafter(static_cast<float>(std::sqrt(best.squared_distance)),
                                        std::numeric_limits<float>::max());
    RTCPointQuery query{p.x, p.y, p.z, 0, radius};
    rtcPointQuery(scene.get(), &query, &context, closer, &best);
    squared[i] = best.squared_distance;
    last = best.triangle;
  }
  return {built - begin, cpu_milliseconds() - built};
}

/// Embree prunes in float, so its answer may be another triangle that is as near up to float's rounding.
bool same_answers(const std::vector<double>& ours, const std::vector<double>& embrees) {
  for (std::size_t i = 0; i < ours.size(); ++i) {
    if (std::abs(std::sqrt(ours[i]) - std::sqrt(embrees[i])) > 1e-6) return false;
  }
  return true;
}

void compare(benchmark::State& state, Start start, int level, RTCBuildQuality quality) {
  const testing::Shape sphere = testing::sphere(level);
  const Surface reference = testing::surface_of(testing::with_noise(sphere, 0.2 * 1.2 / (1 << level)));
  Task task{{}, reference, start};
  for (const Vec3d& p : sphere.positions) task.points.push_back(reference.mesh.frame.to_local(p));
  std::vector<double> ours(task.points.size()), embrees(task.points.size());
  Times our_times, embree_times;
  for (auto _ : state) {
    const Times a = ask_ours(task, ours), b = ask_embree(task, quality, embrees);
    our_times.build += a.build, our_times.query += a.query;
    embree_times.build += b.build, embree_times.query += b.query;
  }
  if (!same_answers(ours, embrees)) state.SkipWithError("the two searches disagree");
  const auto mean = [](double sum) { return benchmark::Counter(sum, benchmark::Counter::kAvgIterations); };
  state.counters["our_build"] = mean(our_times.build);
  state.counters["our_queries"] = mean(our_times.query);
  state.counters["embree_build"] = mean(embree_times.build);
  state.counters["embree_queries"] = mean(embree_times.query);
  state.counters["embree_over_ours"] = embree_times.total() / our_times.total();
}

void register_all() {
  for (const Start start : {Start::Corresponding, Start::LastHit, Start::None}) {
    for (const int level : kLevels) {
      for (const auto& [quality_name, quality] :
           {std::pair{"low", RTC_BUILD_QUALITY_LOW}, std::pair{"medium", RTC_BUILD_QUALITY_MEDIUM}}) {
        const std::string name = std::string(kStartNames[static_cast<int>(start)]) +
                                 "/triangles:" + std::to_string(20 << 2 * level) + "/embree:" + quality_name;
        benchmark::RegisterBenchmark(name.c_str(), compare, start, level, quality)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
  burnish::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
