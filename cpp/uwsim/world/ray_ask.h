#pragma once

#include <optional>

#include "uwsim/world/ray_geometry.h"

namespace uwsim {

/// What Embree says that a ray in double meets first. Distances count from the ray's origin.
struct Named {
  std::uint32_t geometry, primitive;
  double distance_m;
};

TileRay ray_of(const ExactRays& rays, std::size_t lane);

/// What Embree does not change, the same for all packets.
void fill_constants(RTCRayHit16& packet);
/// The rest, of rays that start `starts_m` along their way (0 when null); Embree gets them from the surfaces' `back_m`
/// before there, and counts distances from that.
void fill(const TileSurfaces& surfaces, const ExactRays& rays, const double* starts_m, RTCRayHit16& packet);

/// The first that lies beyond `from_m` on a lane's ray, which may end sooner than the lane's.
std::optional<Named> ask_one(RTCSceneTy* tree, const TileSurfaces& surfaces, const ExactRays& rays, std::size_t lane,
                             const TileRay& ray, double from_m, const double* starts_m);

}  // namespace uwsim
