#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "uwsim/core/body_state.h"

namespace uwsim {

/// Which of the six axes (surge .. yaw) actuators with these wrench columns can drive apart from each other. Taken in
/// the order surge, sway, heave, yaw, roll, pitch, an axis counts when its row of the configuration matrix is
/// independent of the rows that count already: what then comes about a left-out axis (the pitch of an off-centre surge
/// thruster) is left to the hull's own stability.
std::array<bool, 6> independent_axes(const Eigen::Matrix<double, 6, Eigen::Dynamic>& columns);

/// Shares a wrench out among thrusters: tau = T f over the axes that can be driven, T the configuration matrix (Fossen
/// 2011, "Handbook of Marine Craft Hydrodynamics and Motion Control", sec. 12.3).
///
/// The least effort, each thrust weighed by its thruster's limit: the weighted pseudo-inverse, or where
/// that saturates a thruster, the constrained least squares among the solutions within the limits. A wrench that no
/// thrusts within the limits give keeps its direction and is as large as can be.
class Allocation {
 public:
  Allocation() = default;
  /// columns: (6, n), wrench per newton. lowest_n <= 0 <= highest_n: (n,) limits [N].
  Allocation(Eigen::Matrix<double, 6, Eigen::Dynamic> columns, const Eigen::VectorXd& lowest_n,
             const Eigen::VectorXd& highest_n);

  const std::array<bool, 6>& driven() const { return driven_; }
  /// (n,) [N] for a wrench [N, N m], whose components about axes that are not driven count as zero.
  Eigen::VectorXd thrusts_n(const Vector6d& wrench_body) const;
  /// How many times this wrench the thrusters give at most; 0 for a wrench about axes that are not driven.
  double reach(const Vector6d& wrench_body) const;

 private:
  struct Best;
  Best best(const Eigen::VectorXd& least) const;
  Eigen::VectorXd least_effort(const Vector6d& wrench_body) const;

  std::array<bool, 6> driven_{};
  std::vector<Eigen::Index> axes_;  // the driven ones
  Eigen::VectorXd limit_n_;         // the larger one of each thruster; thrusts below are shares of it
  Eigen::MatrixXd inverse_;         // (n, axes), weighted pseudo-inverse
  Eigen::MatrixXd idle_;            // (n, n - axes), thrusts that cancel out; orthonormal
  Eigen::VectorXd bounds_;          // (2 n), highest then -lowest shares
};

}  // namespace uwsim
