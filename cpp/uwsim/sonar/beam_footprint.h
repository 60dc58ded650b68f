#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/sonar/multibeam_model.h"

namespace uwsim {

/// Rays that stand for a beam: each carries the same share of its energy, spread as the two-way pattern is.
///
/// The pattern is the product of the transmitter's, narrow across the fan's plane, and the receiver's, narrow within
/// it; both are taken for Gaussian (main lobe alone, no side lobes; widths do not grow with steering). Offsets are a
/// sunflower's (Vogel 1979, Math. Biosci. 44:179; from memory) at the Gaussian's radii, made exact in mean and
/// variance, so that a footprint's middle and extent do not depend on how many rays there are.
class BeamFootprint {
 public:
  /// Offsets within and across the fan's plane in standard deviations of the pattern. Throws InvalidValue unless rays
  /// are 1 (the axis alone) or in [4, 64].
  static std::vector<Eigen::Vector2d> offsets(int rays);

  /// -3 dB widths, one way.
  BeamFootprint(const MultibeamModel& fan, double width_across_rad, double width_along_rad, int rays);

  int rays() const { return rays_; }
  /// Unit vectors in the sonar's frame: those of beam b are [b rays, (b + 1) rays), (3, beams x rays).
  const Eigen::Matrix3Xf& directions() const { return directions_; }
  /// The beams' axes, (3, beams).
  const Eigen::Matrix3Xf& axes() const { return axes_; }
  /// Angle between a ray and its neighbours, about [rad]: the widths' share of one ray.
  double spacing_rad() const { return spacing_rad_; }

 private:
  int rays_;
  double spacing_rad_;
  Eigen::Matrix3Xf directions_, axes_;
};

}  // namespace uwsim
