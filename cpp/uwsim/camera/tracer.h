#pragma once

#include <vector>

#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/picture_request.h"

namespace uwsim {

/// Casts a block's rays through the world and the vehicles' hulls.
class Tracer {
 public:
  Tracer(const CameraScene& scene, const Eigen::Vector3d& anchor_world_m, const PictureRequest& request);

  /// Sets distance, normal, label and primitive of active lanes; inactive lanes hit nothing. `hits` keeps u and v.
  void cast(camera::Block& block, HitPacket& hits, RayOrder order) const;
  /// Solves distances to solids and vehicles again in double where they are not settled: on the plane of the triangle
  /// that was hit, or by another cast for vehicles and for round shapes. Terrain is refined by the kernels
  /// (kernels/hits.h).
  void refine(const HitPacket& hits, camera::Block& block) const;
  /// Sets the lanes that need a shadow ray and whose light is blocked.
  void occluded(const camera::Block& block, camera::BlockMask& blocked, RayOrder order) const;

 private:
  struct PlacedHull {
    const RayScene* rays;
    std::uint32_t label;
    Pose body_from_world;
    Eigen::Matrix3f body_from_world_rotation;
    Eigen::Vector3d anchor_body_m;
    Eigen::Vector3f centre_m;  // from the anchor, world axes
    float radius_m;
  };
  void record(const RayPacket& rays, RayOrder order, int kind) const;
  void refine_solids(const HitPacket& hits, camera::Block& block) const;
  void recast(const RayScene& scene, const camera::BlockMask& lanes, const PlacedHull* hull,
              camera::Block& block) const;
  static bool may_hit(const RayPacket& rays, const PlacedHull& hull);
  static RayPacket in_body_frame(const RayPacket& rays, const PlacedHull& hull);

  const World& world_;
  const RayScene& rays_;
  RayRecord* record_;
  Eigen::Vector3d anchor_world_m_;
  std::vector<PlacedHull> hulls_;
};

}  // namespace uwsim
