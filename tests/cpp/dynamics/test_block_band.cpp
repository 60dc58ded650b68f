#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "uwsim/dynamics/block_band.h"

namespace uwsim {
namespace {

/// Masses of 1 between springs of this stiffness along random directions, and with ones of 100 to the next but one.
BlockBand chain(std::size_t rows, double stiffness, Eigen::MatrixXd& dense) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<> any(-1, 1);
  dense.setIdentity(static_cast<Eigen::Index>(3 * rows), static_cast<Eigen::Index>(3 * rows));
  const auto join = [&](std::size_t first, std::size_t second, const Eigen::Matrix3d& part) {
    const auto a = static_cast<Eigen::Index>(3 * first), b = static_cast<Eigen::Index>(3 * second);
    dense.block<3, 3>(a, a) += part;
    dense.block<3, 3>(b, b) += part;
    dense.block<3, 3>(a, b) -= part;
    dense.block<3, 3>(b, a) -= part;
  };
  for (std::size_t i = 0; i + 1 < rows; ++i) {
    const Eigen::Vector3d way = Eigen::Vector3d(any(random), any(random), any(random)).normalized();
    join(i, i + 1, stiffness * way * way.transpose());
    if (i + 2 < rows) join(i, i + 2, 100 * Eigen::Matrix3d::Identity());
  }
  BlockBand band;
  band.resize(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const auto a = static_cast<Eigen::Index>(3 * i);
    band.diagonal[i] = dense.block<3, 3>(a, a);
    if (i + 1 < rows) band.next[i] = dense.block<3, 3>(a, a + 3);
    band.second[i] = i + 2 < rows ? dense(a, a + 6) : 0;
  }
  return band;
}

TEST(BlockBand, SolvesChainsAtAnyStiffness) {
  constexpr std::size_t kRows = 40;
  for (const double stiffness : {1e2, 1e4, 1e7, 1e10}) {
    Eigen::MatrixXd dense;
    BlockBand stiff = chain(kRows, stiffness, dense), usual = stiff;
    std::vector<Eigen::Vector3d> by_stiff(kRows, Eigen::Vector3d(1, -2, 3)), by_usual = by_stiff;
    const Eigen::VectorXd right = Eigen::Map<const Eigen::VectorXd>(by_stiff[0].data(), 3 * kRows);
    const Eigen::VectorXd wanted = dense.cast<long double>().llt().solve(right.cast<long double>()).cast<double>();
    stiff.factor_stiff(kRows);
    usual.factor(kRows);
    stiff.solve_stiff(kRows, by_stiff);
    usual.solve(kRows, by_usual);
    const auto error = [&](const std::vector<Eigen::Vector3d>& found) {
      return (Eigen::Map<const Eigen::VectorXd>(found[0].data(), 3 * kRows) - wanted).norm() / wanted.norm();
    };
    EXPECT_LT(error(by_stiff), 1e-15 * stiffness + 1e-12) << stiffness;
    if (stiffness <= 1e4) {
      EXPECT_LT(error(by_usual), 1e-9) << stiffness;
    }
  }
}

}  // namespace
}  // namespace uwsim
