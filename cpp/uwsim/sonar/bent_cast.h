#pragma once

#include <Eigen/Core>
#include <span>

#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/rays/ray_scene.h"

namespace uwsim {

/// The hit of a sound ray along its bent path.
struct SoundHit {
  double length_m;  ///< length of the path; infinity without a hit
  double time_s;    ///< one way; infinity without a hit
  Eigen::Vector3d point_world_m;
  Eigen::Vector3f normal_world;   ///< of any length
  Eigen::Vector3d arrival_world;  ///< unit vector along the path at the hit
  Label label;
};

/// Casts bent rays from one point. Each path is cast as a series of chords until one hits a surface; the hit is then
/// moved along the surface's tangent plane onto the path itself. A chord departs from the path by at most two
/// thousandths of the distance travelled, or a millimetre if that is more, which only matters where the ray narrowly
/// misses or hits an edge: the narrowest packaged beam, 0.4 degrees, is 3.5 times as wide. A ray ends at z = 0, at
/// `time_max_s`, or at its hit. hits[k] belongs to directions_world[k], a unit vector. The result does not depend on
/// how the directions are divided among calls. Returns the number of chords cast.
std::size_t cast_bent(const RayScene& scene, const SoundSpeedProfile& profile, const Eigen::Vector3d& origin_world_m,
                      std::span<const Eigen::Vector3d> directions_world, double time_max_s, std::span<SoundHit> hits);

}  // namespace uwsim
