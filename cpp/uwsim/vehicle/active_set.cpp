#include "uwsim/vehicle/active_set.h"

#include <Eigen/QR>
#include <algorithm>
#include <limits>
#include <vector>

namespace uwsim {
namespace {

constexpr double kTolerance = 1e-12;  // of unknowns of order 1

Eigen::MatrixXd rows(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& which) {
  Eigen::MatrixXd chosen(which.size(), matrix.cols());
  for (std::size_t k = 0; k < which.size(); ++k) chosen.row(static_cast<Eigen::Index>(k)) = matrix.row(which[k]);
  return chosen;
}

struct Block {
  Eigen::Index constraint = -1;
  double step = std::numeric_limits<double>::infinity();
};

/// The first constraint outside the active ones that a move from x along `way` meets.
Block first_block(const Eigen::MatrixXd& normals, const Eigen::VectorXd& limits, const Eigen::VectorXd& x,
                  const Eigen::VectorXd& way, const std::vector<Eigen::Index>& active) {
  Block block;
  for (Eigen::Index k = 0; k < normals.rows(); ++k) {
    const double approach = normals.row(k).dot(way);
    if (approach <= kTolerance * way.norm() || std::find(active.begin(), active.end(), k) != active.end()) continue;
    const double step = std::max(0.0, limits(k) - normals.row(k).dot(x)) / approach;
    if (step < block.step) block = {k, step};
  }
  return block;
}

}  // namespace

Eigen::VectorXd minimise_in_polytope(double weight, const Eigen::VectorXd& gain, const Eigen::MatrixXd& normals,
                                     const Eigen::VectorXd& limits, Eigen::VectorXd x) {
  std::vector<Eigen::Index> active;
  const Eigen::Index most = 50 * (normals.rows() + 1);  // far more than a run takes; degenerate ones end there
  for (Eigen::Index turn = 0; turn < most; ++turn) {
    const Eigen::VectorXd descent = gain - weight * x;
    Eigen::VectorXd way = descent;
    Eigen::VectorXd pressure;  // of each active constraint: descent = sum pressure x normal + way
    if (!active.empty()) {
      const Eigen::MatrixXd held = rows(normals, active).transpose();
      pressure = held.colPivHouseholderQr().solve(descent);
      way -= held * pressure;
    }
    if (way.norm() <= 1e3 * kTolerance * std::max(1.0, gain.norm())) {
      if (active.empty()) return x;
      const auto loose = std::find_if(pressure.begin(), pressure.end(), [](double p) { return p < -1e3 * kTolerance; });
      if (loose == pressure.end()) return x;
      active.erase(active.begin() + (loose - pressure.begin()));
      continue;
    }
    const Block block = first_block(normals, limits, x, way, active);
    const double step = weight > 0 ? std::min(block.step, 1 / weight) : block.step;
    if (step == std::numeric_limits<double>::infinity()) return x;  // unbounded: no such polytope is asked for
    x += step * way;
    if (step == block.step) active.push_back(block.constraint);
  }
  return x;
}

}  // namespace uwsim
