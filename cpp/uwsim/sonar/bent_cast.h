#pragma once

#include <Eigen/Core>
#include <span>

#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/world/ray_scene.h"

namespace uwsim {

/// What a ray of sound met along its bent path.
struct SoundHit {
  double length_m;                ///< of the path; infinity where nothing was met
  double time_s;                  ///< one way
  Eigen::Vector3d point_world_m;  ///< where
  Eigen::Vector3f normal_world;   ///< of any length
  Eigen::Vector3d arrival_world;  ///< unit, the path's direction there
  Label label;
};

/// Casts bent rays from one place: each arc as chords that stay within a millimetre of it, cast in turn until one meets
/// a surface. A ray ends at z = 0, at `time_max_s`, or where it meets something. hits[k] belongs to
/// directions_world[k], unit vectors. Same result however the directions are split among calls. Returns how many chords
/// were cast.
std::size_t cast_bent(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& origin_world_m,
                      std::span<const Eigen::Vector3d> directions_world, double time_max_s, std::span<SoundHit> hits);

}  // namespace uwsim
