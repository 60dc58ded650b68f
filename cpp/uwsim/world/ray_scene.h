#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "uwsim/world/ray_packet.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A half line from `origin_world_m` along the unit vector `direction_world`.
struct Ray {
  Eigen::Vector3d origin_world_m;
  Eigen::Vector3d direction_world;
};

struct RayHit {
  double distance_m;             ///< infinity where nothing was met within range
  Eigen::Vector3f normal_world;  ///< unit, of the triangle's winding side
  Label label;
};

/// The world's surfaces as Embree sees them: ROBUST, in float about the world's middle; the distance to the triangle
/// that Embree names is solved again in double. It holds what is fixed: vehicles collide with each other but do not
/// echo. Safe to use from several threads at once.
class RayScene {
 public:
  explicit RayScene(const World& world);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// hits[k] is where rays[k] first meets a surface within `max_range_m`. Same result whatever the number of threads.
  void cast(std::span<const Ray> rays, double max_range_m, std::span<RayHit> hits, int threads = 1) const;
  RayHit cast(const Ray& ray, double max_range_m) const;

  /// The bare float cast, for pictures: at the cost of the ray tree itself. Distances err by some 1e-4 m.
  void cast(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays, HitPacket& hits,
            RayOrder order = RayOrder::kIncoherent) const;
  /// blocked[k] is -1 where something lies on the ray between near_m and far_m, else 0; idle lanes are 0.
  void occluded(const Eigen::Vector3d& anchor_world_m, const RayPacket& rays,
                std::array<std::int32_t, kPacketRays>& blocked, RayOrder order = RayOrder::kIncoherent) const;

  /// Distance from each point to the nearest surface, exact to double rounding; infinity in an empty world.
  void distance(std::span<const Eigen::Vector3d> points_world_m, std::span<double> distances_m, int threads = 1) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
