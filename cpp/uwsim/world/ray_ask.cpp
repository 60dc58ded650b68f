#include "uwsim/world/ray_ask.h"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>

#include "uwsim/world/ray_terrain.h"

namespace uwsim {
namespace {

constexpr float kFarthest = std::numeric_limits<float>::max();

/// A little farther: the exact limit is held to in double.
float far_of(double far_m) {
  const double farther = far_m * (1 + 1e-6) + 1e-6;
  return farther < kFarthest ? static_cast<float>(farther) : kFarthest;
}

}  // namespace

TileRay ray_of(const ExactRays& rays, std::size_t lane) {
  return {{rays.origin_x[lane], rays.origin_y[lane], rays.origin_z[lane]},
          {rays.direction_x[lane], rays.direction_y[lane], rays.direction_z[lane]},
          rays.far_m[lane]};
}

void fill_constants(RTCRayHit16& packet) {
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    packet.ray.tnear[k] = 0;
    packet.ray.time[k] = 0;
    packet.ray.mask[k] = ~0u;
    packet.ray.id[k] = static_cast<unsigned>(k);
    packet.ray.flags[k] = 0;
  }
}

void fill(const TileSurfaces& surfaces, const ExactRays& rays, const double* starts_m, RTCRayHit16& packet) {
  static const RayKernels& kernels = ray_kernels();
  const Eigen::Vector3d& middle = surfaces.middle_m();
  kernels.to_float(lanes_of(rays), middle.data(), surfaces.back_m(),
                   {packet.ray.org_x, packet.ray.org_y, packet.ray.org_z, packet.ray.dir_x, packet.ray.dir_y,
                    packet.ray.dir_z, packet.ray.tfar});
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
  if (starts_m == nullptr) return;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const double start_m = starts_m[k] - surfaces.back_m();
    packet.ray.org_x[k] = static_cast<float>(rays.origin_x[k] + start_m * rays.direction_x[k] - middle.x());
    packet.ray.org_y[k] = static_cast<float>(rays.origin_y[k] + start_m * rays.direction_y[k] - middle.y());
    packet.ray.org_z[k] = static_cast<float>(rays.origin_z[k] + start_m * rays.direction_z[k] - middle.z());
    packet.ray.tfar[k] = far_of(rays.far_m[k] - start_m);
  }
}

std::optional<Named> ask_one(RTCScene tree, const TileSurfaces& surfaces, const ExactRays& rays, std::size_t lane,
                             const TileRay& ray, double from_m, const double* starts_m) {
  const double start_m = (starts_m != nullptr ? starts_m[lane] : 0) - surfaces.back_m();
  const Eigen::Vector3f start =
      (ray.origin_world_m + start_m * ray.direction_world - surfaces.middle_m()).cast<float>();
  const Eigen::Vector3f way = ray.direction_world.cast<float>();
  RTCRayHit one;
  one.ray = {start.x(),
             start.y(),
             start.z(),
             std::nextafter(static_cast<float>(from_m - start_m), kFarthest),
             way.x(),
             way.y(),
             way.z(),
             0,
             far_of(ray.far_m - start_m),
             ~0u,
             static_cast<unsigned>(lane),
             0};
  one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  intersect(tree, {&surfaces, &rays, starts_m, surfaces.back_m()}, one);
  if (one.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const std::uint32_t member = member_number(one.hit.geomID, one.hit.primID, one.hit.u, one.hit.v);
  return Named{one.hit.geomID, member, start_m + double{one.ray.tfar}};
}

}  // namespace uwsim
