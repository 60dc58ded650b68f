#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>

#include "uwsim/rays/ray_packet.h"
#include "uwsim/rays/tiling.h"

struct RTCDeviceTy;

namespace uwsim {

struct TileTrees;

/// A piece of the world, at most about 1 km wide, as a target for rays: first in float by Embree, relative to the
/// piece's own middle, and then in double (exact_cast.cpp). README.md describes the path of a ray and the error budget.
class RayTile {
 public:
  /// Throws InvalidValue if Embree cannot build its tree.
  RayTile(RTCDeviceTy* device, const World& world, TileContents contents);
  ~RayTile();
  RayTile(RayTile&&) noexcept;
  RayTile& operator=(RayTile&&) noexcept;

  /// Bounds of the surfaces, including the margins that the tolerances add.
  const Eigen::AlignedBox3d& box() const;
  /// Whether rays from this point may be cast in float directly; other rays must start where they enter the box.
  bool is_near(const Eigen::Vector3d& point_world_m) const;
  bool is_near(std::span<const ExactRays> rays) const;

  /// Finds the true first hits in this tile, for rays that start `starts_m` along their direction (at 0 if null).
  void cast(const ExactRays& rays, const double* starts_m, ExactHits& hits) const;
  /// The same for packets whose rays are near (see is_near) and start at 0; casting several packets together is faster.
  void cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const;
  /// Returns Embree's unrefined answers, with distances from the rays' origins. `starts_m`: see above.
  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m, HitPacket& hits,
            RayOrder order) const;
  void occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, const double* starts_m, Blocked& blocked,
                RayOrder order) const;
  /// The smaller of `nearest_m` and the distance to the nearest triangle, in double; solids are represented by their
  /// meshes.
  double distance(const Eigen::Vector3d& point_world_m, double nearest_m) const;

 private:
  std::unique_ptr<TileTrees> trees_;
};

}  // namespace uwsim
