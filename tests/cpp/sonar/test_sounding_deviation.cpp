#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "sonar/imaging_pool.h"
#include "uwsim/sonar/acoustic_multibeam.h"

/// The deviations that a multibeam reports for its soundings, against their spread over many pings.
namespace uwsim {
namespace {

constexpr int kFanBeams = 61, kRepeats = 500;
constexpr double kDepth_m = 40;

/// The spread of a quantity about its mean, and the root mean square of its reported deviation.
struct Spread {
  double sum = 0, squares = 0, reported = 0;
  int count = 0;

  void add(double value, double deviation) {
    sum += value;
    squares += value * value;
    reported += deviation * deviation;
    ++count;
  }
  double actual() const { return std::sqrt(squares / count - sum * sum / count / count); }
  double mean_reported() const { return std::sqrt(reported / count); }
};

struct Sounding {
  std::map<Detection, Spread> range, height;
};

AcousticSpec spec() {
  AcousticSpec spec;
  spec.false_detections = false;
  return spec;
}

AcousticMultibeam sonar(const AcousticSpec& spec) {
  MultibeamModel fan = em2040(1);
  fan.beams = kFanBeams;
  fan.field_of_view_rad = 120 * testing::kDegree;
  fan.range_max_m = 500;
  return AcousticMultibeam(fan, spec, Water(), 1000, RandomStream(5, "rov/sonar"));
}

/// Pings straight down onto a level bed, from places farther apart than the arrays are long.
std::vector<Sounding> soundings() {
  const RayScene scene(testing::flat_bed(-kDepth_m));
  const AcousticMultibeam subject = sonar(spec());
  std::vector<Sounding> beams(kFanBeams);
  for (int tick = 0; tick < kRepeats; ++tick) {
    const Pose pose = testing::at({0.5 * tick - 125, 0, 0}, 90 * testing::kDegree);
    const AcousticPing ping = subject.ping(scene, pose, {}, static_cast<std::uint64_t>(tick));
    for (std::size_t k = 0; k < kFanBeams; ++k) {
      if (!ping.valid[k]) continue;
      const auto kind = static_cast<Detection>(ping.detections[k]);
      beams[k].range[kind].add(ping.ranges_m[k], ping.deviation_m[k]);
      beams[k].height[kind].add(-ping.points_sonar_m[3 * k], ping.vertical_deviation_m[k]);
    }
  }
  return beams;
}

TEST(SoundingDeviation, IsTheSpreadOverPingsForEachMethodOfDetection) {
  std::map<Detection, int> checked;
  for (const Sounding& beam : soundings()) {
    for (const auto* quantity : {&beam.range, &beam.height}) {
      for (const auto& [kind, spread] : *quantity) {
        if (spread.count < kRepeats / 2) continue;
        EXPECT_NEAR(spread.mean_reported(), spread.actual(), 0.2 * spread.actual()) << static_cast<int>(kind);
        ++checked[kind];
      }
    }
  }
  EXPECT_GT(checked[Detection::kAmplitude], 10);
  EXPECT_GT(checked[Detection::kPhase], 50);
}

TEST(SoundingDeviation, OfThePlaceIncludesTheTransmittersWidthAcrossTheFan) {
  const RayScene scene(testing::flat_bed(-kDepth_m));
  const AcousticSpec sonar_spec = spec();
  for (const double tilt : {0.0, 0.5}) {
    const AcousticPing ping =
        sonar(sonar_spec).ping(scene, testing::at({0, 0, 0}, 90 * testing::kDegree - tilt), {}, 3);
    int found = 0;
    for (std::size_t k = 0; k < kFanBeams; ++k) {
      if (!ping.valid[k]) continue;
      const double angle = (static_cast<double>(k) / (kFanBeams - 1) - 0.5) * 120 * testing::kDegree;
      const double across = ping.ranges_m[k] * sonar_spec.parameters.beam_width_along_rad / std::sqrt(12);
      const double down = std::cos(angle) * std::cos(tilt);
      const double level = std::sqrt(1 - down * down);
      EXPECT_NEAR(ping.vertical_deviation_m[k], std::hypot(down * ping.deviation_m[k], across * std::sin(tilt)), 1e-4);
      EXPECT_NEAR(ping.horizontal_deviation_m[k], std::hypot(level * ping.deviation_m[k], across * std::cos(tilt)),
                  1e-4);
      ++found;
    }
    EXPECT_GT(found, kFanBeams / 2);
  }
}

TEST(SoundingDeviation, AFalseDetectionPassesForAnEchoOfOneCell) {
  AcousticSpec noisy;
  noisy.parameters.detection_threshold_db = 9;
  const RayScene empty(testing::flat_bed(-900));
  const AcousticMultibeam subject = sonar(noisy);
  const double cell_m = noisy.parameters.range_cell_m(subject.profile().at(0));
  int found = 0;
  for (std::uint64_t tick = 0; tick < 40; ++tick) {
    const AcousticPing ping = subject.ping(empty, testing::at({0, 0, 0}, 90 * testing::kDegree), {}, tick);
    for (std::size_t k = 0; k < kFanBeams; ++k) {
      if (!ping.valid[k]) {
        EXPECT_TRUE(std::isinf(ping.deviation_m[k]) && std::isinf(ping.vertical_deviation_m[k]) &&
                    std::isinf(ping.horizontal_deviation_m[k]));
        continue;
      }
      EXPECT_GT(ping.deviation_m[k], cell_m / std::sqrt(12));
      EXPECT_LT(ping.deviation_m[k], cell_m / 2);
      ++found;
    }
  }
  EXPECT_GT(found, 10);
}

}  // namespace
}  // namespace uwsim
