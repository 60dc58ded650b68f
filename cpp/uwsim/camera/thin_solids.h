#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "uwsim/world/world.h"

namespace uwsim {

/// A solid of strands, such as a net, a rope, a ladder or a chain, which covers parts of pixels from some distance on.
struct ThinSolid {
  std::uint32_t label;
  float thickness_m;
  Eigen::Vector3d low_m, high_m;  ///< its box in the world

  /// True if a ray from `eye_m` meets the box, made larger by `angle_rad` times the distance of its far corner.
  bool may_be_seen(const Eigen::Vector3d& eye_m, const Eigen::Vector3f& direction, double angle_rad) const;
};

/// Four times the volume of a closed mesh over its surface: the diameter of a long cylinder.
double mean_thickness_m(const TriangleMesh& mesh);

/// The solids of a world that are less than 0.1 m thick on average.
std::vector<ThinSolid> thin_solids(const World& world);

}  // namespace uwsim
