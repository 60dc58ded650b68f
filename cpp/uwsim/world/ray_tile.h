#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "uwsim/world/ray_packet.h"
#include "uwsim/world/tile_surfaces.h"

struct RTCDeviceTy;

namespace uwsim {

/// A piece of the world, some 1 km wide at most, as Embree sees it: ROBUST, in float about the piece's own middle.
///
/// Float errs by up to 1e-6 of the tile's size. So the terrain is handed to Embree raised by more than that, as a
/// whole: a ray from above that truly meets it has met its twin before. From there, or from its start where that does
/// not lie clearly above, the ray is followed in double, mostly to the triangle below. Each triangle of a solid is
/// widened: a ray that truly meets it meets its widened twin. It is solved again in double. Where the ray meets the
/// rim, or where other surfaces come near, everything within reach of the error is tried in double and the true first
/// hit taken; where there is none, the ray goes on behind it.
///
/// Rays are cast from a little before their start, so that float does not put them behind what they start close to;
/// what lies before the start does not count. Left to float's error, 1e-6 of half the tile's diagonal (which huge
/// triangles make longer), are rays that come to a surface at less than 0.1 degree.
class RayTile {
 public:
  /// Throws InvalidValue when Embree cannot build its tree.
  RayTile(RTCDeviceTy* device, const World& world, TileContents contents);
  ~RayTile();
  RayTile(RayTile&&) noexcept;
  RayTile& operator=(RayTile&&) noexcept;

  /// Bounds of what is inside, with room for float's error.
  const Eigen::AlignedBox3d& box() const;
  /// Whether rays from here may be cast in float as they are; others are to start where they enter the box.
  bool is_near(const Eigen::Vector3d& point_world_m) const;
  bool is_near(std::span<const ExactRays> rays) const;

  /// The true first hits in this tile of rays that start `start_m` along their way (at 0 when null).
  void cast(const ExactRays& rays, const double* start_m, ExactHits& hits) const;
  /// The same of packets that are near, at 0. Cast together they cost less: memory is asked for ahead of its use.
  void cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const;
  /// As Embree has them; `start_m` as above, distances count from the rays' origins.
  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* start_m, HitPacket& hits,
            RayOrder order) const;
  void occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* start_m, Blocked& blocked,
                RayOrder order) const;
  /// The least of `nearest_m` and the distance to the nearest triangle, in double; solids by their meshes.
  double distance(const Eigen::Vector3d& point_world_m, double nearest_m) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
