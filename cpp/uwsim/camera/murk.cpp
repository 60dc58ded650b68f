#include "uwsim/camera/murk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "uwsim/camera/particles.h"

namespace uwsim {
namespace {

constexpr double kVisible = 1e-3;  // optical depth below which a cloud is left out
constexpr double kFar_m = 1e4;     // of a ray that meets nothing

float root_luminance(const camera::RadiancePlanes& radiance, int at) {
  return std::sqrt(
      std::max(0.0f, 0.2126f * radiance.red[at] + 0.7152f * radiance.green[at] + 0.0722f * radiance.blue[at]));
}

}  // namespace

std::vector<SedimentCloud> clouds_in_sight(const PictureRequest& request, const camera::View& view) {
  if (!view.camera_in_water || !request.effects.has(Effect::kSediment)) return {};
  std::vector<SedimentCloud> clouds = request.clouds.all;
  const Eigen::Vector3d& eye = request.world_from_camera.position_m;
  std::stable_sort(clouds.begin(), clouds.end(), [&](const auto& a, const auto& b) {
    return (a.middle_m - eye).squaredNorm() > (b.middle_m - eye).squaredNorm();
  });
  return clouds;
}

double draw_murk(const CameraScene& scene, const PictureRequest& request, std::span<const SedimentCloud> clouds,
                 std::span<const float> depth_m, const camera::View& view, int row,
                 const camera::RadiancePlanes& radiance) {
  const double extinction_m2_kg = request.clouds.sediment.extinction_m2_kg();
  const Eigen::Vector3d& eye = request.world_from_camera.position_m;
  const camera::Material& bed = scene.materials().front();
  const std::array<float, 3> albedo = {bed.base[0], bed.base[1], bed.base[2]};
  const Eigen::Map<const Eigen::Vector3f> right(view.right), down(view.down), ahead(view.ahead);
  double change = 0;
  for (int at = row * view.width; at < (row + 1) * view.width; ++at) {
    const Eigen::Vector3d ray = (view.ray_x[at] * right + view.ray_y[at] * down + ahead).cast<double>();
    const double per_depth = ray.norm(), depth = static_cast<double>(depth_m[static_cast<std::size_t>(at)]);
    const Eigen::Vector3d direction = ray / per_depth;
    const double length_m = std::isfinite(depth) ? depth * per_depth : kFar_m;
    const float before = root_luminance(radiance, at);
    for (const SedimentCloud& cloud : clouds) {
      const double thickness = extinction_m2_kg * cloud.column_kg_m2(eye, direction, length_m);
      if (thickness < kVisible) continue;
      const double densest_m = std::min(cloud.passage(eye, direction).densest_m, length_m);
      const std::array<float, 3> light = light_on((densest_m * direction).cast<float>(), albedo, view);
      const auto left = static_cast<float>(std::exp(-thickness));
      radiance.red[at] = left * radiance.red[at] + (1 - left) * light[0];
      radiance.green[at] = left * radiance.green[at] + (1 - left) * light[1];
      radiance.blue[at] = left * radiance.blue[at] + (1 - left) * light[2];
    }
    change += static_cast<double>(root_luminance(radiance, at) - before);
  }
  return change;
}

}  // namespace uwsim
