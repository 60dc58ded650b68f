#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "uwsim/core/body_state.h"

namespace uwsim {

/// Determines which of the six axes (surge to yaw) can be driven independently by actuators with these wrench columns.
/// In the order surge, sway, heave, yaw, roll, pitch, an axis is selected if its row of the configuration matrix is
/// linearly independent of the rows already selected. A moment about an axis that is not selected (the pitching moment
/// of an off-centre surge thruster) is left to the hull's own stability.
std::array<bool, 6> independent_axes(const Eigen::Matrix<double, 6, Eigen::Dynamic>& columns);

/// Control allocation: computes the thrusts f for a wrench, tau = T f for the axes that can be driven, where T is the
/// configuration matrix (Fossen 2011, "Handbook of Marine Craft Hydrodynamics and Motion Control", sec. 12.3).
///
/// The thrusts have the least sum of squares, each relative to its thruster's limit: the weighted pseudo-inverse or, if
/// that saturates a thruster, the constrained least-squares solution within the limits. A wrench beyond the limits is
/// scaled down in its direction to the largest that they allow.
class Allocation {
 public:
  Allocation() = default;
  /// columns: (6, n), wrench per newton of thrust. lowest_n <= 0 <= highest_n: (n,) limits [N].
  Allocation(Eigen::Matrix<double, 6, Eigen::Dynamic> columns, const Eigen::VectorXd& lowest_n,
             const Eigen::VectorXd& highest_n);

  const std::array<bool, 6>& driven() const { return driven_; }
  /// Thrusts (n,) [N] for a wrench [N, N m]. Components about axes that are not driven are ignored.
  Eigen::VectorXd thrusts_n(const Vector6d& wrench_body) const;
  /// The part of a requested wrench that the limits allow. The torque has priority: the torque or its largest feasible
  /// multiple, and together with it the force or its largest feasible multiple. Components about axes that are not
  /// driven are 0.
  Vector6d reachable(const Vector6d& wrench_body) const;
  /// The largest multiple of a wrench within the limits; 0 for a wrench about axes that are not driven.
  double largest_multiple(const Vector6d& wrench_body) const;

 private:
  struct Limit;
  Limit limit(const Eigen::VectorXd& least, const Eigen::VectorXd& left) const;
  Vector6d driven_part(const Vector6d& wrench_body) const;
  Eigen::VectorXd least_effort(const Vector6d& wrench_body) const;

  std::array<bool, 6> driven_{};
  std::vector<Eigen::Index> axes_;  // the driven axes
  Eigen::VectorXd limit_n_;         // larger limit of each thruster; thrusts below are relative to it
  Eigen::MatrixXd inverse_;         // (n, axes), weighted pseudo-inverse
  Eigen::MatrixXd idle_;            // (n, n - axes), thrusts that cancel each other; orthonormal columns
  Eigen::VectorXd bounds_;          // (2 n), highest, then -lowest relative thrusts
};

}  // namespace uwsim
