#include "uwsim/core/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "uwsim/core/stream_name.h"

namespace uwsim {
namespace {

TEST(RandomStream, ADrawDependsOnlyOnSeedNameTickAndIndex) {
  const RandomStream depth(7, "rov/depth");
  const double first = depth.normal(3, 1);
  depth.normal(99);
  EXPECT_EQ(depth.normal(3, 1), first);
  EXPECT_EQ(RandomStream(7, "rov/depth").normal(3, 1), first);
  EXPECT_NE(RandomStream(8, "rov/depth").normal(3, 1), first);
  EXPECT_NE(RandomStream(7, "rov/imu").normal(3, 1), first);
  EXPECT_NE(depth.normal(4, 1), first);
  EXPECT_NE(depth.normal(3, 2), first);
}

TEST(RandomStream, NormalDrawsHaveZeroMeanAndUnitVarianceAndAreUncorrelated) {
  const RandomStream stream(1, "test");
  constexpr int n = 200'000;
  double sum = 0, squares = 0, products = 0, fourth = 0;
  for (int k = 0; k < n; ++k) {
    const double x = stream.normal(static_cast<std::uint64_t>(k));
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
    products += x * stream.normal(static_cast<std::uint64_t>(k + 1));
  }
  const double tolerance = 5 / std::sqrt(n);  // five standard errors
  EXPECT_NEAR(sum / n, 0, tolerance);
  EXPECT_NEAR(squares / n, 1, tolerance * std::sqrt(2));
  EXPECT_NEAR(fourth / n, 3, tolerance * std::sqrt(96));
  EXPECT_NEAR(products / n, 0, tolerance);
}

TEST(RandomStream, APairOfNormalsIsIndependentAndStartsWithTheSingleOne) {
  const RandomStream stream(7, "pair");
  double product = 0, second = 0;
  constexpr int kDraws = 100'000;
  for (std::uint64_t tick = 0; tick < kDraws; ++tick) {
    const auto [a, b] = stream.normals(tick, 3);
    EXPECT_EQ(a, stream.normal(tick, 3));
    product += a * b / kDraws;
    second += b * b / kDraws;
  }
  EXPECT_NEAR(product, 0, 0.015);
  EXPECT_NEAR(second, 1, 0.02);
}

TEST(StreamName, JoinsItsPartsBySlashes) {
  EXPECT_EQ(stream_name("rov"), "rov");
  EXPECT_EQ(stream_name("rov", "imu"), "rov/imu");
  EXPECT_EQ(stream_name(std::string("rov"), std::string("imu"), "bias"), "rov/imu/bias");
}

}  // namespace
}  // namespace uwsim
