#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// Heights and slopes of the world's waves, which also move vehicles, on a grid around a position at one time. As the
/// position moves, the grid moves by whole cells.
class WaveGrid {
 public:
  static constexpr int kSide = 128;

  /// The result does not depend on the number of threads.
  WaveGrid(const Water& water, const Eigen::Vector3d& centre_world_m, double time_s, int threads = 1);
  /// The nodes; their values are null if the water is still.
  camera::WaveNodes nodes() const;

 private:
  static constexpr double kSpacing_m = 0.5;
  std::vector<float> values_;
  double left_m_ = 0, bottom_m_ = 0;  // of the first node, relative to the centre
};

}  // namespace uwsim
