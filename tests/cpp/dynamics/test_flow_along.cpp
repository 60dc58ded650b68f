#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "uwsim/dynamics/flow_along.h"
#include "uwsim/world/water.h"

namespace uwsim::flow_along_tests {
namespace {

constexpr double kElement_m = 0.25;

/// Points along a line that is evenly divided: straight, bent smoothly, or with a corner.
struct Line {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> along;

  void add(const Eigen::Vector3d& point) {
    along.push_back(points.empty() ? 0 : along.back() + (point - points.back()).norm());
    points.push_back(point);
  }
};

Line straight(const Eigen::Vector3d& from, const Eigen::Vector3d& way, int count) {
  Line line;
  for (int i = 0; i <= count; ++i) line.add(from + kElement_m * i * way.normalized());
  return line;
}

Line catenary(double top_m, double scale_m, double width_m) {
  Line line;
  for (double x = -width_m; x <= width_m; x += kElement_m / std::cosh(x / scale_m)) {
    line.add({x, 0.3 * x, top_m + scale_m * (std::cosh(x / scale_m) - std::cosh(width_m / scale_m))});
  }
  return line;
}

Line cornered(double depth_m) {
  Line line;
  for (int i = 0; i <= 40; ++i) line.add({kElement_m * i, 0, -depth_m});
  for (int i = 1; i <= 40; ++i) line.add({10, kElement_m * i, -depth_m});
  return line;
}

Water water_with(const Waves& waves) {
  Water water;
  water.waves = std::make_shared<const Waves>(waves);
  water.current_world_m_s = {0.4, -0.2, 0};
  return water;
}

/// The greatest error of velocities, relative to `speed_m_s`, and of accelerations, to `rate_m_s2`.
double worst(FlowAlong& flow, const Line& line, const Water& water, double time_s, double speed_m_s, double rate_m_s2) {
  flow.resize(line.points.size());
  flow.find({line.points, line.along}, water, time_s);
  double error = 0;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const WaterFlow is = flow.at(i), known = water.flow_at(line.points[i], time_s);
    error = std::max(error, (is.velocity_m_s - known.velocity_m_s).norm() / speed_m_s);
    error = std::max(error, (is.wave_acceleration_m_s2 - known.wave_acceleration_m_s2).norm() / rate_m_s2);
  }
  return error;
}

TEST(FlowAlong, IsWithinOnePercentOfASingleWavesMotionAtTheSurface) {
  const std::vector<Line> lines = {straight({0, 0, -2}, {1, 0.2, 0}, 200), straight({0, 0, -2}, {1, 0, -0.5}, 200),
                                   straight({0, 0, -60}, {0.1, 0, 1}, 236), catenary(-3, 8, 12), cornered(4)};
  FlowAlong flow;
  for (double number = 0.05; number < 10; number *= 1.3) {
    const double omega = std::sqrt(9.80665 * number), amplitude = 0.1 / number;
    if (amplitude > 1) continue;
    const WaveComponent wave{amplitude, omega, 0.3, 0.7};
    const Water water = water_with(Waves({&wave, 1}, std::numeric_limits<double>::infinity()));
    for (const Line& line : lines) {
      for (double time_s = 0; time_s < 2; time_s += 0.31) {
        EXPECT_LT(worst(flow, line, water, time_s, amplitude * omega, amplitude * omega * omega), 0.01) << number;
      }
    }
  }
}

TEST(FlowAlong, EvaluatesFewPointsInASea) {
  JonswapSea sea;
  const Water water = water_with(Waves::jonswap(sea, 20));
  const double omega = 2 * std::numbers::pi / sea.peak_period_s, amplitude = sea.significant_height_m / 2;
  FlowAlong flow;
  const Line line = straight({0, 0, -3}, {1, 0, -0.3}, 200);
  EXPECT_LT(worst(flow, line, water, 3, amplitude * omega, amplitude * omega * omega), 0.01);
  EXPECT_LT(flow.evaluated(), 50);
  const Line shallow = straight({0, 0, -0.3}, {1, 0, 0}, 40);
  EXPECT_EQ(worst(flow, shallow, water, 3, 1, 1), 0);
  EXPECT_EQ(flow.evaluated(), 41);
}

/// Points stand for parts of the line, which are wet below the surface; what is dry has no flow, though the polynomials
/// of the points below it begin there.
TEST(FlowAlong, WetsWhatIsBelowTheSurface) {
  Water water = water_with(Waves::jonswap({.significant_height_m = 0.2}, 20));
  water.current_world_m_s.setZero();
  const Line line = straight({0, 0, 1}, {1, 0, -0.6}, 80);
  const std::vector<double> half(line.points.size(), 0.05);
  FlowAlong flow;
  flow.resize(line.points.size());
  int dry = 0, between = 0;
  for (double time_s = 0; time_s < 10; time_s += 0.37) {
    flow.find({line.points, line.along, half}, water, time_s);
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const Eigen::Vector3d& at = line.points[i];
      const double above = at.z() - water.surface_height_at(at.x(), at.y(), time_s);
      EXPECT_NEAR(flow.wet(i), std::clamp(0.5 - above / 0.1, 0.0, 1.0), 1e-12) << i;
      dry += flow.wet(i) == 0;
      between += flow.wet(i) > 0 && flow.wet(i) < 1;
      if (flow.wet(i) == 0) continue;
      const WaterFlow known = water.flow_at(at, time_s);
      EXPECT_LT((flow.at(i).velocity_m_s - known.velocity_m_s).norm(), 0.003) << i;
    }
  }
  EXPECT_GT(dry, 100);
  EXPECT_GT(between, 10);
}

TEST(FlowAlong, IsExactWithoutWaves) {
  Water water;
  water.current_world_m_s = {0.4, -0.2, 0};
  FlowAlong flow;
  EXPECT_EQ(worst(flow, catenary(-3, 8, 12), water, 0, 1, 1), 0);
}

}  // namespace
}  // namespace uwsim::flow_along_tests
