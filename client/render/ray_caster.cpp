#include "client/render/ray_caster.h"

#include "core/run/parallel.h"

namespace burnish::render {

Result<> draw(Picture& picture, unsigned left, unsigned top, const Camera& camera, const Model& model,
              const Look& look, const RunControl& run) {
  const auto scene = RayScene::build(model.positions, model.triangles, camera);
  if (!scene) return scene.error();
  const Shader shader(model, look, camera, *scene);
  const auto width = static_cast<unsigned>(camera.width), height = static_cast<unsigned>(camera.height);
  const unsigned samples = look.samples * look.samples;
  const Light sky = to_light(look.background);
  const Vec3f towards = to_float(camera.axes.eye * -1.0), away = to_float(camera.axes.eye * 2.0);
  const auto pixel = [&](unsigned x, unsigned y) {
    Light sum;
    unsigned hits = 0;
    for (unsigned sample = 0; sample < samples; ++sample) {
      const double right = (sample % look.samples + 0.5) / look.samples;
      const double down = (sample / look.samples + 0.5) / look.samples;
      const Vec3f from = to_float(camera.at(x + right, y + down)) + away;
      const auto hit = scene->first(from, towards);
      if (!hit) continue;
      ++hits;
      sum += shader.at(*hit, from + towards * hit->distance, sample);
    }
    if (hits == 0) return look.background;
    return to_color((sum + sky * static_cast<float>(samples - hits)) * (1 / static_cast<float>(samples)));
  };
  const bool done = parallel_tasks(height, run, [&](std::size_t row) {
    const auto y = static_cast<unsigned>(row);
    for (unsigned x = 0; x < width && !run.stopped(); ++x) picture.at(left + x, top + y) = pixel(x, y);
  });
  if (!done || run.stopped()) return run.stop_error();
  return {};
}

}  // namespace burnish::render
