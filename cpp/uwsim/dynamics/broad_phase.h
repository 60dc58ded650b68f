#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "uwsim/world/world.h"

namespace uwsim {

/// Quickly rules out contacts with terrain and solids, so that a step in open water spends nothing on contacts.
///
/// A pyramid of maxima over a horizontal grid. Level 0 stores, for each square block, the height of the highest terrain
/// or solid in it; each level above stores the maxima of 2 x 2 blocks. A box is tested at the level whose blocks are at
/// least as wide as the box, so at most four values are read. The test is conservative: water under a bridge counts as
/// occupied.
class BroadPhase {
 public:
  explicit BroadPhase(const World& world);

  /// False only if neither terrain nor a solid reaches into the box.
  bool may_touch(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m) const;

 private:
  struct Level {
    std::ptrdiff_t nx, ny;
    double block_m;
    std::vector<float> highest_m;
  };

  void set_grid(const World& world);
  void raise_blocks(const Heightfield& terrain);
  void raise_blocks(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m);
  static std::array<std::ptrdiff_t, 2> blocks_along(double low_m, double high_m, double block_m, std::ptrdiff_t count);
  std::array<std::ptrdiff_t, 4> blocks_in(const Level& level, const Eigen::Vector2d& low_m,
                                          const Eigen::Vector2d& high_m) const;

  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  std::vector<Level> levels_;  // empty if the world is empty
};

}  // namespace uwsim
