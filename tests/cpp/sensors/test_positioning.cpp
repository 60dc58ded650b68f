#include "sensors/sensor_bench.h"

namespace uwsim {
namespace {

using Positioning = SensorBench;

TEST_F(Positioning, AGpsLosesItsFixUnderWaterAndRegainsItAfterItsTimes) {
  SensorSpec spec = sensor_spec("gps", {{"reacquisition_s", {2}}, {"cold_start_s", {5}}, {"ephemeris_s", {20}}});
  spec.rate_hz = 2;
  const auto run = [&](NoisySensor& gps, double from_s, double to_s, double height_m) {
    std::vector<bool> fixes;
    for (auto tick = static_cast<std::uint64_t>(from_s / kStepS); tick * kStepS < to_s; ++tick) {
      snapshot.tick = tick;
      snapshot.state.world_from_body.position_m.z() = height_m;
      if (gps.next_due() != tick) continue;
      fixes.push_back(gps.read(snapshot, around()).valid);
      gps.record(snapshot, around());
    }
    return fixes;
  };
  NoisySensor gps = sensor(spec);
  EXPECT_EQ(run(gps, 0, 1, 0.1), (std::vector<bool>{true, true})) << "it had a fix before";
  EXPECT_EQ(run(gps, 1, 2, -0.1), (std::vector<bool>{false, false}));
  EXPECT_EQ(run(gps, 2, 5, 0.1), (std::vector<bool>{false, false, false, false, true, true})) << "2 s after 2 s";
  run(gps, 5, 26, -0.1);
  EXPECT_EQ(run(gps, 26, 32, 0.1), (std::vector<bool>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1})) << "5 s: cold";
}

/// The errors of an INS at rest, 10 per second: those of its position along x and y, and of its velocity.
class InsErrors : public Positioning {
 protected:
  std::vector<Eigen::Vector4d> errors(const SensorSpec& spec, double seconds, std::uint64_t seed = 7) {
    NoisySensor ins = sensor(spec, seed);
    std::vector<Eigen::Vector4d> found;
    for (std::uint64_t tick = 0; tick * kStepS <= seconds; tick = ins.next_due()) {
      snapshot.tick = tick;
      const std::vector<double>& read = ins.read(snapshot, around()).values;
      found.emplace_back(read[0], read[1], read[3], read[4]);
      ins.record(snapshot, around());
    }
    return found;
  }
  SensorSpec spec(const char* parameter, double value, double rate_hz = 10) {
    SensorSpec found = sensor_spec("ins", {{parameter, {value}}});
    found.rate_hz = rate_hz;
    return found;
  }
  static constexpr double kR = 6371008.8, kG = 9.80665;
  const double schuler = std::sqrt(kG / kR);
};

TEST_F(InsErrors, AtRestGrowAsInTheClosedFormsOfTittertonAndWeston) {
  EXPECT_NEAR(2 * std::numbers::pi / schuler / 60, 84.4, 0.05);
  const double end_s = 7200;
  const auto law = [&](const char* parameter, double value, auto&& shape, const char* what) {
    const std::vector<Eigen::Vector4d> found = errors(spec(parameter, value), end_s);
    const double quarter_s = std::numbers::pi / 2 / schuler;
    const auto at = [&](double t) { return found[static_cast<std::size_t>(std::lround(10 * t))].x(); };
    const double scale = at(quarter_s) / shape(quarter_s),
                 largest = std::abs(scale) * shape(std::numbers::pi / schuler);
    EXPECT_GT(std::abs(scale), 0) << what;
    for (double t = 0; t <= end_s; t += 60) EXPECT_NEAR(at(t), scale * shape(t), 2e-4 * largest) << what << " " << t;
    return scale;
  };
  const double w = schuler;
  law(
      "accelerometer_bias_ug", 100, [&](double t) { return (1 - std::cos(w * t)) / (w * w); }, "accelerometer bias");
  law(
      "gyro_bias_deg_h", 0.01, [&](double t) { return kR * (t - std::sin(w * t) / w); }, "gyroscope bias");
  law(
      "tilt_std_deg", 0.01, [&](double t) { return kR * (1 - std::cos(w * t)); }, "tilt");
  const auto moving = errors(spec("velocity_std_m_s", 0.1), 5000);
  const double quarter_s = std::numbers::pi / 2 / w;
  EXPECT_NEAR(moving[static_cast<std::size_t>(std::lround(10 * quarter_s))].x(), moving[0].z() / w,
              2e-4 * std::abs(moving[0].z() / w));
}

TEST_F(InsErrors, AreNotStatedOnceTheAttitudeIsOffByMoreThanSmallAngles) {
  NoisySensor ins = sensor(spec("gyro_bias_deg_h", 36000));
  bool ended = false;
  for (std::uint64_t tick = 0; tick * kStepS <= 60; tick = ins.next_due()) {
    snapshot.tick = tick;
    const Sample read = ins.read(snapshot, around());
    const double off_rad = 2 * std::acos(std::min(std::abs(read.values[9]), 1.0));
    EXPECT_FALSE(ended && read.valid) << "it does not come back";
    EXPECT_EQ(read.valid, off_rad <= 10 * std::numbers::pi / 180) << off_rad;
    ended = !read.valid;
    ins.record(snapshot, around());
  }
  EXPECT_TRUE(ended);
}

TEST_F(InsErrors, SpreadAsTheGradesFiguresState) {
  constexpr int kRuns = 100;
  const double t = 1800, w = schuler, us = 1e-6 * kG, hour = std::numbers::pi / 180 / 3600;
  const auto rms = [&](const char* parameter, double value) {
    double sum = 0;
    for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
      const Eigen::Vector4d last = errors(spec(parameter, value, 0.5), t, seed).back();
      sum += last.head<2>().squaredNorm() / 2;
    }
    return std::sqrt(sum / kRuns);
  };
  const double within = 4 / std::sqrt(4.0 * kRuns);  // four standard deviations of an rms of 2 x 100 draws
  const double bias = 100 * us * (1 - std::cos(w * t)) / (w * w);
  EXPECT_NEAR(rms("accelerometer_bias_ug", 100) / bias, 1, within);
  const double drift = 0.01 * hour * kR * (t - std::sin(w * t) / w);
  EXPECT_NEAR(rms("gyro_bias_deg_h", 0.01) / drift, 1, within);
  const double velocity_walk = 50 * us * std::sqrt(t / 2 - std::sin(2 * w * t) / (4 * w)) / w;
  EXPECT_NEAR(rms("accelerometer_noise_ug_sqrt_hz", 50) / velocity_walk, 1, within);
  const double angle_walk = 0.002 * std::numbers::pi / 180 / 60 * kR *
                            std::sqrt(1.5 * t - 2 * std::sin(w * t) / w + std::sin(2 * w * t) / (4 * w));
  EXPECT_NEAR(rms("gyro_random_walk_deg_sqrt_h", 0.002) / angle_walk, 1, within);
}

TEST_F(Positioning, AnAdcpMeasuresTheShearOfTheWaterAboveItsSideLobes) {
  world.water.currents.push_back(layered_current({0, 20}, {{0, 0, 0}, {1, -0.4, 0}}));
  snapshot.state.velocity_body << 1.2, -0.4, 0.1, 0, 0, 0;
  snapshot.state.world_from_body.orientation = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  const double slant = std::numbers::pi / 9;
  const std::vector<double> read = truth(sensor_spec("adcp", {{"cell_count", {12}}})).values;
  const Eigen::Matrix3d body_from_world = snapshot.state.world_from_body.orientation.toRotationMatrix().transpose();
  for (int cell = 0; cell < 12; ++cell) {
    const double down_m = 0.5 + cell + 0.5, depth_m = 12 + down_m;
    const Eigen::Vector3d through = Eigen::Vector3d::Map(&read[3 + 3 * static_cast<std::size_t>(cell)]);
    if (down_m + 0.5 > 8 * std::cos(slant)) {
      EXPECT_TRUE(std::isnan(through.x())) << cell << ": of the bed's side lobe";
      continue;
    }
    const Eigen::Vector3d expected =
        Eigen::Vector3d(1.2, -0.4, 0.1) - body_from_world * (depth_m / 20 * Eigen::Vector3d(1, -0.4, 0));
    EXPECT_LT((through - expected).norm(), 1e-9) << cell;
  }
  const std::vector<double> layer =
      truth(sensor_spec("adcp", {{"cell_count", {12}}, {"layer_near_m", {1.5}}, {"layer_far_m", {3.5}}})).values;
  EXPECT_LT((Eigen::Vector3d::Map(&layer[0]) - 0.5 * (Eigen::Vector3d::Map(&read[6]) + Eigen::Vector3d::Map(&read[9])))
                .norm(),
            1e-12);
}

}  // namespace
}  // namespace uwsim
