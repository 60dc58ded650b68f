#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A solid of strands, such as a net, a rope, a ladder or a chain, which covers parts of pixels from some distance on.
struct ThinSolid {
  std::uint32_t label;
  float thickness_m;
  Eigen::Vector3d low_m, high_m;  ///< its box in the world
};

/// The boxes of thin solids about an eye, for a quick test of many rays.
class ThinSolidsAround {
 public:
  /// least_m: how far away each solid begins to matter. aside: at most how far, along each axis, the directions of the
  /// rays that are asked about together are from the one that is asked.
  ThinSolidsAround(const std::vector<ThinSolid>& solids, const std::vector<float>& least_m,
                   const Eigen::Vector3d& eye_m, float aside);

  /// False if no ray that starts at a point (from the eye) along a unit vector, or along one `aside` of it, meets a box
  /// as far away as its solid matters.
  bool may_be_met(const camera::Kernels& kernels, const Eigen::Vector3f& origin_m,
                  const Eigen::Vector3f& direction) const;

 private:
  std::vector<camera::BoxLanes> boxes_;
  float aside_;
};

/// Four times the volume of a closed mesh over its surface: the diameter of a long cylinder.
double mean_thickness_m(const TriangleMesh& mesh);

/// The solids of a world that are less than 0.1 m thick on average.
std::vector<ThinSolid> thin_solids(const World& world);

}  // namespace uwsim
