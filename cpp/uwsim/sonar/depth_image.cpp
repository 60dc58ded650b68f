#include "uwsim/sonar/depth_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

constexpr float kEmpty = std::numeric_limits<float>::infinity();
constexpr double kMaxPixels = 1 << 26;
constexpr double kSameSurface = 0.1;  // largest relative difference between pixels that are interpolated

/// Offset of a pixel's centre from the optical axis at depth 1: positive to the left for columns, upwards for rows.
double offset_of(int index, int count, double fov_rad) {
  return std::tan(fov_rad / 2) * (1 - 2 * (index + 0.5) / count);
}

float quantised(double depth_m, const DepthCamera& camera) {
  if (!(depth_m < camera.range_max_m)) return kEmpty;
  if (camera.depth_bits == 0) return static_cast<float>(depth_m);
  const double steps = std::ldexp(1.0, camera.depth_bits) - 1;
  return static_cast<float>(std::round(depth_m / camera.range_max_m * steps) / steps * camera.range_max_m);
}

/// Reduces a column to a single range. `tangent`: the tangent of the column's angle.
double column_range(const DepthImage& image, int column, RowReduction reduction, double tangent) {
  const DepthCamera& camera = image.camera;
  const auto depth = [&](int row) {
    return double{image.depth_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.width) +
                                static_cast<std::size_t>(column)]};
  };
  if (reduction == RowReduction::kMiddle) return depth((camera.height - 1) / 2) * std::hypot(1, tangent);
  double nearest = std::numeric_limits<double>::infinity();
  for (int row = 0; row < camera.height; ++row) {
    const double up = offset_of(row, camera.height, camera.vertical_fov_rad);
    nearest = std::min(nearest, depth(row) * std::sqrt(1 + tangent * tangent + up * up));
  }
  return nearest;
}

}  // namespace

void DepthCamera::check() const {
  require(width >= 1 && width <= 65536, "camera.width", width, "must be in [1, 65536] pixels");
  require(height >= 1 && height <= 65536, "camera.height", height, "must be in [1, 65536] pixels");
  require(1.0 * width * height <= kMaxPixels, "camera.height", height, "times width must be at most 67108864 pixels");
  for (const auto& [fov, name] : {std::pair{horizontal_fov_rad, "camera.horizontal_fov_rad"},
                                  std::pair{vertical_fov_rad, "camera.vertical_fov_rad"}}) {
    require(fov > 0 && fov <= 3.1, name, fov,
            "must be in (0, 3.1] rad: a pinhole camera sees less than half of a turn");
  }
  require(range_max_m >= 0.1 && range_max_m <= 1e4, "camera.range_max_m", range_max_m, "must be in [0.1, 1e4] m");
  require(depth_bits >= 0 && depth_bits <= 32, "camera.depth_bits", depth_bits, "must be in [0, 32]");
}

DepthImage depth_image(const DepthCamera& camera, const RayScene& scene, const Pose& world_from_camera, int threads) {
  camera.check();
  const auto width = static_cast<std::size_t>(camera.width), height = static_cast<std::size_t>(camera.height);
  DepthImage image{camera, std::vector<float>(width * height, kEmpty)};
  if (world_from_camera.position_m.z() > 0) return image;
  const Eigen::Matrix3d rotation = world_from_camera.rotation();
  const auto render_row = [&](std::size_t row, std::vector<Ray>& rays, std::vector<RayHit>& hits,
                              std::vector<double>& lengths) {
    const double up = offset_of(static_cast<int>(row), camera.height, camera.vertical_fov_rad);
    for (std::size_t k = 0; k < width; ++k) {
      const double left = offset_of(static_cast<int>(k), camera.width, camera.horizontal_fov_rad);
      lengths[k] = std::sqrt(1 + left * left + up * up);
      rays[k] = {world_from_camera.position_m, rotation * Eigen::Vector3d(1, left, up) / lengths[k]};
    }
    const double longest = *std::max_element(lengths.begin(), lengths.end());
    scene.cast(rays, camera.range_max_m * longest, hits);
    for (std::size_t k = 0; k < width; ++k) {
      const double z = world_from_camera.position_m.z() + hits[k].distance_m * rays[k].direction_world.z();
      if (z <= 0) image.depth_m[row * width + k] = quantised(hits[k].distance_m / lengths[k], camera);
    }
  };
  parallel_ranges(
      height, threads,
      [&](std::size_t first, std::size_t last) {
        std::vector<Ray> rays(width);
        std::vector<RayHit> hits(width);
        std::vector<double> lengths(width);
        for (std::size_t row = first; row < last; ++row) render_row(row, rays, hits, lengths);
      },
      1 + 4096 / width);
  return image;
}

std::vector<float> depth_image_ranges(const DepthImage& image, std::span<const double> angles_rad,
                                      RowReduction reduction, bool interpolate) {
  const DepthCamera& camera = image.camera;
  const double edge = std::tan(camera.horizontal_fov_rad / 2);
  const auto range_at = [&](double angle_rad) {
    const double tangent = std::tan(angle_rad);
    if (!(std::abs(angle_rad) < std::numbers::pi / 2) || std::abs(tangent) > edge * (1 + 1e-12)) return kEmpty;
    const double place = (1 - tangent / edge) / 2 * camera.width;  // in pixels from the left border
    const int pixel = std::clamp(static_cast<int>(std::floor(place)), 0, camera.width - 1);
    double range = column_range(image, pixel, reduction, tangent);
    const double from_middle = place - (pixel + 0.5);
    const int other = pixel + (from_middle < 0 ? -1 : 1);
    if (interpolate && other >= 0 && other < camera.width) {
      const double beside = column_range(image, other, reduction, tangent);
      const double weight = std::abs(from_middle);
      if (std::abs(beside - range) < kSameSurface * range) range = 1 / ((1 - weight) / range + weight / beside);
    }
    return range < camera.range_max_m ? static_cast<float>(range) : kEmpty;
  };
  std::vector<float> ranges;
  ranges.reserve(angles_rad.size());
  for (const double angle : angles_rad) ranges.push_back(range_at(angle));
  return ranges;
}

}  // namespace uwsim
