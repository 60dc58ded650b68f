#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/core/check.h"
#include "uwsim/estimation/navigation_filter.h"

namespace uwsim {
namespace {

constexpr double kGravity = 9.80665;
constexpr std::uint64_t kStep_ns = 5'000'000;
const Eigen::MatrixX3d kBeams{{0.5, 0, -0.87}, {0, 0.5, -0.87}, {-0.5, 0, -0.87}, {0, -0.5, -0.87}};
constexpr std::array<double, 6> kAtRest = {0, 0, 0, 0, 0, kGravity};

FilterStart known(double position_std = 0, double velocity_std = 0, double attitude_std = 0) {
  FilterStart start;
  start.position_std_m.setConstant(position_std);
  start.velocity_std_m_s = velocity_std;
  start.attitude_std_rad.setConstant(attitude_std);
  return start;
}

NavigationFilter at_rest(const ImuErrors& errors, const FilterStart& start, double seconds) {
  NavigationFilter filter(errors, Eigen::Vector3d::Zero(), kGravity);
  filter.start(start);
  for (std::uint64_t t = kStep_ns; t <= static_cast<std::uint64_t>(seconds * 1e9); t += kStep_ns) {
    filter.add_imu(t, kAtRest.data());
  }
  filter.catch_up();
  return filter;
}

TEST(NavigationFilter, LevelTurnsOnACircle) {
  NavigationFilter filter({}, Eigen::Vector3d(0.3, 0, 0), kGravity);
  FilterStart start;
  start.velocity_world_m_s = {1, 0.2 * 0.3, 0};  // of the IMU, 0.3 m ahead of the origin, which moves at 1 m/s
  filter.start(start);
  const double rate = 0.2, seconds = 2 * EIGEN_PI / rate;
  const std::array<double, 6> turning = {0, 0, rate, -rate * rate * 0.3, rate, kGravity};
  std::uint64_t t = 0;
  while (1e-9 * static_cast<double>(t) < seconds) filter.add_imu(t += kStep_ns, turning.data());
  filter.catch_up();
  EXPECT_LT(filter.position_body_origin_m().norm(), 0.02);  // a whole circle of 5 m radius
  EXPECT_NEAR(filter.velocity_body_m_s().x(), 1, 1e-3);
}

using Rate = std::function<Eigen::Vector3d(double)>;

/// Rotations at up to 2 rad/s: about any axis, back and forth, from rest, and about axes that rotate themselves.
std::vector<std::pair<std::string, Rate>> turns() {
  std::vector<std::pair<std::string, Rate>> made;
  const auto add = [&](std::string name, Rate rate) { made.emplace_back(std::move(name), std::move(rate)); };
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1),
                                      Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(-1, 2, 1), Eigen::Vector3d(1, -1, 3)}) {
    for (const double speed : {-2.0, 0.3, 1.0, 2.0}) {
      const Eigen::Vector3d w = speed * axis.normalized();
      add("steady " + std::to_string(w.x()) + " " + std::to_string(w.y()) + " " + std::to_string(w.z()),
          [w](double) { return w; });
    }
    const Eigen::Vector3d w = 2 * axis.normalized();
    add("to and fro", [w](double t) { return Eigen::Vector3d(std::sin(3 * t) * w); });
    add("from full swing", [w](double t) { return Eigen::Vector3d(std::cos(2 * t) * w); });
    add("from rest", [w](double t) { return Eigen::Vector3d(std::min(t, 1.0) * w); });
  }
  for (const double f : {0.3, 1.0, 3.0}) {
    add("tumbling " + std::to_string(f),
        [f](double t) { return Eigen::Vector3d(2 * std::sin(f * t), 2 * std::cos(f * t), 0); });
    add("tumbling and turning " + std::to_string(f),
        [f](double t) { return Eigen::Vector3d(1.4 * std::sin(f * t), 1.2 * std::cos(1.3 * f * t + 0.4), 0.7); });
  }
  return made;
}

/// The rotation over a step, integrated in many small parts, each to fourth order.
Eigen::Quaterniond turned(const Rate& rate, double t, double dt) {
  constexpr int kParts = 10;
  const double h = dt / kParts, early = 0.5 - std::sqrt(3.0) / 6;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (int k = 0; k < kParts; ++k) {
    const Eigen::Vector3d a = rate(t + (k + early) * h), b = rate(t + (k + 1 - early) * h);
    q = q * rotation_by(0.5 * h * (a + b) + std::sqrt(3.0) / 12 * h * h * a.cross(b));
  }
  return q;
}

struct Spin {
  double imu_ahead_m = 0;    ///< relative to the body's origin, which does not move
  std::uint64_t odd_ns = 0;  ///< uninformative readings follow every tenth sample by this time
  double averaging_s = 0;    ///< if not 0, samples are means over a step, along the axes at its end
};

/// The largest spurious velocity of the body's origin during 10 s of rotation without noise [m/s].
double false_velocity(const Rate& rate, const Spin& spin) {
  const Eigen::Vector3d arm(spin.imu_ahead_m, 0, 0), up(0, 0, kGravity);
  ImuErrors exact;
  exact.averaging_s = spin.averaging_s;
  NavigationFilter filter(exact, arm, kGravity);
  const int depth = filter.add_aid(depth_aid({}, 1e6, {}, {}));
  const auto at_imu = [&](double t) { return Eigen::Vector3d(rate(t).cross(arm)); };
  FilterStart start;
  start.velocity_world_m_s = at_imu(0);
  filter.start(start);
  constexpr double kDt = 1e-9 * kStep_ns, kTiny = 1e-4;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  double worst = 0;
  for (std::uint64_t k = 1; k <= 2000; ++k) {
    const double t = static_cast<double>(k) * kDt;
    const Eigen::Vector3d before = q * at_imu(t - kDt), w = rate(t);
    q = (q * turned(rate, t - kDt, kDt)).normalized();
    const Eigen::Vector3d spinning_up = (rate(t + kTiny) - rate(t - kTiny)) / (2 * kTiny);
    Eigen::Vector3d acceleration = spinning_up.cross(arm) + w.cross(w.cross(arm));
    if (spin.averaging_s > 0) acceleration = (at_imu(t) - q.conjugate() * before) / kDt;
    const Eigen::Vector3d force = acceleration + q.conjugate() * up;
    const std::array<double, 6> sample = {w.x(), w.y(), w.z(), force.x(), force.y(), force.z()};
    filter.add_imu(k * kStep_ns, sample.data());
    const double nothing = 0;
    if (k % 10 == 1 && spin.odd_ns > 0) {
      const std::uint64_t odd = (k - 1) * kStep_ns + spin.odd_ns;
      filter.add_reading(depth, odd, odd, &nothing);
    }
    filter.catch_up();
    worst = std::max(worst, filter.velocity_body_m_s().norm());
  }
  return worst;
}

/// A body that rotates on the spot stays in place according to a filter with an error-free IMU.
TEST(NavigationFilter, ATurnWithoutNoiseMakesNoVelocity) {
  for (const auto& [name, rate] : turns()) {
    EXPECT_LT(false_velocity(rate, {}), 1e-3) << name;
    EXPECT_LT(false_velocity(rate, {.odd_ns = 1'700'000}), 1e-3) << name << ", with readings between samples";
    EXPECT_LT(false_velocity(rate, {.imu_ahead_m = 0.3}), 1e-3) << name << ", the IMU 0.3 m ahead";
    EXPECT_LT(false_velocity(rate, {.imu_ahead_m = 0.3, .averaging_s = 0.005}), 1e-3)
        << name << ", the IMU 0.3 m ahead, its samples means";
  }
}

/// Errors of scale and alignment act as biases in proportion to what is measured: at rest, s g t^2 / 2 up and m g t^2 /
/// 2 aside; of an IMU that is mounted at 45 degrees, two axes share the weight. A turn by w t errs by s w t.
TEST(NavigationFilter, ErrorsOfScaleAndAlignmentGrowWithForceAndRate) {
  constexpr double kScale = 0.01, kTilt = 0.002, kRate = 0.3, kTime = 20;
  const auto std_of = [](const NavigationFilter& f, int k) { return std::sqrt(f.state().covariance(k, k)); };
  const double way = kGravity * kTime * kTime / 2;
  ImuErrors errors;
  errors.matrices[2] = {kScale, kTilt};
  EXPECT_NEAR(std_of(at_rest(errors, known(), kTime), kPosition + 2) / (kScale * way), 1, 1e-3);
  EXPECT_NEAR(std_of(at_rest(errors, known(), kTime), kPosition) / (kTilt * way), 1, 1e-3);
  errors.matrices[2] = {kScale, 0};
  errors.body_from_imu = Eigen::AngleAxisd(EIGEN_PI / 4, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NEAR(std_of(at_rest(errors, known(), kTime), kPosition + 2) / (kScale * way), std::sqrt(0.5), 1e-3);
  ImuErrors gyroscope;
  gyroscope.matrices[0] = {kScale, 0};
  NavigationFilter turning(gyroscope, Eigen::Vector3d::Zero(), kGravity);
  turning.start(known());
  const std::array<double, 6> sample = {0, 0, kRate, 0, 0, kGravity};
  for (std::uint64_t k = 1; k <= 4000; ++k) turning.add_imu(k * kStep_ns, sample.data());
  turning.catch_up();
  EXPECT_NEAR(std_of(turning, kAttitude + 2) / (kScale * kRate * kTime), 1, 1e-3);
}

/// If white noise of the accelerometer, with density s, is the only error, velocity is a random walk with standard
/// deviation s sqrt(t), and position is its integral, with s sqrt(t^3 / 3).
TEST(NavigationFilter, WhiteForceNoiseGrowsAsARandomWalk) {
  ImuErrors errors;
  errors.force_std = 0.2;
  const double density = errors.force_std * std::sqrt(errors.period_s), t = 20;
  const auto filter = at_rest(errors, known(), t);
  const ErrorMatrix& p = filter.state().covariance;
  EXPECT_NEAR(std::sqrt(p(kVelocity, kVelocity)), density * std::sqrt(t), 0.01 * density * std::sqrt(t));
  const double expected = density * std::sqrt(t * t * t / 3);
  EXPECT_NEAR(std::sqrt(p(kPosition, kPosition)), expected, 0.01 * expected);
}

/// A tilt error e makes gravity appear as an acceleration g e.
TEST(NavigationFilter, ATiltErrorBecomesAPositionError) {
  const double tilt = 1e-3, t = 10;
  const auto filter = at_rest({}, known(0, 0, tilt), t);
  const double expected = 0.5 * kGravity * tilt * t * t;
  EXPECT_NEAR(std::sqrt(filter.state().covariance(kPosition, kPosition)), expected, 0.01 * expected);
}

TEST(NavigationFilter, ABiasInBothPartsGrowsAsItsDriftDoes) {
  const BiasModel drift{.turn_on_std = 0, .drift_std = 0.1, .drift_time_s = 5, .walk = 0};
  EXPECT_NEAR(drift.decay(5), std::exp(-1), 1e-12);
  EXPECT_NEAR(drift.growth(1e9), 0.01, 1e-12);  // stationary
  const BiasModel both{.turn_on_std = 1, .drift_std = 0.1, .drift_time_s = 5, .walk = 0};
  EXPECT_EQ(both.decay(5), 1);
  EXPECT_NEAR(both.growth(0.01), drift.growth(0.01), 0.01 * drift.growth(0.01));
}

/// While the vehicle faces east, its own magnetic field along the body rotates the compass, but the field across it
/// does not. Noisy readings at that heading must therefore not reveal the field across.
TEST(NavigationFilter, OneHeadingTellsNothingOfTheFieldAcrossIt) {
  constexpr double kIron = 0.02, kNoise = 0.005;
  NavigationFilter filter({}, Eigen::Vector3d::Zero(), kGravity);
  const int compass =
      filter.add_aid(heading_aid(Eigen::Vector3d::UnitX(), kNoise, {0.01, 0, 0, 0}, kIron, EIGEN_PI / 2));
  filter.start(known(0, 0, 0.02));
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (std::uint64_t k = 1; k <= 12000; ++k) {
    filter.add_imu(k * kStep_ns, kAtRest.data());
    const double reading = kNoise * normal(random);
    if (k % 4 == 0) filter.add_reading(compass, k * kStep_ns, k * kStep_ns, &reading);
    filter.catch_up();
  }
  const int across = kAidBias + 2;
  EXPECT_NEAR(std::sqrt(filter.state().covariance(across, across)), kIron, 0.01 * kIron);
  EXPECT_NEAR(filter.state().aid_bias[across - kAidBias], 0, 0.1 * kIron);
}

/// A vehicle's own magnetic field that points up rotates the compass once the vehicle pitches down, by its horizontal
/// component. A yaw estimate that was accurate while the vehicle was level must not follow that rotation.
TEST(NavigationFilter, AFieldUpwardsIsNotTakenForATurnWhenTheVehiclePitches) {
  constexpr double kUpwards = 0.03, kNoise = 0.005, kPitchRate = 0.5, kDown_s = 2;
  ImuErrors errors;
  errors.rate_std = 1e-4;
  NavigationFilter filter(errors, Eigen::Vector3d::Zero(), kGravity);
  const int compass = filter.add_aid(heading_aid(Eigen::Vector3d::UnitX(), kNoise, {}, 0.02, EIGEN_PI / 2));
  filter.start(known(0, 0, 0.002));
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  double pitch = 0;
  for (std::uint64_t k = 1; k <= 12000; ++k) {
    const double t = 1e-9 * static_cast<double>(k * kStep_ns), since = t - 20;
    pitch = kPitchRate * std::clamp(since, 0.0, kDown_s);
    const double rate = since > 0 && since <= kDown_s ? kPitchRate : 0;
    const std::array<double, 6> imu = {0, rate, 0, -kGravity * std::sin(pitch), 0, kGravity * std::cos(pitch)};
    filter.add_imu(k * kStep_ns, imu.data());
    const double reading = kUpwards * std::sin(pitch) + kNoise * normal(random);
    if (k % 4 == 0) filter.add_reading(compass, k * kStep_ns, k * kStep_ns, &reading);
    filter.catch_up();
  }
  const FilterState& state = filter.state();
  const Eigen::AngleAxisd down(pitch, Eigen::Vector3d::UnitY());
  const Eigen::AngleAxisd error(state.orientation.conjugate() * down);
  const Eigen::Vector3d attitude = error.angle() * error.axis();
  const Eigen::Matrix3d covariance = state.covariance.block<3, 3>(kAttitude, kAttitude);
  EXPECT_LT(attitude.dot(covariance.inverse() * attitude), 11.3);  // chi-square, 3 degrees of freedom, 1 in 100
  EXPECT_LT(attitude.norm(), 0.3 * kUpwards * std::sin(pitch));
}

/// Fixes that arrive late and out of order lead to the same state, bit for bit, as fixes that arrive in time.
TEST(NavigationFilter, TheOrderOfArrivalDoesNotMatter) {
  const auto made = [](bool late) {
    ImuErrors errors{.rate_std = 1e-3,
                     .force_std = 1e-2,
                     .period_s = 0.005,
                     .rate_bias = {1e-3, 0, 0, 0},
                     .force_bias = {0.02, 0, 0, 0}};
    auto filter = std::make_unique<NavigationFilter>(errors, Eigen::Vector3d::Zero(), kGravity);
    const int fix = filter->add_aid(acoustic_fix_aid({0.1, 0, 0.2}, {0.1, 0.02}));
    const int depth = filter->add_aid(depth_aid({0, 0, 0.1}, 0.01, {0.02, 0, 0, 0}, {.wave_std_m = 0.1}));
    filter->start(known(1, 0.1, 0.01));
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<std::pair<std::uint64_t, std::array<double, 6>>> waiting;
    for (std::uint64_t k = 1; k <= 4000; ++k) {
      const std::uint64_t t = k * kStep_ns;
      std::array<double, 6> imu = kAtRest;
      for (double& value : imu) value += 0.01 * normal(random);
      filter->add_imu(t, imu.data());
      if (k % 10 == 0) {
        const double reading = 0.01 * normal(random);
        filter->add_reading(depth, t - 2'000'000, t, &reading);
      }
      if (k % 200 == 0) waiting.push_back({t, {-5 + 0.1 * normal(random), -5, 0.1, 5, 5, 0}});
      while (!waiting.empty() && waiting.front().first + (late ? 1'500'000'000u : 0u) <= t) {
        filter->add_reading(fix, waiting.front().first, t, waiting.front().second.data());
        waiting.erase(waiting.begin());
      }
      if (!late || k % 7 == 0) filter->catch_up();
    }
    for (const auto& [t, reading] : waiting) filter->add_reading(fix, t, t, reading.data());
    filter->catch_up();
    return filter;
  };
  const auto in_time = made(false), late = made(true);
  EXPECT_EQ(in_time->state().position_m, late->state().position_m);
  EXPECT_EQ(in_time->state().covariance, late->state().covariance);
  EXPECT_EQ(in_time->state().counts[0].accepted, late->state().counts[0].accepted);
  NavigationFilter copy(ImuErrors{.rate_std = 1e-3,
                                  .force_std = 1e-2,
                                  .period_s = 0.005,
                                  .rate_bias = {1e-3, 0, 0, 0},
                                  .force_bias = {0.02, 0, 0, 0}},
                        Eigen::Vector3d::Zero(), kGravity);
  EXPECT_THROW(copy.restore(late->save()), InvalidValue);  // it has no aids
}

/// Sound that came by the bed has the range and the elevation of a mirrored station, fix after fix. The depth knows
/// better, so that such fixes never make the filter doubt itself; a fix by the direct path is used again at once.
TEST(NavigationFilter, FixesByTheBedAreLeftOutHoweverOftenTheyRepeat) {
  const ImuErrors errors{.rate_std = 1e-4,
                         .force_std = 1e-3,
                         .period_s = 0.005,
                         .rate_bias = {1e-5, 0, 0, 0},
                         .force_bias = {1e-3, 0, 0, 0}};
  NavigationFilter filter(errors, Eigen::Vector3d::Zero(), kGravity);
  const double distance = 350, bed = 60;
  const int fix = filter.add_aid(acoustic_fix_aid({0, 0, 0}, {0.1, 0.02}));
  const int depth = filter.add_aid(depth_aid({0, 0, 0}, 0.02, {0.02, 0, 0, 0}, {}));
  filter.start(known(1, 0.1, 0.01));
  const std::array<double, 6> direct{-distance, 0, 0, distance}, by_the_bed{-distance, 0, -2 * bed, distance};
  for (std::uint64_t k = 1; k <= 12000; ++k) {
    filter.add_imu(k * kStep_ns, kAtRest.data());
    const double at_surface = 0;
    if (k % 10 == 0) filter.add_reading(depth, k * kStep_ns, k * kStep_ns, &at_surface);
    const bool is_direct = k <= 1000 || k > 11000;
    if (k % 200 == 0) filter.add_reading(fix, k * kStep_ns, k * kStep_ns, (is_direct ? direct : by_the_bed).data());
    filter.catch_up();
  }
  EXPECT_EQ(filter.state().doubts, 0u);
  EXPECT_LT(filter.state().position_m.norm(), 1.0);
  EXPECT_LT(filter.state().velocity_m_s.norm(), 0.1);
  const AidCounts& counts = filter.state().counts[static_cast<std::size_t>(fix)];
  EXPECT_EQ(counts.rejected, 3u * 50u);
  EXPECT_EQ(counts.accepted, 3u * 10u);
}

TEST(NavigationFilter, AnOutlierIsLeftOutUntilItRepeats) {
  NavigationFilter filter({}, Eigen::Vector3d::Zero(), kGravity);
  const int depth = filter.add_aid(depth_aid(Eigen::Vector3d::Zero(), 0.01, {}, {.wave_std_m = 0.1}));
  filter.start(known(0.01));
  const double far = 3;
  for (std::uint64_t k = 1; k <= 5; ++k) {
    filter.add_imu(k * kStep_ns, kAtRest.data());
    filter.add_reading(depth, k * kStep_ns, k * kStep_ns, &far);
    filter.catch_up();
    EXPECT_EQ(filter.state().position_m.z() == 0, k < 5);
  }
  EXPECT_NEAR(filter.state().position_m.z(), -3, 0.1);
}

/// A collision that exceeds the accelerometer's limits hides part of the change in velocity. The next DVL ping must not
/// be treated as an outlier, and the biases must not be adjusted because of it.
TEST(NavigationFilter, AShockBeyondTheLimitsIsNotBelieved) {
  ImuErrors errors;
  errors.rate_std = 1e-3;
  errors.force_std = 1e-2;
  errors.force_bias.turn_on_std = 0.02;
  errors.force_limit = 40;
  NavigationFilter filter(errors, Eigen::Vector3d::Zero(), kGravity);
  const int dvl = filter.add_aid(doppler_aid(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(), {.std = 0.01}));
  filter.start(known(0.01, 0.01, 0.01));
  std::array<double, 6> stopped = kAtRest;
  stopped[3] = -40;  // actually -200: 1 m/s is lost, of which 0.8 are not measured
  const std::array<double, 3> still = {-1, 0, 0};
  for (std::uint64_t k = 1; k <= 100; ++k) {
    const std::uint64_t now = k * kStep_ns;
    filter.add_imu(now, k == 10 ? stopped.data() : kAtRest.data());
    if (k % 20 == 0) filter.add_reading(dvl, now, now, still.data());
  }
  filter.catch_up();
  EXPECT_EQ(filter.state().counts[static_cast<std::size_t>(dvl)].rejected, 0U);
  EXPECT_NEAR(filter.state().velocity_m_s.x(), -1, 0.02);
  EXPECT_LT(filter.state().force_bias_m_s2.norm(), 0.06);
}

/// Velocities that are known show how the log is mounted, and how its scale errs.
TEST(NavigationFilter, AKnownVelocityShowsScaleAndMisalignment) {
  NavigationFilter filter({}, Eigen::Vector3d::Zero(), kGravity);
  const int dvl = filter.add_aid(
      doppler_aid(kBeams, Eigen::Vector3d::Zero(),
                  {.std = 0.001, .scale = {.turn_on_std = 0.05}, .misalignment = {.turn_on_std = 0.05}}));
  const int first = filter.first_bias(dvl) - kAidBias;
  FilterStart start = known(0.01, 1e-5, 1e-5);
  start.velocity_world_m_s = {1, 0.5, 0};
  filter.start(start);
  const double scale = 0.02;
  const Eigen::Vector3d turn(0, 0, 0.03);
  const Eigen::Vector4d along =
      (1 + scale) * (kBeams * (start.velocity_world_m_s + start.velocity_world_m_s.cross(turn)));
  for (std::uint64_t k = 1; k <= 200; ++k) {
    filter.add_imu(k * kStep_ns, kAtRest.data());
    if (k % 20 == 0) filter.add_reading(dvl, k * kStep_ns, k * kStep_ns, along.data());
  }
  filter.catch_up();
  EXPECT_NEAR(filter.state().aid_bias[first + 4], scale, 1e-3);
  EXPECT_NEAR(filter.state().aid_bias[first + 7], turn.z(), 1e-3);
}

/// The velocity error lies between the beams, so only two of the four beams observe it.
TEST(NavigationFilter, AnErrorThatHalfTheBeamsSeeMakesItDoubt) {
  NavigationFilter filter({}, Eigen::Vector3d::Zero(), kGravity);
  const int dvl = filter.add_aid(doppler_aid(kBeams, Eigen::Vector3d::Zero(), {.std = 0.01}));
  filter.start(known(0.01, 0.01, 0));
  // at 2 m/s, while the filter estimates that it is at rest
  const std::array<double, 4> ahead = {0.5 * 2, 0, -0.5 * 2, 0};
  for (std::uint64_t k = 1; k <= 120; ++k) {
    filter.add_imu(k * kStep_ns, kAtRest.data());
    if (k % 20 == 0) filter.add_reading(dvl, k * kStep_ns, k * kStep_ns, ahead.data());
  }
  filter.catch_up();
  EXPECT_NEAR(filter.state().velocity_m_s.x(), 2, 0.05);
}

/// One bad beam of four is rejected permanently.
TEST(NavigationFilter, OneBadBeamMakesItNotDoubt) {
  NavigationFilter filter({}, Eigen::Vector3d::Zero(), kGravity);
  const int dvl = filter.add_aid(doppler_aid(kBeams, Eigen::Vector3d::Zero(), {.std = 0.01}));
  filter.start(known(0.01, 0.01, 0));
  const std::array<double, 4> bad = {1, 0, 0, 0};
  for (std::uint64_t k = 1; k <= 400; ++k) {
    filter.add_imu(k * kStep_ns, kAtRest.data());
    if (k % 20 == 0) filter.add_reading(dvl, k * kStep_ns, k * kStep_ns, bad.data());
  }
  filter.catch_up();
  EXPECT_LT(filter.state().velocity_m_s.norm(), 0.01);
  EXPECT_EQ(filter.state().doubts, 0U);
}

/// Two filters have as many errors, but one has a scale of its DVL, the other of its fixes.
TEST(NavigationFilter, AStateOfOtherBiasesIsRefused) {
  const auto filter = [](double doppler_scale, double fix_scale) {
    NavigationFilter made({}, Eigen::Vector3d::Zero(), kGravity);
    made.add_aid(doppler_aid(Eigen::MatrixX3d::Identity(3, 3), {0, 0, 0}, {.std = 1, .scale = {doppler_scale}}));
    made.add_aid(acoustic_fix_aid({0, 0, 0}, {.range_std_m = 1, .scale = {fix_scale}}));
    made.start(known());
    return made;
  };
  EXPECT_NO_THROW(filter(1, 0).restore(filter(2, 0).save()));
  EXPECT_THROW(filter(1, 0).restore(filter(0, 1).save()), InvalidValue);
}

}  // namespace
}  // namespace uwsim
