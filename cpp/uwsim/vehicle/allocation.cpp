#include "uwsim/vehicle/allocation.h"

#include <Eigen/QR>
#include <algorithm>
#include <utility>

#include "uwsim/vehicle/active_set.h"

namespace uwsim {
namespace {

constexpr double kDependent = 1e-6;  // a row is dependent if less than this fraction of it is orthogonal to the others
constexpr std::array<Eigen::Index, 6> kOrder = {0, 1, 2, 5, 3, 4};

/// (x; -x), row by row.
Eigen::MatrixXd both_signs(const Eigen::MatrixXd& x) {
  Eigen::MatrixXd both(2 * x.rows(), x.cols());
  both << x, -x;
  return both;
}

}  // namespace

std::array<bool, 6> independent_axes(const Eigen::Matrix<double, 6, Eigen::Dynamic>& columns) {
  std::array<bool, 6> driven{};
  if (columns.cols() == 0) return driven;
  std::vector<Eigen::VectorXd> basis;
  const double longest = columns.cwiseAbs().maxCoeff();
  for (const Eigen::Index axis : kOrder) {
    Eigen::VectorXd row = columns.row(axis).transpose();
    const double length = row.norm();
    for (const Eigen::VectorXd& other : basis) row -= other.dot(row) * other;
    if (length <= 1e-9 * longest || row.norm() <= kDependent * length) continue;
    basis.push_back(row.normalized());
    driven[static_cast<std::size_t>(axis)] = true;
  }
  return driven;
}

Allocation::Allocation(Eigen::Matrix<double, 6, Eigen::Dynamic> columns, const Eigen::VectorXd& lowest_n,
                       const Eigen::VectorXd& highest_n)
    : limit_n_(highest_n.cwiseMax(-lowest_n)) {
  for (Eigen::Index k = 0; k < limit_n_.size(); ++k) {
    if (limit_n_(k) == 0) limit_n_(k) = 1;  // a thruster without thrust: its bounds are zero
  }
  columns *= limit_n_.asDiagonal();
  driven_ = independent_axes(columns);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    if (driven_[static_cast<std::size_t>(axis)]) axes_.push_back(axis);
  }
  const Eigen::Index n = columns.cols(), rank = static_cast<Eigen::Index>(axes_.size());
  bounds_.resize(2 * n);
  bounds_ << highest_n.cwiseQuotient(limit_n_), (-lowest_n).cwiseQuotient(limit_n_);
  inverse_ = Eigen::MatrixXd::Zero(n, rank);
  if (rank == 0) return;
  Eigen::MatrixXd transposed(n, rank);
  for (Eigen::Index k = 0; k < rank; ++k) transposed.col(k) = columns.row(axes_[static_cast<std::size_t>(k)]);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(transposed);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd r = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
  inverse_ =
      q.leftCols(rank) * r.transpose().triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(rank, rank));
  idle_ = q.rightCols(n - rank);
}

/// The largest multiple of a wrench that the limits, or the remaining part of the limits, allow, together with the
/// mutually cancelling thrusts that it requires.
struct Allocation::Limit {
  double multiple = 0;
  Eigen::VectorXd idle;
};

Allocation::Limit Allocation::limit(const Eigen::VectorXd& least, const Eigen::VectorXd& left) const {
  const double size = least.cwiseAbs().maxCoeff();
  Eigen::MatrixXd moves(least.size(), 1 + idle_.cols());
  moves << least / size, idle_;
  const Eigen::VectorXd start = Eigen::VectorXd::Zero(moves.cols());
  const Eigen::VectorXd x =
      minimise_in_polytope(0, Eigen::VectorXd::Unit(moves.cols(), 0), both_signs(moves), left, start);
  return {x(0) / size, x.tail(idle_.cols())};
}

Eigen::VectorXd Allocation::least_effort(const Vector6d& wrench_body) const {
  Eigen::VectorXd driven(axes_.size());
  for (std::size_t k = 0; k < axes_.size(); ++k) driven(static_cast<Eigen::Index>(k)) = wrench_body(axes_[k]);
  return inverse_ * driven;
}

double Allocation::largest_multiple(const Vector6d& wrench_body) const {
  const Eigen::VectorXd least = least_effort(wrench_body);
  return least.size() == 0 || least.isZero(0) ? 0 : limit(least, bounds_).multiple;
}

Vector6d Allocation::driven_part(const Vector6d& wrench_body) const {
  Vector6d part = Vector6d::Zero();
  for (const Eigen::Index axis : axes_) part(axis) = wrench_body(axis);
  return part;
}

Vector6d Allocation::reachable(const Vector6d& wrench_body) const {
  const Vector6d wanted = driven_part(wrench_body);
  const Eigen::VectorXd least = least_effort(wanted);
  if (((both_signs(least) - bounds_).array() <= 0).all()) return wanted;
  Vector6d torque = wanted, force = wanted;
  torque.head<3>().setZero();
  force.tail<3>().setZero();
  torque *= std::min(1.0, torque.isZero(0) ? 1.0 : largest_multiple(torque));
  if (force.isZero(0)) return torque;
  const Eigen::VectorXd used = thrusts_n(torque).cwiseQuotient(limit_n_);
  const Eigen::VectorXd left = (bounds_ - both_signs(used)).cwiseMax(0);
  return torque + std::min(1.0, limit(least_effort(force), left).multiple) * force;
}

Eigen::VectorXd Allocation::thrusts_n(const Vector6d& wrench_body) const {
  const Eigen::VectorXd least = least_effort(wrench_body);
  if (((both_signs(least) - bounds_).array() <= 0).all()) return least.cwiseProduct(limit_n_);
  const Limit most = limit(least, bounds_);
  if (most.multiple <= 1) return (most.multiple * least + idle_ * most.idle).cwiseProduct(limit_n_);
  const Eigen::VectorXd inside = most.idle / most.multiple;  // feasible: the polytope is convex and contains 0
  const Eigen::VectorXd left = bounds_ - both_signs(least);
  const Eigen::VectorXd rest =
      minimise_in_polytope(1, Eigen::VectorXd::Zero(idle_.cols()), both_signs(idle_), left, inside);
  return (least + idle_ * rest).cwiseProduct(limit_n_);
}

}  // namespace uwsim
