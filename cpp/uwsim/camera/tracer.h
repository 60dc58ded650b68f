#pragma once

#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/kernels/kernels.h"
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
  /// Computes points, distances and normals of the hits from the surfaces that were hit, in double precision: Embree's
  /// own, in single precision, depend on its instruction set.
  void locate_hits(const camera::View& view, const camera::Kernels& kernels, HitPacket& hits,
                   camera::Block& block) const;
  /// See RayScene::mesh_turn.
  Eigen::Matrix3f mesh_turn(Label label, std::uint32_t piece) const { return rays_.mesh_turn(label, piece); }
  /// A point relative to the anchor, in the frame of a solid's or a vehicle's mesh.
  Eigen::Vector3d on_mesh(Label label, const Eigen::Vector3f& point) const {
    return rays_.on_mesh(label, anchor_world_m_ + point.cast<double>());
  }
  /// Marks the lanes that need a shadow ray and whose light is blocked.
  void occluded(const camera::Block& block, camera::BlockMask& blocked, RayOrder order) const;

 private:
  void record(const RayPacket& rays, RayOrder order, int kind) const;
  void refine(HitPacket& hits, camera::Block& block) const;
  void recast(const camera::BlockMask& lanes, camera::Block& block) const;

  const World& world_;
  RayScene rays_;
  RayRecord* record_;
  Eigen::Vector3d anchor_world_m_;
};

}  // namespace uwsim
