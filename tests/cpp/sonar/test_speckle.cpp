#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "sonar/imaging_pool.h"
#include "uwsim/sonar/imaging/fan_speckle.h"

namespace uwsim {
namespace {

using Amplitudes = std::vector<FanSpeckle::Amplitude>;
using testing::kDegree;

struct Moments {
  double mean, deviation;
};

template <typename Value>
Moments moments(std::size_t n, Value value) {
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double x = value(k);
    sum += x;
    squares += x * x;
  }
  const auto count = static_cast<double>(n);
  return {sum / count, std::sqrt(squares / count - sum * sum / count / count)};
}

constexpr int kBins = 20000;
constexpr double kTilt_rad = 20 * kDegree;

ImagingAcoustics acoustics(int looks, double noise_db) {
  testing::ImagingModel model = testing::quiet_forward_looking();
  model["looks"] = looks;
  model["range_bins"] = kBins / 50;  // beams times bins are limited
  model["noise_level_db"] = noise_db;
  ImagingAcoustics result = model.acoustics();
  result.range_bins = kBins;
  return result;
}

const BeamPattern kPattern(1 * kDegree, 0.25, 1e-4);

Pose headed(double heading_rad, const Eigen::Vector3d& position_m = {3, -7, -12}) {
  return {position_m, Eigen::Quaterniond(Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()))};
}

/// The amplitudes of one beam, for all bins.
Amplitudes beam_at(const Pose& pose, double bearing_rad, int looks = 1, std::uint64_t seed = 3) {
  const FanSpeckle speckle({kPattern, kTilt_rad}, acoustics(looks, 0), RandomStream(seed, "speckle"), pose, bearing_rad,
                           bearing_rad);
  Amplitudes row;
  speckle.of_beam(bearing_rad, row);
  return row;
}

/// The received power of each bin, with the same echo in all of them.
std::vector<double> received(const ImagingReceiver& receiver, double echo, const Amplitudes& row, std::uint64_t ping,
                             std::size_t bins = kBins) {
  std::vector<double> power(bins, echo);
  std::vector<float> levels_db(bins);
  receiver.receive({ping, 0, 1}, row, power, levels_db);
  return power;
}

/// The correlation of powers.
double correlation(const Amplitudes& a, const Amplitudes& b) {
  double together = 0, one = 0, two = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double x = std::norm(a[k]) - 1.0, y = std::norm(b[k]) - 1.0;
    together += x * y;
    one += x * x;
    two += y * y;
  }
  return together / std::sqrt(one * two);
}

TEST(Speckle, AmplitudeIsRayleigh) {
  const Amplitudes row = beam_at(headed(0.4), 0.1);
  const auto [mean, deviation] = moments(row.size(), [&](std::size_t k) { return std::abs(row[k]); });
  EXPECT_NEAR(mean, std::sqrt(std::numbers::pi) / 2, 0.01);
  EXPECT_NEAR(mean / deviation, 1.9131, 0.03) << "sqrt(pi / (4 - pi))";
  const auto [power, contrast] = moments(row.size(), [&](std::size_t k) { return std::norm(row[k]); });
  EXPECT_NEAR(power, 1, 0.02);
  EXPECT_NEAR(contrast, 1, 0.03) << "an exponential power deviates by its mean";
  for (const double level : {0.1, 1.0, 3.0}) {
    double above = 0;
    for (const FanSpeckle::Amplitude& a : row) above += std::norm(a) > level;
    EXPECT_NEAR(above / kBins, std::exp(-level), 0.012) << level;
  }
}

TEST(Speckle, LooksReduceTheDeviationByTheRootOfTheirNumber) {
  constexpr double kEcho = 1e-18;  // 20 dB re 1 uPa from a source of 200 dB
  for (const int looks : {1, 4, 16}) {
    const ImagingReceiver receiver(acoustics(looks, testing::kSilence_db), 0.1, RandomStream(3, "speckle"));
    const Amplitudes row = beam_at(headed(0.4), 0.1, looks);
    const std::vector<double> powers = received(receiver, kEcho, row, 5);
    const auto [mean, deviation] = moments(kBins, [&](std::size_t k) { return powers[k]; });
    EXPECT_NEAR(mean, 100, 2);
    EXPECT_NEAR(mean / deviation, std::sqrt(looks), 0.03 * std::sqrt(looks));
  }
  const ImagingReceiver without(acoustics(0, testing::kSilence_db), 0.1, RandomStream(3, "speckle"));
  EXPECT_NEAR(received(without, kEcho, {}, 0, 3)[2], 100, 1e-9) << "no looks, no speckle";
}

TEST(Speckle, NoiseDiffersFromPingToPingAndAddsAsPower) {
  const ImagingReceiver receiver(acoustics(1, 20), 0.1, RandomStream(3, "speckle"));
  const Amplitudes row = beam_at(headed(0.4), 0.1);
  for (const double echo : {0.0, 3e-18}) {
    const std::vector<double> powers = received(receiver, echo, row, 5);
    const auto [mean, deviation] = moments(kBins, [&](std::size_t k) { return powers[k]; });
    EXPECT_NEAR(mean, 100 + echo * 1e20, 0.03 * mean);
    EXPECT_NEAR(mean / deviation, 1, 0.03);
  }
  double pings = 0, cells = 0;
  const std::vector<double> fifth = received(receiver, 0, row, 5), sixth = received(receiver, 0, row, 6);
  for (std::size_t k = 0; k < kBins; ++k) {
    pings += (fifth[k] / 100 - 1) * (sixth[k] / 100 - 1) / kBins;
    cells += (fifth[k] / 100 - 1) * (fifth[(k + 1) % kBins] / 100 - 1) / kBins;
  }
  EXPECT_NEAR(pings, 0, 0.03);
  EXPECT_NEAR(cells, 0, 0.03);
  EXPECT_NEAR(received(ImagingReceiver(acoustics(0, 20), 0.1, RandomStream(3, "speckle")), 1e-18, {}, 0)[0], 200, 1e-9);
}

TEST(Speckle, IsTheSameFromTheSamePoseAndAnotherOfAnotherSeed) {
  const Amplitudes row = beam_at(headed(0.4), 0.1);
  EXPECT_EQ(row, beam_at(headed(0.4), 0.1));
  EXPECT_NEAR(correlation(row, beam_at(headed(0.4), 0.1, 1, 4)), 0, 0.03);
  Amplitudes next(row.begin() + 1, row.end());
  next.push_back(row.front());
  EXPECT_NEAR(correlation(row, next), 0, 0.03) << "range bins";
}

TEST(Speckle, BeamsCorrelateByTheAutocorrelationOfTheirPattern) {
  for (const double apart_rad : {0.1 * kDegree, 0.235 * kDegree, 0.5 * kDegree, 0.8 * kDegree}) {
    double product = 0, square = 0;
    for (double angle = -0.1; angle < 0.1; angle += 1e-5) {
      product += kPattern.amplitude_at(angle) * kPattern.amplitude_at(angle - apart_rad);
      square += kPattern.amplitude_at(angle) * kPattern.amplitude_at(angle);
    }
    const double expected = product * product / (square * square);
    double together = 0;
    for (const double bearing : {-0.7, 0.02, 0.55}) {
      const Amplitudes here = beam_at(headed(0.4), bearing);
      together += correlation(here, beam_at(headed(0.4), bearing + apart_rad)) / 3;
      EXPECT_NEAR(correlation(here, beam_at(headed(0.4 - apart_rad), bearing + apart_rad)), 1, 1e-5)
          << "a turning head";
    }
    EXPECT_NEAR(together, expected, 0.03) << apart_rad / kDegree;
  }
}

TEST(Speckle, DecorrelatesAsTheArrayMovesByHalfItsLength) {
  const double half_m = 0.5 * kPattern.lengths_per_wave() * 1500 / 450e3;
  const auto correlation_after = [&](double moved_m, double tilted_rad = 0) {
    double sum = 0;
    constexpr int kPlaces = 24;
    for (int k = 0; k < kPlaces; ++k) {
      const double aside = 2.4 * k;
      const Eigen::Vector3d from(1.7 * k, 0.9 * k, -0.31 * k - 1);
      const Eigen::Vector3d by(moved_m * std::cos(aside), moved_m * std::sin(aside), 0);
      Pose moved = headed(0.4, from + by);
      moved.orientation =
          moved.orientation * Eigen::AngleAxisd(tilted_rad, Eigen::Vector3d(std::cos(aside), std::sin(aside), 0));
      sum += correlation(beam_at(headed(0.4, from), 0.1), beam_at(moved, 0.1)) / kPlaces;
    }
    return sum;
  };
  EXPECT_GT(correlation_after(0.05 * half_m), 0.95);
  EXPECT_NEAR(correlation_after(0.5 * half_m), 0.25, 0.12) << "that of an unshaded line array";
  EXPECT_NEAR(correlation_after(half_m), 0, 0.06);
  EXPECT_NEAR(correlation_after(3 * half_m), 0, 0.02);
  EXPECT_GT(correlation_after(0, 0.05 * kTilt_rad), 0.95);
  EXPECT_NEAR(correlation_after(0, kTilt_rad), 0, 0.06);
}

TEST(Speckle, EveryKindRepeatsItsEchoesFromTheSamePlace) {
  const World world = testing::flat_bed(-20);
  for (auto [model, array] :
       {std::pair{testing::quiet_forward_looking(), "level_db"}, std::pair{testing::quiet_side_scan(), "port_db"},
        std::pair{testing::quiet_single_beam(), "level_db"}}) {
    model["looks"] = 1;
    testing::Pings pings{.poses = {testing::at({0, 0, -15}, model.kind == "single_beam" ? 90 * kDegree : 0)}};
    if (model.kind == "single_beam") pings.angles_rad = {0.1};
    const auto first = testing::values_of(model, world, pings, array);
    pings.first_ping = 1;
    const auto again = testing::values_of(model, world, pings, array);
    int echoes = 0;
    for (std::size_t k = 0; k < first.size(); ++k) {
      if (first[k] < -100) continue;
      ASSERT_NEAR(again[k], first[k], 1e-3) << model.kind;
      ++echoes;
    }
    EXPECT_GT(echoes, 5) << model.kind;
    model["noise_level_db"] = 40;
    EXPECT_NE(testing::values_of(model, world, pings, array), first) << model.kind;
  }
}

}  // namespace
}  // namespace uwsim
