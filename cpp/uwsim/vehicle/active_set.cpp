#include "uwsim/vehicle/active_set.h"

#include <Eigen/QR>
#include <algorithm>
#include <limits>
#include <vector>

namespace uwsim {
namespace {

constexpr double kTolerance = 1e-12;  // for unknowns of order 1

Eigen::MatrixXd rows(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& indices) {
  Eigen::MatrixXd chosen(indices.size(), matrix.cols());
  for (std::size_t k = 0; k < indices.size(); ++k) chosen.row(static_cast<Eigen::Index>(k)) = matrix.row(indices[k]);
  return chosen;
}

struct BlockingConstraint {
  Eigen::Index index = -1;
  double step = std::numeric_limits<double>::infinity();
};

/// The first inactive constraint that a move from x along `direction` reaches, and the step length to it.
BlockingConstraint first_block(const Eigen::MatrixXd& normals, const Eigen::VectorXd& limits, const Eigen::VectorXd& x,
                               const Eigen::VectorXd& direction, const std::vector<Eigen::Index>& active) {
  BlockingConstraint block;
  for (Eigen::Index k = 0; k < normals.rows(); ++k) {
    const double approach = normals.row(k).dot(direction);
    if (approach <= kTolerance * direction.norm() || std::find(active.begin(), active.end(), k) != active.end())
      continue;
    const double step = std::max(0.0, limits(k) - normals.row(k).dot(x)) / approach;
    if (step < block.step) block = {k, step};
  }
  return block;
}

}  // namespace

Eigen::VectorXd minimise_in_polytope(double weight, const Eigen::VectorXd& gain, const Eigen::MatrixXd& normals,
                                     const Eigen::VectorXd& limits, Eigen::VectorXd x) {
  std::vector<Eigen::Index> active;
  // far more than needed; terminates degenerate cases
  const Eigen::Index most_iterations = 50 * (normals.rows() + 1);
  for (Eigen::Index iteration = 0; iteration < most_iterations; ++iteration) {
    const Eigen::VectorXd descent = gain - weight * x;
    Eigen::VectorXd direction = descent;
    Eigen::VectorXd multipliers;  // of the active constraints: descent = sum multiplier * normal + direction
    if (!active.empty()) {
      const Eigen::MatrixXd active_normals = rows(normals, active).transpose();
      multipliers = active_normals.colPivHouseholderQr().solve(descent);
      direction -= active_normals * multipliers;
    }
    if (direction.norm() <= 1e3 * kTolerance * std::max(1.0, gain.norm())) {
      if (active.empty()) return x;
      const auto loose =
          std::find_if(multipliers.begin(), multipliers.end(), [](double m) { return m < -1e3 * kTolerance; });
      if (loose == multipliers.end()) return x;
      active.erase(active.begin() + (loose - multipliers.begin()));
      continue;
    }
    const BlockingConstraint block = first_block(normals, limits, x, direction, active);
    const double step = weight > 0 ? std::min(block.step, 1 / weight) : block.step;
    if (step == std::numeric_limits<double>::infinity()) return x;  // unbounded; callers rule this out
    x += step * direction;
    if (step == block.step) active.push_back(block.index);
  }
  return x;
}

}  // namespace uwsim
