#include "uwsim/world/current.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

const Eigen::Vector3d kEast = Eigen::Vector3d::UnitX();

TEST(Current, LayersAreLinearBetweenLevelsAndConstantBeyond) {
  const auto current = layered_current({2, 10}, {{1, 0, 0}, {0, 0.4, 0}});
  EXPECT_EQ(current->at({5, 5, 0}, 0).velocity_m_s, Eigen::Vector3d(1, 0, 0));
  EXPECT_LT((current->at({5, 5, -4}, 7).velocity_m_s - Eigen::Vector3d(0.75, 0.1, 0)).norm(), 1e-15);
  EXPECT_EQ(current->at({5, 5, -99}, 0).velocity_m_s, Eigen::Vector3d(0, 0.4, 0));
}

TEST(Current, ATideReversesWithItsPeriodAndItsRateIsItsDerivative) {
  const double period = 44'712;  // M2
  const auto tide = tidal_current(0.8 * kEast, period, 0);
  EXPECT_NEAR(tide->at({}, period / 4).velocity_m_s.x(), 0.8, 1e-12);
  EXPECT_NEAR(tide->at({}, 3 * period / 4).velocity_m_s.x(), -0.8, 1e-12);
  const double slope = (tide->at({}, 101).velocity_m_s.x() - tide->at({}, 99).velocity_m_s.x()) / 2;
  EXPECT_NEAR(tide->at({}, 100).rate_m_s2.x(), slope, 1e-9);
}

/// M2, K1, M8 and one of a minute: within a window of the series and across its ends.
TEST(Current, ASumOfHarmonicsIsThatOfItsParts) {
  std::vector<Harmonic> harmonics = {{1.405189e-4, {0.3, -0.1}, {0.05, 0.2}},
                                     {7.292117e-5, {-0.02, 0.4}, {0.1, 0.1}},
                                     {5.620756e-4, {0.01, 0.02}, {-0.03, 0.01}}};
  for (const double fastest_rad_s : {0.0, 0.1}) {
    if (fastest_rad_s > 0) harmonics.push_back({fastest_rad_s, {0.2, 0}, {0, 0.3}});
    const auto current = harmonic_current(harmonics), other = harmonic_current({{0.01, {1, 0}, {0, 0}}});
    for (double time_s = -5e3; time_s < 9e7; time_s = 1.7 * time_s + (time_s < 0 ? 6e3 : 3.1)) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero(), rate = sum;
      for (const Harmonic& each : harmonics) {
        const double c = std::cos(each.speed_rad_s * time_s), s = std::sin(each.speed_rad_s * time_s);
        sum.head<2>() += (c * each.cosine + s * each.sine).matrix();
        rate.head<2>() += (each.speed_rad_s * (c * each.sine - s * each.cosine)).matrix();
      }
      EXPECT_NEAR(other->at({}, time_s).velocity_m_s.x(), std::cos(0.01 * time_s), 1e-9 + 1e-15 * std::abs(time_s));
      EXPECT_LT((current->at({}, time_s).velocity_m_s - sum).norm(), 1e-14 + 1e-16 * std::abs(time_s)) << time_s;
      EXPECT_LT((current->at({}, time_s).rate_m_s2 - rate).norm(), 1e-14 + 1e-17 * std::abs(time_s)) << time_s;
      EXPECT_LE(sum.norm(), current->bound_m_s());
    }
  }
}

TEST(Current, TheLargestOfAHarmonicIsTheLongHalfAxisOfItsEllipse) {
  EXPECT_NEAR((Harmonic{1, {0.3, 0}, {0, 0.1}}).largest(), 0.3, 1e-15);
  EXPECT_NEAR((Harmonic{1, {0.3, 0.4}, {0.3, 0.4}}).largest(), 0.5 * std::numbers::sqrt2, 1e-12);
}

TEST(Current, GustsHaveTheirStandardDeviationAndCorrelationTime) {
  const double tau = 20, sigma = 0.1;
  const auto gusts = gusty_current({sigma, sigma, 0}, tau, 11);
  constexpr int kSamples = 100'000;
  double mean = 0, square = 0, lagged = 0, cross = 0;
  for (int k = 0; k < kSamples; ++k) {
    const Eigen::Vector3d v = gusts->at({}, 0.5 * tau * k).velocity_m_s;
    mean += v.x() / kSamples;
    square += v.x() * v.x() / kSamples;
    cross += v.x() * v.y() / kSamples;
    lagged += v.x() * gusts->at({}, 0.5 * tau * k + tau).velocity_m_s.x() / kSamples;
  }
  EXPECT_NEAR(mean, 0, 0.03 * sigma);
  EXPECT_NEAR(std::sqrt(square), sigma, 0.02 * sigma);
  EXPECT_NEAR(lagged / square, std::exp(-1.0), 0.02);
  EXPECT_NEAR(cross / square, 0, 0.02);
  EXPECT_EQ(gusts->at({}, 3).velocity_m_s.z(), 0);
}

TEST(Current, GustsAreContinuousAndTheirRateIsTheirDerivative) {
  const auto gusts = gusty_current({0.1, 0, 0}, 1, 11);  // blocks of 16 s, knots every 1/32 s
  double last = gusts->at({}, 0).velocity_m_s.x();
  for (int k = 1; k <= 32'000; ++k) {
    const CurrentSample now = gusts->at({}, 1e-3 * k);
    EXPECT_NEAR(now.velocity_m_s.x(), last, 1.5e-3 * 0.1 * 32) << "a few sigma from knot to knot at most";
    last = now.velocity_m_s.x();
  }
  const CurrentSample a = gusts->at({}, 5.001), b = gusts->at({}, 5.002);
  EXPECT_NEAR((b.velocity_m_s.x() - a.velocity_m_s.x()) / 0.001, a.rate_m_s2.x(), 1e-9);
}

TEST(Current, AGridIsTrilinearInsideAndConstantOutside) {
  CurrentGrid grid{.x_m = {0, 1, 4}, .y_m = {-2, 2}, .z_m = {-10, 0}, .values = {}};
  const auto field = [](double x, double y, double z) {
    return Eigen::Vector3d(0.1 * x + 0.02 * x * y, 0.3 + 0.01 * y * z, 0.001 * x * y * z);
  };
  for (const double z : grid.z_m)
    for (const double y : grid.y_m)
      for (const double x : grid.x_m) grid.values.push_back(field(x, y, z));
  const auto current = gridded_current(grid);
  EXPECT_LT((current->at({2.2, 0.7, -3.1}, 0).velocity_m_s - field(2.2, 0.7, -3.1)).norm(), 1e-14);
  EXPECT_LT((current->at({4, 2, 0}, 0).velocity_m_s - field(4, 2, 0)).norm(), 1e-14);
  EXPECT_LT((current->at({9, 0.7, -50}, 0).velocity_m_s - field(4, 0.7, -10)).norm(), 1e-14);
}

TEST(Current, AGridOfSeveralTimesIsLinearBetweenThemAndStandsStillBeyond) {
  const auto current = gridded_current({{0}, {0}, {-10, 0}, {0, 100}, {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {6, 0, 0}}});
  EXPECT_NEAR(current->at({5, 5, -5}, 25).velocity_m_s.x(), 1.5 + 0.25 * (4.5 - 1.5), 1e-14);
  EXPECT_NEAR(current->at({5, 5, -5}, 25).rate_m_s2.x(), (4.5 - 1.5) / 100, 1e-14);
  EXPECT_EQ(current->at({0, 0, 0}, 1e4).velocity_m_s.x(), 6);
  EXPECT_EQ(current->at({0, 0, 0}, 1e4).rate_m_s2.x(), 0);
  EXPECT_EQ(current->at({0, 0, 0}, -1).rate_m_s2.x(), 0);
}

/// Within a cell and across its edges, the mean over six points is that of the points.
TEST(Current, AGridOverAVolumeIsItsMeanAndItsMoment) {
  CurrentGrid grid{.x_m = {0, 3, 9}, .y_m = {-2, 5}, .z_m = {-9, -4, 0}, .t_s = {0, 60}, .values = {}};
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double n = static_cast<double>(k);
    grid.values.emplace_back(0.3 * std::sin(7 * n), 0.2 * std::cos(5 * n), 0.1 * std::sin(3 * n * n));
  }
  const auto current = gridded_current(grid);
  Eigen::Matrix3d arms;  // at right angles
  arms << 0.6, -0.2, 0.1, 0.2, 0.6, -0.05, -0.1, 0.1, 0.4;
  arms.col(1) -= arms.col(1).dot(arms.col(0)) / arms.col(0).squaredNorm() * arms.col(0);
  arms.col(2) = arms.col(0).cross(arms.col(1));
  const std::vector<Eigen::Vector3d> middles = {{1.5, 1, -6}, {3.1, 1, -4.2}, {-3, 9, 2}, {8.9, 4.9, -8.9}};
  for (const Eigen::Vector3d& middle : middles) {
    for (const double time_s : {-5.0, 0.0, 41.0, 99.0}) {
      const CurrentOver mean = current->over(middle, arms, time_s),
                        points = current->Current::over(middle, arms, time_s);
      EXPECT_LT((mean.velocity_m_s - points.velocity_m_s).norm(), 1e-15);
      EXPECT_LT((mean.rate_m_s2 - points.rate_m_s2).norm(), 1e-16);
      EXPECT_LT((mean.turning_m2_s - points.turning_m2_s).norm(), 1e-15);
      EXPECT_LT((mean.gradient_1_s - points.gradient_1_s).norm(), 0.02) << "the field bends a little along the arms";
    }
  }
}

TEST(Current, InvalidCurrentsAreRefused) {
  EXPECT_THROW(layered_current({3, 1}, {kEast, kEast}), InvalidValue);
  EXPECT_THROW(layered_current({1}, {kEast, kEast}), InvalidValue);
  EXPECT_THROW(tidal_current(kEast, 0, 0), InvalidValue);
  EXPECT_THROW(gusty_current(-kEast, 1, 0), InvalidValue);
  EXPECT_THROW(harmonic_current({{1e-4, {11, 0}, {0, 0}}}), InvalidValue);
  EXPECT_THROW(harmonic_current({{std::nan(""), {1, 0}, {0, 0}}}), InvalidValue);
  EXPECT_THROW(gridded_current({{0, 1}, {0}, {0}, {0}, {kEast}}), InvalidValue);
  EXPECT_THROW(gridded_current({{0}, {0}, {0}, {0}, {kEast * std::nan("")}}), InvalidValue);
}

}  // namespace
}  // namespace uwsim
