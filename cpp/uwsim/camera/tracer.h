#pragma once

#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/picture_request.h"

namespace uwsim {

/// Casts a block's rays through the world and the vehicles' hulls.
class Tracer {
 public:
  Tracer(const CameraScene& scene, const Eigen::Vector3d& anchor_world_m, const PictureRequest& request);

  /// How far rays are cast unless there is a reason for less.
  static const camera::BlockFloats& everywhere();

  /// Casts rays of length `far_m`. Sets distance, normal, label and primitive of active lanes; inactive lanes hit
  /// nothing. u and v are stored in `hits`.
  void cast(camera::Block& block, const camera::BlockFloats& far_m, HitPacket& hits, RayOrder order) const;
  /// Recomputes inexact distances to solids and vehicles in double precision: on the plane of the triangle that was hit
  /// or, for vehicles and round shapes, by another cast. Terrain is refined by the kernels (kernels/hits.h).
  void refine(const HitPacket& hits, camera::Block& block) const;
  /// Marks the lanes that need a shadow ray and whose light is blocked.
  void occluded(const camera::Block& block, camera::BlockMask& blocked, RayOrder order) const;

 private:
  void record(const RayPacket& rays, RayOrder order, int kind) const;
  void recast(const camera::BlockMask& lanes, camera::Block& block) const;

  const World& world_;
  RayScene rays_;
  RayRecord* record_;
  Eigen::Vector3d anchor_world_m_;
};

}  // namespace uwsim
