#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/sonar/echo.h"
#include "uwsim/sonar/multibeam_model.h"

namespace uwsim {

/// The rays that sample each beam of a fan. All rays carry the same energy and are distributed like the two-way
/// pattern.
///
/// The pattern is the product of the transmitter's, narrow across the fan's plane, and the receiver's, narrow within
/// the plane; both are assumed Gaussian (main lobe only, no side lobes). A receiving beam widens as its array is
/// steered (steered_widening). The rays' offsets form a sunflower pattern, turned by the golden angle from ray to ray
/// (Vogel 1979, Math. Biosci. 44:179), with radii at the quantiles of the Gaussian. They are adjusted to have exactly
/// the mean and variance of the Gaussian, so that a footprint's centre and extent do not depend on the number of rays.
class BeamFootprint {
 public:
  /// Offsets within and across the fan's plane, in standard deviations of the pattern. Throws InvalidValue unless the
  /// number of rays is 1 (the axis alone) or in [4, 64].
  static std::vector<Eigen::Vector2d> offsets(int rays);

  /// The widths are those of an unsteered beam, one way, at -3 dB.
  BeamFootprint(const MultibeamModel& fan, double width_across_rad, double width_along_rad, int rays);

  int rays() const { return rays_; }
  /// (3, beams x rays) unit vectors in the sonar's frame; the columns of beam b are [b rays, (b + 1) rays).
  const Eigen::Matrix3Xf& directions() const { return directions_; }
  /// (3, beams) axes of the beams.
  const Eigen::Matrix3Xf& axes() const { return axes_; }
  /// The rays of one beam; valid during the lifetime of this object.
  BeamRays beam(std::size_t beam) const;
  /// Approximate angle between a beam's neighbouring rays [rad]; 0 for a single ray.
  float spacing_rad(std::size_t beam) const { return spacing_rad_[beam]; }
  /// The ratio of a beam's width, and of the isotropic noise in it, to those of an unsteered beam.
  float widening(std::size_t beam) const { return widening_[beam]; }
  float root_widening(std::size_t beam) const { return root_widening_[beam]; }

 private:
  int rays_;
  std::vector<float> spacing_rad_, widening_, root_widening_;
  std::vector<Eigen::Vector2d> offsets_;
  Eigen::Matrix3Xf directions_, axes_;
};

}  // namespace uwsim
