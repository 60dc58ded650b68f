#include "uwsim/rays/embree_cast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_terrain.h"
#include "uwsim/rays/ray_lanes.h"

namespace uwsim {
namespace {

static_assert(kNoGeometry == RTC_INVALID_GEOMETRY_ID);

constexpr float kLargest = std::numeric_limits<float>::max();

/// The context that Embree passes to callbacks: Embree's own part, followed by the details of the cast.
struct CastContext {
  RTCRayQueryContext embree = embree::new_context();
  CastDetail detail;

  explicit CastContext(const CastDetail& of_rays) : detail(of_rays) {
    static_assert(offsetof(CastContext, detail) == sizeof(RTCRayQueryContext));
  }
};

void make_idle_lanes_finite(const std::int32_t* active, RTCRay16& rays) {
  std::int32_t all = -1;
  for (std::size_t k = 0; k < kPacketRays; ++k) all &= active[k];
  if (all == -1) return;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const bool idle = active[k] == 0;
    rays.org_x[k] = idle ? 0.0f : rays.org_x[k];
    rays.org_y[k] = idle ? 0.0f : rays.org_y[k];
    rays.org_z[k] = idle ? 0.0f : rays.org_z[k];
    rays.dir_x[k] = idle ? 0.0f : rays.dir_x[k];
    rays.dir_y[k] = idle ? 0.0f : rays.dir_y[k];
    rays.dir_z[k] = idle ? 1.0f : rays.dir_z[k];
    rays.tnear[k] = idle ? 0.0f : rays.tnear[k];
    rays.tfar[k] = idle ? 0.0f : rays.tfar[k];
  }
}

/// Returns the end of a float ray, which is slightly farther than the true end.
float farther(double far_m) {
  const double farther_m = far_m * (1 + kFartherRelative) + kFarther_m;
  return farther_m < kLargest ? static_cast<float>(farther_m) : kLargest;
}

void fill(const TileSurfaces& surfaces, const ExactRays& rays, const double* starts_m, RTCRayHit16& packet) {
  static const RayKernels& kernels = ray_kernels();
  const Eigen::Vector3d& middle = surfaces.middle_m();
  const double setback_m = surfaces.tolerances().setback_m;
  kernels.to_float(lanes_of(rays), middle.data(), setback_m,
                   {packet.ray.org_x, packet.ray.org_y, packet.ray.org_z, packet.ray.dir_x, packet.ray.dir_y,
                    packet.ray.dir_z, packet.ray.tfar});
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    packet.ray.tnear[k] = 0;
    packet.ray.time[k] = 0;
    packet.ray.mask[k] = ~0u;
    packet.ray.id[k] = static_cast<unsigned>(k);
    packet.ray.flags[k] = 0;
    packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
  if (starts_m == nullptr) return;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    const double start_m = starts_m[k] - setback_m;
    packet.ray.org_x[k] = static_cast<float>(rays.origin_x[k] + start_m * rays.direction_x[k] - middle.x());
    packet.ray.org_y[k] = static_cast<float>(rays.origin_y[k] + start_m * rays.direction_y[k] - middle.y());
    packet.ray.org_z[k] = static_cast<float>(rays.origin_z[k] + start_m * rays.direction_z[k] - middle.z());
    packet.ray.tfar[k] = farther(rays.far_m[k] - start_m);
  }
}

/// Copies Embree's answer and replaces quads by triangles.
void read(const RTCRayHit16& packet, const TileSurfaces& surfaces, FloatAnswer& answer) {
  static const RayKernels& kernels = ray_kernels();
  const int kinds = kernels.number_terrain({packet.hit.geomID, packet.hit.primID, packet.hit.u, packet.hit.v},
                                           TileSurfaces::kTerrainNearSolids, TileSurfaces::kOpenTerrain,
                                           answer.primitive.data(), answer.terrain);
  answer.any_terrain = kinds != 0;
  const bool any_near_solids = (kinds & 1) != 0;
  for (std::size_t k = 0; any_near_solids && k < kPacketRays; ++k) {
    if (packet.hit.geomID[k] != TileSurfaces::kTerrainNearSolids) continue;
    answer.terrain.triangle[k] = surfaces.block_triangle(answer.primitive[k]);
    answer.terrain.on_terrain[k] = -1;
  }
  std::copy_n(packet.hit.geomID, kPacketRays, answer.geometry.begin());
  std::copy_n(packet.ray.tfar, kPacketRays, answer.distance_m.begin());
}

/// Returns the distance from a lane's origin at which its float ray starts.
double float_start_m(const TileSurfaces& surfaces, const double* starts_m, std::size_t lane) {
  return (starts_m != nullptr ? starts_m[lane] : 0) - surfaces.tolerances().setback_m;
}

}  // namespace

void cast_in_float(RTCScene tree, const TileSurfaces& surfaces, const ExactRays& rays, const double* starts_m,
                   FloatAnswer& answer) {
  RTCRayHit16 packet;
  fill(surfaces, rays, starts_m, packet);
  make_idle_lanes_finite(rays.active.data(), packet.ray);
  intersect(tree, {&surfaces, &rays, starts_m, surfaces.tolerances().setback_m, &answer.round}, RayOrder::kCoherent,
            rays.active.data(), packet);
  read(packet, surfaces, answer);
}

std::optional<Candidate> candidate_of(const FloatAnswer& answer, const TileSurfaces& surfaces, const double* starts_m,
                                      std::size_t lane) {
  if (answer.geometry[lane] == kNoGeometry) return {};
  return Candidate{answer.geometry[lane], answer.primitive[lane],
                   float_start_m(surfaces, starts_m, lane) + double{answer.distance_m[lane]}};
}

std::optional<Candidate> next_candidate(RTCScene tree, const TileSurfaces& surfaces, const ExactRays& rays,
                                        std::size_t lane, const TileRay& ray, double from_m, const double* starts_m) {
  const double start_m = float_start_m(surfaces, starts_m, lane);
  const Eigen::Vector3f start =
      (ray.origin_world_m + start_m * ray.direction_world - surfaces.middle_m()).cast<float>();
  const Eigen::Vector3f direction = ray.direction_world.cast<float>();
  RTCRayHit one;
  one.ray = {.org_x = start.x(),
             .org_y = start.y(),
             .org_z = start.z(),
             .tnear = std::nextafter(static_cast<float>(from_m - start_m), kLargest),
             .dir_x = direction.x(),
             .dir_y = direction.y(),
             .dir_z = direction.z(),
             .time = 0,
             .tfar = farther(ray.far_m - start_m),
             .mask = ~0u,
             .id = static_cast<unsigned>(lane),
             .flags = 0};
  one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  CastContext context({&surfaces, &rays, starts_m, surfaces.tolerances().setback_m});
  embree::intersect(tree, context.embree, one);
  if (one.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const std::uint32_t member = member_number(one.hit.geomID, one.hit.primID, one.hit.u, one.hit.v);
  return Candidate{one.hit.geomID, member, start_m + double{one.ray.tfar}};
}

const ExactRays& LazyExactRays::get() {
  if (made_) return exact_;
  made_ = true;
  for (std::size_t k = 0; k < kPacketRays; ++k) {
    set_ray(exact_, k, anchor_world_m_ + origin_of(rays_, k), direction_of(rays_, k).normalized(), rays_.far_m[k],
            rays_.active[k] != 0);
  }
  return exact_;
}

const CastDetail& detail_of(const void* context) { return static_cast<const CastContext*>(context)->detail; }

void intersect(RTCSceneTy* tree, const CastDetail& detail, RayOrder order, const std::int32_t* active,
               RTCRayHit16& packet) {
  CastContext context(detail);
  embree::intersect(active, tree, context.embree, order == RayOrder::kCoherent, packet);
}

void occluded(RTCSceneTy* tree, const CastDetail& detail, RayOrder order, const std::int32_t* active,
              RTCRay16& packet) {
  CastContext context(detail);
  embree::occluded(active, tree, context.embree, order == RayOrder::kCoherent, packet);
}

}  // namespace uwsim
