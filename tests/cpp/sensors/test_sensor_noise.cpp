#include <atomic>
#include <cstdlib>
#include <functional>
#include <new>

#include "sensors/sensor_bench.h"
#include "uwsim/sensors/sensor_rack.h"

namespace {
std::atomic<std::size_t> allocations = 0;
}

// Under ThreadSanitizer not: Embree's own threads would call these, and it would not see that a library is the caller.
#if !defined(__SANITIZE_THREAD__)
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace uwsim {
namespace {

using SensorNoise = SensorBench;

SensorSpec depth_with(const NoiseSpec& noise) {
  SensorSpec spec = sensor_spec("depth");
  spec.noise["depth"] = noise;
  return spec;
}

/// Overlapping Allan variance of a rate series at one cluster length (IEEE Std 952-1997, annex C).
double allan_variance(const std::vector<double>& integral, double dt, std::size_t m) {
  double sum = 0;
  const std::size_t count = integral.size() - 2 * m;
  for (std::size_t k = 0; k < count; ++k) {
    const double second = integral[k + 2 * m] - 2 * integral[k + m] + integral[k];
    sum += second * second;
  }
  const double tau = static_cast<double>(m) * dt;
  return sum / (2 * tau * tau * static_cast<double>(count));
}

/// Gauss-Markov noise with a standard deviation of 1 (ibid., B.4.1.5, with q^2 = 2 / T).
double gauss_markov_allan(double tau, double time) {
  const double r = time / tau;
  return 2 * r * (1 - 0.5 * r * (3 - 4 * std::exp(-1 / r) + std::exp(-2 / r)));
}

class AllanDeviation : public SensorBench {
 protected:
  static constexpr int kSamples = 1 << 19;

  /// Mean over the axes of the gyroscope in a stationary IMU.
  std::vector<double> variances(const NoiseSpec& noise, double rate_hz, const std::vector<std::size_t>& clusters) {
    SensorSpec spec = sensor_spec("imu");
    spec.noise["angular_velocity"] = noise;
    spec.rate_hz = rate_hz;
    NoisySensor imu = sensor(spec);
    std::vector<std::vector<double>> integrals(3, {0.0});
    for (int k = 0; k < kSamples; ++k) {
      snapshot.tick = static_cast<std::uint64_t>(std::llround(k / (rate_hz * kStepS)));
      const Sample& sample = imu.read(snapshot, around());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        integrals[axis].push_back(integrals[axis].back() + sample.values[axis] / rate_hz);
      }
    }
    std::vector<double> means;
    for (const std::size_t m : clusters) {
      double mean = 0;
      for (const auto& integral : integrals) mean += allan_variance(integral, 1 / rate_hz, m) / 3;
      means.push_back(mean);
    }
    return means;
  }

  /// Least-squares fit of measured = a first(tau) + b second(tau), with relative weights.
  static Eigen::Vector2d fit(const std::vector<double>& measured, const std::vector<std::size_t>& clusters,
                             double rate_hz, const std::function<double(double)>& first,
                             const std::function<double(double)>& second) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < clusters.size(); ++k) {
      const double tau = static_cast<double>(clusters[k]) / rate_hz;
      const Eigen::Vector2d row(first(tau) / measured[k], second(tau) / measured[k]);
      normal += row * row.transpose();
      right += row;
    }
    return normal.inverse() * right;
  }
};

TEST_F(AllanDeviation, RecoversDensityAndBiasInstability) {
  constexpr double kDensity = 1e-3, kBias = 2e-3, kTime = 4, kRate = 20;
  const std::vector<std::size_t> clusters = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512};
  const auto measured = variances({.density = kDensity, .bias_std = kBias, .bias_time_s = kTime}, kRate, clusters);
  // The correlation time of the best fit.
  double best_time = 0, best_misfit = 1e300;
  Eigen::Vector2d best = Eigen::Vector2d::Zero();
  for (double time = 1; time < 16; time *= 1.02) {
    const auto white = [](double tau) { return 1 / tau; };
    const auto bias = [&](double tau) { return gauss_markov_allan(tau, time); };
    const Eigen::Vector2d found = fit(measured, clusters, kRate, white, bias);
    double misfit = 0;
    for (std::size_t k = 0; k < clusters.size(); ++k) {
      const double tau = static_cast<double>(clusters[k]) / kRate;
      misfit += std::pow((found(0) * white(tau) + found(1) * bias(tau)) / measured[k] - 1, 2);
    }
    if (misfit < best_misfit) {
      best_misfit = misfit;
      best_time = time;
      best = found;
    }
  }
  EXPECT_NEAR(std::sqrt(best(0)), kDensity, 0.1 * kDensity);
  EXPECT_NEAR(std::sqrt(best(1)), kBias, 0.1 * kBias);
  EXPECT_NEAR(best_time, kTime, 0.1 * kTime);
}

TEST_F(AllanDeviation, RecoversDensityAndRateRandomWalk) {
  constexpr double kDensity = 1e-3, kWalk = 1e-3, kRate = 20;
  const std::vector<std::size_t> clusters = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024};
  const auto measured = variances({.density = kDensity, .walk = kWalk}, kRate, clusters);
  const Eigen::Vector2d found = fit(
      measured, clusters, kRate, [](double tau) { return 1 / tau; }, [](double tau) { return tau / 3; });
  EXPECT_NEAR(std::sqrt(found(0)), kDensity, 0.1 * kDensity);
  EXPECT_NEAR(std::sqrt(found(1)), kWalk, 0.1 * kWalk);
}

TEST_F(AllanDeviation, FlickerNoiseHasAFlatFloorBetweenDensityAndWalk) {
  constexpr double kFloor = 2e-3, kDensity = 1e-3, kWalk = 2e-5, kRate = 4;
  std::vector<std::size_t> clusters;
  for (std::size_t m = 4; m <= 16384; m *= 2) clusters.push_back(m);
  const auto alone = variances({.instability = kFloor}, kRate, clusters);
  const auto all = variances({.density = kDensity, .walk = kWalk, .instability = kFloor}, kRate, clusters);
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    const double tau = static_cast<double>(clusters[k]) / kRate,
                 averaged = 3 * kSamples / static_cast<double>(clusters[k]);
    const double tolerance = 0.04 + 3 / std::sqrt(2 * averaged);  // the ripple, and three standard errors
    EXPECT_NEAR(std::sqrt(alone[k]), kFloor, tolerance * kFloor) << tau << " s";
    const double expected = std::sqrt(kDensity * kDensity / tau + kFloor * kFloor + kWalk * kWalk * tau / 3);
    EXPECT_NEAR(std::sqrt(all[k]), expected, tolerance * expected) << tau << " s";
  }
}

TEST_F(AllanDeviation, TheFlickerNoiseHasTheStatedDeviation) {
  double squares = 0;
  constexpr int kRuns = 4000;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const double bias = sensor(depth_with({.instability = 0.1}), run).read(snapshot, around()).values[0] - 12;
    squares += bias * bias;
  }
  const double expected = NoiseSpec::kFlickerStd * 0.1;
  EXPECT_NEAR(std::sqrt(squares / kRuns), expected, expected * 5 / std::sqrt(2.0 * kRuns));
  EXPECT_DOUBLE_EQ(NoiseSpec::kFlickerStd, std::sqrt(static_cast<double>(std::size(NoiseSpec::kFlickerTimes_s))));
}

TEST_F(AllanDeviation, TheTurnOnBiasIsConstantInARunAndVariesBetweenRuns) {
  double squares = 0;
  constexpr int kRuns = 4000;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    NoisySensor depth = sensor(depth_with({.turn_on_std = 0.2}), run);
    const double bias = depth.read(snapshot, around()).values[0] - 12;
    snapshot.tick += 1000;
    EXPECT_EQ(depth.read(snapshot, around()).values[0] - 12, bias);
    squares += bias * bias;
  }
  EXPECT_NEAR(std::sqrt(squares / kRuns), 0.2, 0.2 * 5 / std::sqrt(2.0 * kRuns));
}

TEST_F(SensorNoise, NoiseHasItsDeviationAndIsUncorrelatedBetweenSensorNames) {
  SensorSpec first = depth_with({.std = 0.04, .bias_std = 0.03, .bias_time_s = 2 * kStepS}), second = first;
  second.name = "spare";
  NoisySensor a = sensor(first), b = sensor(second);
  double squares = 0, products = 0;
  constexpr int kSamples = 50'000;
  for (snapshot.tick = 0; snapshot.tick < kSamples; ++snapshot.tick) {
    const double x = (a.read(snapshot, around()).values[0] - 12) / 0.05;
    squares += x * x;
    products += x * (b.read(snapshot, around()).values[0] - 12) / 0.05;
  }
  EXPECT_NEAR(squares / kSamples, 1, 10 * std::sqrt(2.0 / kSamples));
  EXPECT_NEAR(products / kSamples, 0, 10 / std::sqrt(kSamples));
}

TEST_F(SensorNoise, ReadingsAreMultiplesOfTheQuantumWithinTheLimits) {
  SensorSpec spec = depth_with({.std = 1, .quantum = 0.25, .limit_low = 11, .limit_high = 12.5});
  NoisySensor depth = sensor(spec);
  int at_low = 0, at_high = 0;
  constexpr int kSamples = 20'000;
  for (snapshot.tick = 0; snapshot.tick < kSamples; ++snapshot.tick) {
    const double value = depth.read(snapshot, around()).values[0];
    EXPECT_EQ(value, 0.25 * std::round(value / 0.25));
    EXPECT_TRUE(value >= 11 && value <= 12.5);
    at_low += value == 11;
    at_high += value == 12.5;
  }
  EXPECT_NEAR(at_low / double{kSamples}, 0.5 * std::erfc(0.875 / std::sqrt(2)), 0.015);
  EXPECT_NEAR(at_high / double{kSamples}, 0.5 * std::erfc(0.375 / std::sqrt(2)), 0.015);
}

TEST_F(SensorNoise, SamplesDependOnTimeAndNotOnReads) {
  SensorSpec spec = depth_with({.std = 0.1, .bias_std = 0.2, .bias_time_s = 1, .walk = 0.1});
  spec.rate_hz = 30;  // does not divide the step rate
  spec.latency_s = 0.04;
  spec.drop_out = 0.2;
  NoisySensor often = sensor(spec), seldom = sensor(spec);
  for (snapshot.tick = 0; snapshot.tick < 2000; ++snapshot.tick) {
    snapshot.state.world_from_body.position_m.z() = -12 - 1e-3 * static_cast<double>(snapshot.tick);
    for (NoisySensor* each : {&often, &seldom}) {
      if (snapshot.tick >= each->next_due()) each->record(snapshot, around());
    }
    const Sample first = often.read(snapshot, around());
    const Sample again = often.read(snapshot, around());
    EXPECT_EQ(first.values, again.values);
    if (snapshot.tick % 317 != 0) continue;
    const Sample rare = seldom.read(snapshot, around());
    EXPECT_EQ(rare.values, first.values);
    EXPECT_EQ(rare.stamp_ns, first.stamp_ns);
    EXPECT_EQ(rare.valid, first.valid);
  }
}

TEST_F(SensorNoise, ASampleIsHeldUntilTheNextAndTheMeanRateIsExact) {
  world.water.compressible = false;  // depth serves as the clock here, so readings must be exact
  SensorSpec spec = sensor_spec("depth");
  spec.rate_hz = 30;
  NoisySensor depth = sensor(spec);
  std::uint64_t samples = 0, last_ns = ~std::uint64_t{0};
  for (snapshot.tick = 0; snapshot.tick < 2000; ++snapshot.tick) {  // 10 s
    snapshot.state.world_from_body.position_m.z() = -static_cast<double>(snapshot.tick) * kStepS;
    if (snapshot.tick >= depth.next_due()) depth.record(snapshot, around());
    const Sample& sample = depth.read(snapshot, around());
    ASSERT_NEAR(sample.values[0], 1e-9 * static_cast<double>(sample.stamp_ns), 1e-9) << "the value at its own stamp";
    ASSERT_LT(snapshot.tick * kStepNs - sample.stamp_ns, 33'333'334u);
    samples += sample.stamp_ns != last_ns;
    last_ns = sample.stamp_ns;
  }
  EXPECT_NEAR(static_cast<double>(samples), 300, 1);
}

TEST_F(SensorNoise, WithLatencyAReadingShowsThePast) {
  SensorSpec spec = sensor_spec("velocity");
  spec.latency_s = 0.15;
  spec.rate_hz = 50;
  NoisySensor velocity = sensor(spec);
  for (snapshot.tick = 0; snapshot.tick < 400; ++snapshot.tick) {
    const double now_s = static_cast<double>(snapshot.tick) * kStepS;
    snapshot.state.velocity_body(0) = 0.8 * now_s;
    if (snapshot.tick >= velocity.next_due()) velocity.record(snapshot, around());
    const Sample& sample = velocity.read(snapshot, around());
    ASSERT_EQ(sample.valid, now_s > 0.15 - 1e-9) << "nothing has arrived before";
    if (!sample.valid) continue;
    const double sampled_s = 0.02 * std::floor((now_s - 0.15) / 0.02 + 1e-9);
    ASSERT_NEAR(sample.values[0], 0.8 * sampled_s, 1e-12);
    ASSERT_NEAR(1e-9 * static_cast<double>(sample.stamp_ns), sampled_s, 1e-12);
  }
}

TEST_F(SensorNoise, AUsblFixArrivesAfterTheTwoWayTravelTime) {
  // The ray is an arc whose lowest point is beyond the vehicle, so it stays between the surface and the vehicle.
  const double top_m_s = 1450, bottom_m_s = 1450.6, gradient_1_s = (bottom_m_s - top_m_s) / 12;
  const double depths[] = {0, 12}, speeds[] = {top_m_s, bottom_m_s};
  sound = SoundSpeedProfile(depths, speeds);
  station_world_m = {-800, 0, 0};
  SensorSpec spec = sensor_spec("usbl");
  spec.rate_hz = 5;
  NoisySensor usbl = sensor(spec);
  const double chord_m = gradient_1_s * std::hypot(800, 12);
  const double travel_s = 2 / gradient_1_s * std::acosh(1 + chord_m * chord_m / (2 * top_m_s * bottom_m_s));
  for (snapshot.tick = 0; snapshot.tick < 800; ++snapshot.tick) {
    if (snapshot.tick >= usbl.next_due()) usbl.record(snapshot, around());
    const double now_s = static_cast<double>(snapshot.tick) * kStepS;
    const Sample& sample = usbl.read(snapshot, around());
    ASSERT_EQ(sample.valid, now_s >= travel_s) << now_s;
    if (sample.valid) {
      ASSERT_NEAR(1e-9 * static_cast<double>(sample.stamp_ns), 0.2 * std::floor((now_s - travel_s) / 0.2), 1e-9);
    }
  }
}

TEST_F(SensorNoise, TheShareOfDroppedSamplesIsAsGivenAndTheLastOtherSampleIsHeld) {
  world.water.compressible = false;  // depth serves as the clock here, so readings must be exact
  SensorSpec spec = sensor_spec("depth");
  spec.drop_out = 0.3;
  spec.rate_hz = 100;
  NoisySensor depth = sensor(spec);
  int lost = 0, longest_hold = 0;
  constexpr int kSamples = 20'000;
  for (snapshot.tick = 0; snapshot.tick < 2 * kSamples; ++snapshot.tick) {
    snapshot.state.world_from_body.position_m.z() = -static_cast<double>(snapshot.tick + 1) * kStepS;
    if (snapshot.tick >= depth.next_due()) depth.record(snapshot, around());
    if (snapshot.tick % 2) continue;
    const Sample& sample = depth.read(snapshot, around());
    lost += !sample.valid;
    const auto age = static_cast<int>((snapshot.tick * kStepNs - sample.stamp_ns) / (2 * kStepNs));
    ASSERT_TRUE(snapshot.tick == 0 || sample.valid == (age == 0));
    ASSERT_NEAR(sample.values[0], 1e-9 * static_cast<double>(sample.stamp_ns) + kStepS, 1e-9);
    longest_hold = std::max(longest_hold, age);
  }
  EXPECT_NEAR(lost / double{kSamples}, 0.3, 5 * std::sqrt(0.3 * 0.7 / kSamples));
  EXPECT_GE(longest_hold, 4) << "more samples than the ring holds";
}

TEST_F(SensorNoise, SteppingAndReadingDoNotAllocateMemory) {
  std::vector<SensorSpec> specs = {sensor_spec("imu"), sensor_spec("depth"), sensor_spec("dvl"), sensor_spec("usbl")};
  for (SensorSpec& spec : specs) {
    spec.rate_hz = 40;
    spec.latency_s = 0.1;
    spec.drop_out = 0.1;
  }
  specs[0].noise["angular_velocity"] = {.std = 1e-3, .bias_std = 1e-3, .bias_time_s = 10, .walk = 1e-4};
  SensorRack rack(specs, 7, "rov", kStepNs);
  const auto step = [&] {
    if (rack.due(snapshot.tick)) rack.record(snapshot, around());
    for (std::size_t k = 0; k < rack.size(); ++k) rack.at(k).read(snapshot, around());
    ++snapshot.tick;
  };
  step();
  const std::size_t before = allocations;
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "allocations are not counted under ThreadSanitizer";
#endif
  for (int k = 0; k < 500; ++k) step();
  EXPECT_EQ(allocations, before);
}

TEST_F(SensorNoise, WithoutErrorsASensorReadsTheTruth) {
  snapshot.state.velocity_body << 1, 2, 3, 0.1, 0.2, 0.3;
  for (const SensorKind* kind : sensor_kinds()) {
    SensorSpec spec = sensor_spec(std::string(kind->name));
    if (kind->name == "proximity") spec.parameters["range_max_m"] = {10};
    NoisySensor each = sensor(spec);
    const Sample read = each.read(snapshot, around()), true_value = each.read_true(snapshot, around());
    for (std::size_t k = 0; k < read.values.size(); ++k) {  // NaN: not measured
      const bool both_lost = std::isnan(read.values[k]) && std::isnan(true_value.values[k]);
      EXPECT_TRUE(both_lost || read.values[k] == true_value.values[k]) << kind->name << " " << k;
    }
  }
}

}  // namespace
}  // namespace uwsim
