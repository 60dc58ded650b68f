#pragma once

#include <Eigen/Core>
#include <vector>

#include "uwsim/core/body_state.h"

namespace uwsim {

/// A curve in space and how far along it a body is at each time, both as piecewise cubic polynomials.
struct BodyPathSpec {
  std::vector<double> breaks;                        ///< of the curve's parameter u, ascending
  std::vector<Eigen::Matrix<double, 4, 3>> curve_m;  ///< of each piece: coefficients of 1, h, h^2, h^3; h = u - break
  std::vector<double> times_s;                       ///< breaks in time, from 0, ascending
  std::vector<Eigen::Vector4d> progress;             ///< of each piece: u as coefficients of powers of t - break
  bool closed = false;                               ///< begins again after the last time; otherwise it ends there
  bool climbs = false;                               ///< x is along the curve; otherwise along its horizontal part
  bool turns = true;                                 ///< otherwise x keeps pointing east, wherever the curve leads
  Pose path_from_body;                               ///< path axes: origin on the curve, x along it, y level, z up

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// The motion of a body that nothing can push, such as a diver's: a function of time. Pose and velocity are continuous
/// if the curve's second and the progress's first derivative are.
class BodyPath {
 public:
  /// Throws InvalidValue.
  explicit BodyPath(BodyPathSpec spec);
  /// The body at a time from 0 on; at rest once an open path has ended.
  BodyState at(double time_s) const;
  /// Returns true if it stays where it is.
  bool stands() const;

 private:
  BodyPathSpec spec_;
};

}  // namespace uwsim
