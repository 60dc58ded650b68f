#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "uwsim/world/world.h"

namespace uwsim {

/// Says at once that nothing fixed is within reach: in open water a step then costs no collision work.
///
/// A pyramid of maxima over a plan grid: level 0 holds for each square block the highest terrain or solid over it, each
/// further level the highest of 2 x 2 blocks. A box asks the level whose blocks are as wide as itself, so that at most
/// four figures answer. Conservative: water under a bridge counts as occupied.
class Clearance {
 public:
  explicit Clearance(const World& world);

  /// False only if no terrain and no solid reaches into the box.
  bool may_touch(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const;

 private:
  struct Level {
    std::ptrdiff_t nx, ny;
    double block_m;
    std::vector<float> highest_m;
  };

  void set_grid(const World& world);
  void raise(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m);
  std::array<std::ptrdiff_t, 4> blocks(const Level& level, const Eigen::Vector2d& low_m,
                                       const Eigen::Vector2d& high_m) const;

  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  std::vector<Level> levels_;  // empty where the world is
};

}  // namespace uwsim
