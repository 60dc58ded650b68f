#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/camera/kernel.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The world's waves, those that vehicles feel, around a place at one time: heights and slopes on a grid whose nodes
/// stay where they are as the place moves.
class WaveField {
 public:
  static constexpr int kSide = 128;

  /// The same whatever the number of threads.
  WaveField(const Water& water, const Eigen::Vector3d& centre_world_m, double time_s, int threads = 1);
  /// Without cells where the water is still.
  camera::WaveWindow window() const;

 private:
  static constexpr double kSpacing_m = 0.5;
  std::vector<float> cells_;
  double left_m_ = 0, bottom_m_ = 0;  // relative to the centre
};

}  // namespace uwsim
