#pragma once

#include "uwsim/rays/ray_scene.h"

namespace uwsim {

/// The depth of the first surface below a point of the water's surface; infinite if there is none.
inline double bed_depth_m(const RayScene& scene, double x_world_m, double y_world_m) {
  constexpr double kDeepest_m = 12000;
  return scene.cast({{x_world_m, y_world_m, 0}, -Eigen::Vector3d::UnitZ()}, kDeepest_m).distance_m;
}

}  // namespace uwsim
