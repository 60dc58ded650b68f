#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// Converts points to rays, one at a time, using OctoMap's arithmetic, operation by operation and with its types
/// (OccupancyOcTreeBase::computeUpdate, then OcTreeBaseImpl::computeRayKeys). Compiled into each scan_kernels_*.cpp
/// with internal linkage; only those files may include this one.
namespace uwsim::bricks {
namespace {

constexpr double kNeverCrosses = 1.7976931348623157e308;  ///< the largest double, as in OctoMap
constexpr float kGreatestFloat = 3.402823466e+38f;

struct RayEnd {
  float end_m[3];
  float direction[3];
  float length_m;
};

/// Computes the ray from `origin_m` to a point or, if the point is farther away than max_range_m, to that range along
/// the same line.
inline RayKind end_of_ray(const float point_m[3], const float origin_m[3], double max_range_m, RayEnd& ray) {
  const float dx = point_m[0] - origin_m[0], dy = point_m[1] - origin_m[1], dz = point_m[2] - origin_m[2];
  const float square = dx * dx + dy * dy + dz * dz;
  const double distance = __builtin_sqrt(static_cast<double>(square));
  const float delta[3] = {dx, dy, dz};
  if (max_range_m < 0 || distance <= max_range_m) {
    // A distance whose square is 0 in float is treated as 0, because OctoMap's own walk to such a point might not
    // terminate.
    for (int axis = 0; axis < 3; ++axis) ray.end_m[axis] = square == 0 ? origin_m[axis] : point_m[axis];
    ray.length_m = static_cast<float>(distance);
    for (int axis = 0; axis < 3; ++axis) ray.direction[axis] = delta[axis] / ray.length_m;
    return kHit;
  }
  const float norm = static_cast<float>(distance), reach = static_cast<float>(max_range_m);
  for (int axis = 0; axis < 3; ++axis) ray.end_m[axis] = origin_m[axis] + delta[axis] / norm * reach;
  const float ex = ray.end_m[0] - origin_m[0], ey = ray.end_m[1] - origin_m[1], ez = ray.end_m[2] - origin_m[2];
  const float truncated[3] = {ex, ey, ez};
  ray.length_m = static_cast<float>(__builtin_sqrt(static_cast<double>(ex * ex + ey * ey + ez * ez)));
  for (int axis = 0; axis < 3; ++axis) ray.direction[axis] = truncated[axis] / ray.length_m;
  return kTruncated;
}

/// The portable and the AVX2 version of Kernels::start_rays.
[[maybe_unused]] inline void start_rays(const ScanInput& scan, const Rays& rays) {
  const double factor = 1.0 / scan.resolution_m, resolution = scan.resolution_m;
  int origin_key[3];
  for (int axis = 0; axis < 3; ++axis) {
    origin_key[axis] = static_cast<int>(__builtin_floor(factor * static_cast<double>(scan.origin_m[axis]))) + 32768;
  }
  const float half = static_cast<float>(resolution * 0.5);  // rounded as in OctoMap
  for (std::size_t i = 0; i < scan.count; ++i) {
    float point_m[3];
    bool finite = true;
    for (int axis = 0; axis < 3; ++axis) {
      const float world_m = scan.points_world_m[3 * i + static_cast<std::size_t>(axis)];
      finite = finite && __builtin_fabsf(world_m) <= kGreatestFloat;
      point_m[axis] = static_cast<float>(static_cast<double>(world_m) - scan.tree_origin_world_m[axis]);
    }
    rays.steps[i] = 0;
    rays.kind[i] = kSkipped;
    for (int axis = 0; axis < 3; ++axis) rays.end_key[axis][i] = static_cast<std::uint16_t>(origin_key[axis]);
    if (!finite) continue;
    RayEnd ray;
    rays.kind[i] = end_of_ray(point_m, scan.origin_m, scan.max_range_m, ray);
    rays.length[i] = static_cast<double>(ray.length_m);
    std::uint32_t steps = 0, negative = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int key = static_cast<int>(__builtin_floor(factor * static_cast<double>(ray.end_m[axis]))) + 32768;
      rays.end_key[axis][i] = static_cast<std::uint16_t>(key);
      steps += static_cast<std::uint32_t>(key > origin_key[axis] ? key - origin_key[axis] : origin_key[axis] - key);
      const double direction = static_cast<double>(ray.direction[axis]);
      const double middle = (static_cast<double>(origin_key[axis] - 32768) + 0.5) * resolution;
      const double border = direction < 0 ? middle - static_cast<double>(half) : middle + static_cast<double>(half);
      const bool moves = direction > 0 || direction < 0;
      rays.next[axis][i] = moves ? (border - static_cast<double>(scan.origin_m[axis])) / direction : kNeverCrosses;
      rays.stride[axis][i] = moves ? resolution / __builtin_fabs(direction) : kNeverCrosses;
      negative |= static_cast<std::uint32_t>(direction < 0) << axis;
    }
    rays.steps[i] = steps;
    rays.negative[i] = static_cast<std::uint8_t>(negative);
  }
}

}  // namespace
}  // namespace uwsim::bricks
