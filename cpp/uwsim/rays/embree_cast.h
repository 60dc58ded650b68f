#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/ray_packet.h"
#include "uwsim/rays/tile_surfaces.h"

struct RTCIntersectContext;
struct RTCRay16;
struct RTCRayHit;
struct RTCRayHit16;
struct RTCSceneTy;

namespace uwsim {

// Rays in double, cast through Embree's tree in float.

/// Embree's answer to a packet of rays in double, using the tile's numbering of surfaces.
struct FloatAnswer {
  alignas(64) std::array<std::uint32_t, kPacketRays> geometry, primitive;  ///< kNoGeometry if nothing was hit
  alignas(64) std::array<float, kPacketRays> distance_m;                   ///< from the start of the float ray
  TerrainLanes terrain;  ///< its triangles; the location of their heights is found later
  bool any_terrain;
  ExactHits round;  ///< hits on round shapes, which Embree's callbacks solve in double; other lanes are uninitialised
};

/// The surface that Embree reports as the first hit of a ray. The distance is measured from the ray's origin.
struct Candidate {
  std::uint32_t geometry, primitive;
  double distance_m;
};

/// Casts a packet of rays that start `starts_m` along their direction (0 if null). Embree gets them from the tile's
/// setback before that point.
void cast_in_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const ExactRays& rays, const double* starts_m,
                   FloatAnswer& answer);

/// The candidate on one lane of the answer.
std::optional<Candidate> candidate_of(const FloatAnswer& answer, const TileSurfaces& surfaces, const double* starts_m,
                                      std::size_t lane);

/// Casts one lane again: the first candidate beyond `from_m` on the ray, which may end sooner than the lane's.
std::optional<Candidate> next_candidate(RTCSceneTy* tree, const TileSurfaces& surfaces, const ExactRays& rays,
                                        std::size_t lane, const TileRay& ray, double from_m, const double* starts_m);

/// A picture's packet of float rays in double, made when a callback first asks for it: most packets hit nothing round.
class LazyExactRays {
 public:
  LazyExactRays(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays)
      : anchor_world_m_(anchor_world_m), rays_(rays) {}
  bool made() const { return made_; }
  const ExactRays& get();

 private:
  const Eigen::Vector3d& anchor_world_m_;
  const RayPacket& rays_;
  bool made_ = false;
  ExactRays exact_;
};

/// The context that informs Embree's callbacks about their rays: lane `id` of `exact`, which starts `starts_m[id]`
/// along its direction (0 if null). If both `exact` and `lazy` are null, they only have the float ray.
struct CastDetail {
  const TileSurfaces* surfaces;
  const ExactRays* exact = nullptr;
  const double* starts_m = nullptr;
  double setback_m = 0;             ///< the distance before that start at which the float ray starts
  ExactHits* round_hits = nullptr;  ///< if not null, receives each hit on a round shape in double, by lane
  LazyExactRays* lazy = nullptr;    ///< used if `exact` is null: makes it when a round shape asks
};

/// The detail with which the cast was started.
const CastDetail& detail_of(const RTCIntersectContext* context);

/// Casts through a tree; the hit fields must be invalid before.
void intersect(RTCSceneTy* tree, const CastDetail& detail, RayOrder order, const std::int32_t* active,
               RTCRayHit16& packet);
void occluded(RTCSceneTy* tree, const CastDetail& detail, RayOrder order, const std::int32_t* active, RTCRay16& packet);

}  // namespace uwsim
