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
};

/// The boxes of thin solids about an eye, each made larger by an angle times the distance of its far corner.
class ThinSolidsAround {
 public:
  ThinSolidsAround() = default;
  ThinSolidsAround(const std::vector<ThinSolid>& solids, const Eigen::Vector3d& eye_m, double angle_rad);

  /// True if a ray from the eye along a unit vector meets one of the boxes.
  bool are_met(const Eigen::Vector3f& direction) const;

 private:
  struct Box {
    Eigen::Array3d low_m, high_m;  // from the eye
    Eigen::Vector3f towards;       // its middle, unit
    float least_cosine;            // of the angle between `towards` and a ray that may meet it
  };
  std::vector<Box> boxes_;
};

/// Four times the volume of a closed mesh over its surface: the diameter of a long cylinder.
double mean_thickness_m(const TriangleMesh& mesh);

/// The solids of a world that are less than 0.1 m thick on average.
std::vector<ThinSolid> thin_solids(const World& world);

}  // namespace uwsim
