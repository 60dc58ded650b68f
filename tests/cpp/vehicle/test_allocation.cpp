#include "uwsim/vehicle/allocation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "uwsim/core/random.h"

namespace uwsim {
namespace {

using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;

Vector6d column(const Eigen::Vector3d& at, const Eigen::Vector3d& axis) {
  Vector6d c;
  c << axis.normalized(), at.cross(axis.normalized());
  return c;
}

/// Four vectored horizontal thrusters and `vertical` vertical ones.
Columns rov(int vertical) {
  Columns columns(6, 4 + vertical);
  int k = 0;
  for (const int x : {1, -1}) {
    for (const int y : {1, -1}) columns.col(k++) = column({0.145 * x, 0.092 * y, 0}, {1, 1.0 * x * y, 0});
  }
  for (const int x : {1, -1}) {
    for (const int y : {1, -1}) {
      if (k < columns.cols()) columns.col(k++) = column({vertical == 4 ? 0.118 * x : 0, 0.215 * y, 0.06}, {0, 0, 1});
    }
  }
  return columns;
}

Eigen::VectorXd for_all(const Columns& columns, double value) {
  return Eigen::VectorXd::Constant(columns.cols(), value);
}

Allocation t200s(const Columns& columns) { return {columns, for_all(columns, -39.9), for_all(columns, 51.5)}; }

/// Random thrusts within the limits, so that their wrench is achievable.
Eigen::VectorXd drawn(const Columns& columns, std::uint64_t tick) {
  static const RandomStream stream(7, "allocation");
  Eigen::VectorXd thrusts(columns.cols());
  for (Eigen::Index k = 0; k < thrusts.size(); ++k) {
    thrusts(k) = -39.9 + 91.4 * stream.uniform(tick, static_cast<std::uint32_t>(k));
  }
  return thrusts;
}

bool within_limits(const Eigen::VectorXd& thrusts) {
  return thrusts.minCoeff() >= -39.9 - 1e-9 && thrusts.maxCoeff() <= 51.5 + 1e-9;
}

TEST(Allocation, EveryWrenchWithinTheLimitsIsGivenExactly) {
  const Columns columns = rov(4);
  const Allocation allocation = t200s(columns);
  int saturated = 0;
  for (std::uint64_t tick = 0; tick < 500; ++tick) {
    Eigen::VectorXd some = drawn(columns, tick);
    if (tick % 2 == 0) {  // all at their limits
      for (Eigen::Index k = 0; k < some.size(); ++k) some(k) = some(k) > 5 ? 51.5 : -39.9;
    }
    const Vector6d wrench = columns * some;
    const Eigen::VectorXd thrusts = allocation.thrusts_n(wrench);
    EXPECT_LT((columns * thrusts - wrench).norm(), 1e-9 * wrench.norm() + 1e-9);
    EXPECT_TRUE(within_limits(thrusts));
    EXPECT_LE(thrusts.norm(), some.norm() + 1e-9) << "of the least effort";
    saturated += thrusts.minCoeff() < -39.89 || thrusts.maxCoeff() > 51.49;
  }
  EXPECT_GT(saturated, 50) << "the draws must reach the limits";
}

TEST(Allocation, WithinTheLimitsItEqualsThePseudoInverse) {
  const Columns columns = rov(4);
  Vector6d wrench;
  wrench << 20, -10, 30, 2, -1, 3;
  const Eigen::VectorXd expected = columns.transpose() * (columns * columns.transpose()).inverse() * wrench;
  EXPECT_LT((t200s(columns).thrusts_n(wrench) - expected).norm(), 1e-9);
}

TEST(Allocation, BeyondTheLimitsAWrenchKeepsItsDirectionAndIsAsLargeAsPossible) {
  const Columns columns = rov(4);
  const Allocation allocation = t200s(columns);
  for (std::uint64_t tick = 0; tick < 200; ++tick) {
    const Vector6d wrench = 30 * columns * drawn(columns, tick);
    const Eigen::VectorXd thrusts = allocation.thrusts_n(wrench);
    const Vector6d got = columns * thrusts;
    EXPECT_TRUE(within_limits(thrusts));
    const double multiple = got.norm() / wrench.norm();
    EXPECT_LT((got - multiple * wrench).norm(), 1e-9 * wrench.norm());
    EXPECT_NEAR(multiple, allocation.largest_multiple(wrench), 1e-9);
    EXPECT_GT(multiple, 1.0 / 30 - 1e-9) << "a 30th of it is within the limits";
  }
}

TEST(Allocation, TheLargestWrenchesOfAVectoredFrameAreThoseOfTheGeometry) {
  const Allocation allocation = t200s(rov(4));
  const double cos45 = std::sqrt(0.5);
  EXPECT_NEAR(allocation.largest_multiple(Vector6d::Unit(0)), 4 * 51.5 * cos45, 1e-9);
  EXPECT_NEAR(allocation.largest_multiple(-Vector6d::Unit(0)), 4 * 39.9 * cos45, 1e-9);
  EXPECT_NEAR(allocation.largest_multiple(Vector6d::Unit(1)), 4 * 39.9 * cos45, 1e-9)
      << "no surge: pushing and pulling thrusters balance";
  EXPECT_NEAR(allocation.largest_multiple(Vector6d::Unit(2)), 4 * 51.5, 1e-9);
  EXPECT_NEAR(allocation.largest_multiple(Vector6d::Unit(3)), 0.215 * 2 * (2 * 39.9), 1e-9)
      << "no heave: the two sides balance";
}

TEST(Allocation, AnAxisThatCannotBeDrivenIsReportedAndIgnored) {
  const Columns columns = rov(2);
  const Allocation allocation = t200s(columns);
  EXPECT_EQ(allocation.driven(), (std::array{true, true, true, true, false, true}));
  EXPECT_EQ(allocation.largest_multiple(Vector6d::Unit(4)), 0);
  EXPECT_TRUE(allocation.thrusts_n(Vector6d::Unit(4)).isZero(0));
  Vector6d wrench;
  wrench << 10, 5, -8, 1, 7, 2;
  Vector6d expected = wrench;
  expected(4) = 0;
  EXPECT_LT((columns * allocation.thrusts_n(wrench) - expected).norm(), 1e-9);
}

TEST(Allocation, AnOffCentreThrusterDrivesSurgeOnly) {
  Columns one(6, 1);
  one.col(0) = column({-0.7, 0, 0.1}, {1, 0, 0});
  const Allocation allocation(one, for_all(one, 0), for_all(one, 30));
  EXPECT_EQ(allocation.driven(), (std::array{true, false, false, false, false, false}));
  EXPECT_NEAR(allocation.thrusts_n(20 * Vector6d::Unit(0))(0), 20, 1e-12);
  EXPECT_NEAR(allocation.thrusts_n(50 * Vector6d::Unit(0))(0), 30, 1e-12);
  EXPECT_NEAR(allocation.thrusts_n(-20 * Vector6d::Unit(0))(0), 0, 1e-12) << "it does not reverse";
}

TEST(Allocation, AVehicleWithoutThrustersIsAllowed) {
  const Allocation none(Columns(6, 0), Eigen::VectorXd(0), Eigen::VectorXd(0));
  EXPECT_EQ(none.thrusts_n(Vector6d::Ones()).size(), 0);
  EXPECT_EQ(none.largest_multiple(Vector6d::Ones()), 0);
  EXPECT_TRUE(t200s(rov(4)).thrusts_n(Vector6d::Zero()).isZero(0));
}

}  // namespace
}  // namespace uwsim
