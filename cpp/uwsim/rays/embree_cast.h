#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/ray_packet.h"
#include "uwsim/rays/tile_surfaces.h"

struct RTCRay16;
struct RTCRayHit;
struct RTCRayHit16;
struct RTCSceneTy;

namespace uwsim {

// Rays in double precision, cast through Embree's tree in float.

/// Embree's answer to a packet of double-precision rays, with the tile's surface numbers.
struct FloatAnswer {
  alignas(64) std::array<std::uint32_t, kPacketRays> geometry, primitive;  ///< kNoGeometry if nothing was hit
  alignas(64) std::array<float, kPacketRays> distance_m;                   ///< from the start of the float ray
  TerrainLanes terrain;  ///< the terrain triangles that were hit; the location of their heights is found later
  bool any_terrain;
  ExactHits round;  ///< hits on round shapes, which Embree's callbacks compute in double; other lanes are uninitialised
};

/// The surface that Embree reports as a ray's first hit, with the distance from the ray's origin.
struct Candidate {
  std::uint32_t geometry, primitive;
  double distance_m;
};

/// Casts a packet of rays that start `starts_m` along their direction (0 if null). The rays passed to Embree start
/// earlier than that by the tile's setback.
void cast_in_float(RTCSceneTy* tree, const TileSurfaces& surfaces, const ExactRays& rays, const double* starts_m,
                   FloatAnswer& answer);

/// The candidate in one lane of the answer.
std::optional<Candidate> candidate_of(const FloatAnswer& answer, const TileSurfaces& surfaces, const double* starts_m,
                                      std::size_t lane);

/// Casts one lane again: returns the first candidate beyond `from_m` along the given ray, which may be shorter
/// than the lane's own ray.
std::optional<Candidate> next_candidate(RTCSceneTy* tree, const TileSurfaces& surfaces, const ExactRays& rays,
                                        std::size_t lane, const TileRay& ray, double from_m, const double* starts_m);

/// A double-precision copy of a picture's packet of float rays. It is created only when a callback first needs it,
/// since most packets hit no round shapes.
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

/// The context through which Embree's callbacks access their rays in double: ray `id` is lane `id` of `exact` and
/// starts `starts_m[id]` along its direction (0 if null). If both `exact` and `lazy` are null, only the float ray is
/// available.
struct CastDetail {
  const TileSurfaces* surfaces;
  const ExactRays* exact = nullptr;
  const double* starts_m = nullptr;
  double setback_m = 0;             ///< how far before that start the float ray starts
  ExactHits* round_hits = nullptr;  ///< if not null, receives each hit on a round shape in double, by lane
  /// Creates the rays in double when a round shape requires them; used if `exact` is null
  LazyExactRays* lazy = nullptr;
};

/// Returns the detail with which the cast was started, by the context that Embree passes to its callbacks.
const CastDetail& detail_of(const void* context);

/// Casts rays through a tree. The hit fields must be invalid beforehand, and idle lanes finite: without AVX-512, Embree
/// splits packets and reads idle lanes as well; Debian's build aborts the process if one of them is not finite.
void intersect(RTCSceneTy* tree, const CastDetail& detail, RayOrder order, const std::int32_t* active,
               RTCRayHit16& packet);
void occluded(RTCSceneTy* tree, const CastDetail& detail, RayOrder order, const std::int32_t* active, RTCRay16& packet);

}  // namespace uwsim
