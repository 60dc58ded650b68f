#pragma once

#include <chrono>

#include "uwsim/camera/renderer.h"
#include "uwsim/camera/shot.h"

namespace uwsim {

/// Adds the time since the last mark to a stage; nothing where it does not measure.
class StageClock {
 public:
  StageClock(bool measures, PictureCost& cost) : measures_(measures), cost_(cost) { mark(); }
  void mark() {
    if (measures_) last_ = Clock::now();
  }
  void add(int stage) {
    if (!measures_) return;
    const Clock::time_point now = Clock::now();
    cost_.seconds[static_cast<std::size_t>(stage)] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  bool measures_;
  PictureCost& cost_;
  Clock::time_point last_;
};

/// Casts a block's rays through world and bodies.
class Tracer {
 public:
  Tracer(const CameraScene& scene, const PreparedShot& prepared, const Exposure& exposure);

  /// Fills distance, normal, label and primitive of active lanes; idle lanes hit nothing. `hits` keeps u and v.
  void cast(camera::Block& block, HitPacket& hits, RayOrder order) const;
  /// Solves distances again in double where `hits` is not on terrain (the kernels do that) and not settled: on the
  /// plane of the triangle that was named, or by another cast for bodies and for round shapes that other things come
  /// near.
  void refine(const HitPacket& hits, camera::Block& block) const;
  /// Whether something lies on a lane's way to the light, where it wants to know; lanes that do not are 0.
  void occluded(const camera::Block& block, camera::Mask& blocked, RayOrder order) const;

 private:
  struct MovedBody {
    const RayScene* hull;
    std::uint32_t label;
    Pose body_from_world;
    Eigen::Matrix3f turn;
    Eigen::Vector3d anchor_body_m;
    Eigen::Vector3f middle_m;  // from the anchor, world axes
    float radius_m;
  };
  void note(const RayPacket& rays, RayOrder order, int kind) const;
  void refine_solids(const HitPacket& hits, camera::Block& block) const;
  void recast(const RayScene& scene, const camera::Mask& lanes, const MovedBody* body, camera::Block& block) const;
  static bool comes_near(const RayPacket& rays, const MovedBody& body);
  static RayPacket turned(const RayPacket& rays, const MovedBody& body);

  const World& world_;
  const RayScene& rays_;
  RayRecord* record_;
  Eigen::Vector3d anchor_world_m_;
  std::vector<MovedBody> bodies_;
};

}  // namespace uwsim
