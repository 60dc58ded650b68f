#include "uwsim/sonar/side_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/sonar/beam_pattern.h"
#include "uwsim/sonar/surface_echo.h"

namespace uwsim {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSparsest_rad = 0.1 * kDegree;
constexpr double kHighest_rad = 30 * kDegree;  // above the level, what stands higher is not looked at
constexpr double kFloor = 1e-3;                // -30 dB: what a transducer hears beside its beam; assumed
constexpr double kTaper = 0.46;

/// Angles from straight down to above the level, at which a flat bottom is met at equal steps of range.
std::vector<double> across_angles(const ImagingAcoustics& acoustics, double height_m) {
  std::vector<double> angles;
  for (double angle = -std::numbers::pi / 2 + kSparsest_rad / 2; angle < kHighest_rad; angle += kSparsest_rad) {
    angles.push_back(angle);
  }
  if (height_m < acoustics.range_max_m) {
    for (double range = height_m + acoustics.bin_m(); range < acoustics.range_max_m; range += acoustics.bin_m()) {
      angles.push_back(-std::asin(height_m / range));
    }
    std::sort(angles.begin(), angles.end());
  }
  return angles;
}

class Fish {
 public:
  Fish(const SideScanModel& model, const RayScene& scene, const Water& water, const RandomStream& random)
      : model_(model),
        scene_(scene),
        water_(water),
        random_(random),
        along_(model.along_width_rad, kTaper, 0),
        vertical_(model.vertical_width_rad, kTaper, kFloor) {}

  /// Fills one line of `lines`.
  void ping(const Pose& world_from_sonar, std::uint64_t number, std::size_t row, SideScanLines& lines) const {
    const ImagingAcoustics& acoustics = model_.acoustics;
    const auto bins = static_cast<std::size_t>(acoustics.range_bins);
    const double absorption = acoustics.absorption_db_m(water_, world_from_sonar.position_m.z());
    const SurfaceEchoes echoes(scene_, world_from_sonar.position_m, acoustics, absorption);
    const ImagingReceiver receiver(acoustics, absorption, random_);
    const Eigen::Matrix3d rotation = world_from_sonar.rotation();
    const double height =
        scene_.cast({world_from_sonar.position_m, -rotation.col(2)}, acoustics.range_max_m).distance_m;
    std::vector<ArcRay> rays = arc_rays(across_angles(acoustics, height));

    std::vector<double> both(bins, 0.0);
    for (const int side : {0, 1}) {
      const std::vector<double> echo = listen(echoes, rotation, side == 0 ? 1.0 : -1.0, rays, bins);
      float* levels = (side == 0 ? lines.port_db : lines.starboard_db).data() + row * bins;
      for (std::size_t bin = 0; bin < bins; ++bin) {
        const auto cell = static_cast<std::uint32_t>(static_cast<std::size_t>(side) * bins + bin);
        const double received = receiver.received(echo[bin], number, cell);
        both[bin] += received;
        levels[bin] = receiver.shown_db(received, acoustics.bin_centre_m(static_cast<int>(bin)));
      }
    }
    lines.altitude_m[row] = first_return_m(both, 2 * receiver.noise());
  }

 private:
  std::vector<double> listen(const SurfaceEchoes& echoes, const Eigen::Matrix3d& rotation, double port,
                             std::vector<ArcRay>& rays, std::size_t bins) const {
    std::vector<double> echo(bins, 0.0);
    // Planes over twice the width: a Hamming pattern's main lobe is down by 15 dB there.
    const double step = 2 * model_.along_width_rad / model_.planes;
    for (int plane = 0; plane < model_.planes; ++plane) {
      const double aside = -model_.along_width_rad + (plane + 0.5) * step;
      const double weight = along_.power(aside) * std::cos(aside) * step;
      for (ArcRay& ray : rays) {
        const double off_axis = ray.angle_rad + model_.depression_rad;
        ray.gain_sr = weight * vertical_.power(off_axis) * (ray.upper_rad - ray.lower_rad);
      }
      const RayArc arc{port * rotation.col(1), rotation.col(2), rotation.col(0), aside, step / 2};
      echoes.add(arc, rays, echo);
    }
    return echo;
  }

  float first_return_m(std::span<const double> received, double noise) const {
    const double threshold = noise * std::pow(10.0, model_.detection_db / 10);
    const auto first = std::find_if(received.begin(), received.end(), [&](double power) { return power > threshold; });
    if (first == received.end()) return std::numeric_limits<float>::infinity();
    return static_cast<float>(model_.acoustics.bin_centre_m(static_cast<int>(first - received.begin())));
  }

  const SideScanModel& model_;
  const RayScene& scene_;
  const Water& water_;
  const RandomStream& random_;
  BeamPattern along_, vertical_;
};

}  // namespace

void SideScanModel::check() const {
  acoustics.check();
  require(along_width_rad >= 1e-4 && along_width_rad <= 0.5, "sonar.along_width_rad", along_width_rad,
          "must be in [1e-4, 0.5] rad");
  require(vertical_width_rad >= 1e-4 && vertical_width_rad <= std::numbers::pi, "sonar.vertical_width_rad",
          vertical_width_rad, "must be in [1e-4, pi] rad");
  require(depression_rad >= 0 && depression_rad <= std::numbers::pi / 2, "sonar.depression_rad", depression_rad,
          "must be in [0, pi/2] rad");
  require(planes >= 1 && planes <= 256, "sonar.planes", planes, "must be in [1, 256]");
  require(detection_db > 0 && detection_db <= 100, "sonar.detection_db", detection_db, "must be in (0, 100] dB");
}

SideScanLines side_scan(const SideScanModel& model, const RayScene& scene, const Water& water,
                        std::span<const Pose> world_from_sonar, const RandomStream& random, std::uint64_t first_ping,
                        int threads) {
  model.check();
  const std::size_t pings = world_from_sonar.size();
  const std::size_t cells = pings * static_cast<std::size_t>(model.acoustics.range_bins);
  SideScanLines lines{std::vector<float>(cells), std::vector<float>(cells), std::vector<float>(pings)};
  const Fish fish(model, scene, water, random);
  parallel_ranges(
      pings, threads,
      [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) fish.ping(world_from_sonar[k], first_ping + k, k, lines);
      },
      1);
  return lines;
}

}  // namespace uwsim
