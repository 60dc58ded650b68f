#include "uwsim/sonar/single_beam.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/sonar/beam_pattern.h"
#include "uwsim/sonar/surface_echo.h"

namespace uwsim {
namespace {

constexpr double kFloor = 0;
constexpr double kTaper = 0.46;
constexpr double kSpan = 1.2;  // of the width, to either side; past it a Hamming pattern is below -25 dB
constexpr int kMeanOver = 2;   // bins to either side
constexpr double kEdge = 0.1;  // of the peak

std::vector<double> smoothed(std::span<const double> values) {
  const int n = static_cast<int>(values.size());
  std::vector<double> means(values.size());
  for (int k = 0; k < n; ++k) {
    const int first = std::max(0, k - kMeanOver), last = std::min(n - 1, k + kMeanOver);
    double sum = 0;
    for (int j = first; j <= last; ++j) sum += values[static_cast<std::size_t>(j)];
    means[static_cast<std::size_t>(k)] = sum / (last - first + 1);
  }
  return means;
}

/// In bins; infinity where nothing stands out.
double detect(std::span<const double> received, double threshold) {
  const std::vector<double> means = smoothed(received);
  const auto peak = std::max_element(means.begin(), means.end());
  if (*peak < threshold) return std::numeric_limits<double>::infinity();
  const double edge = kEdge * *peak;
  auto first = peak, last = peak;
  while (first != means.begin() && *(first - 1) >= edge) --first;
  while (last + 1 != means.end() && *(last + 1) >= edge) ++last;
  double power = 0, moment = 0;
  for (auto k = first - means.begin(); k <= last - means.begin(); ++k) {
    power += received[static_cast<std::size_t>(k)];
    moment += received[static_cast<std::size_t>(k)] * (static_cast<double>(k) + 0.5);
  }
  return moment / power;
}

}  // namespace

void SingleBeamModel::check() const {
  acoustics.check();
  require(beam_width_rad >= 1e-4 && beam_width_rad <= 1, "sonar.beam_width_rad", beam_width_rad,
          "must be in [1e-4, 1] rad");
  require(rays_across >= 2 && rays_across <= 256, "sonar.rays_across", rays_across, "must be in [2, 256]");
  require(detection_db > 0 && detection_db <= 100, "sonar.detection_db", detection_db, "must be in (0, 100] dB");
}

SingleBeamProfiles single_beam(const SingleBeamModel& model, const RayScene& scene, const Water& water,
                               const Pose& world_from_sonar, std::span<const double> angles_rad,
                               const RandomStream& random, std::uint64_t first_ping, int threads) {
  model.check();
  const ImagingAcoustics& acoustics = model.acoustics;
  const auto bins = static_cast<std::size_t>(acoustics.range_bins);
  const double absorption = acoustics.absorption_db_m(water, world_from_sonar.position_m.z());
  const SurfaceEchoes echoes(scene, world_from_sonar.position_m, acoustics, absorption);
  const ImagingReceiver receiver(acoustics, absorption, random);
  const BeamPattern pattern(model.beam_width_rad, kTaper, kFloor);
  const Eigen::Matrix3d rotation = world_from_sonar.rotation();
  const double step = 2 * kSpan * model.beam_width_rad / model.rays_across;
  std::vector<double> offsets;
  for (int k = 0; k < model.rays_across; ++k) offsets.push_back(-kSpan * model.beam_width_rad + (k + 0.5) * step);

  const auto ping = [&](std::size_t row, SingleBeamProfiles& out) {
    std::vector<double> received(bins, 0.0);
    std::vector<ArcRay> rays = arc_rays(offsets);
    for (const double across : offsets) {
      for (ArcRay& ray : rays) {
        const double off_axis = std::acos(std::clamp(std::cos(ray.angle_rad) * std::cos(across), -1.0, 1.0));
        ray.gain_sr = pattern.power(off_axis) * std::cos(ray.angle_rad) * step * step;
      }
      const double c = std::cos(angles_rad[row] + across), s = std::sin(angles_rad[row] + across);
      echoes.add(
          {rotation * Eigen::Vector3d(c, s, 0), rotation.col(2), rotation * Eigen::Vector3d(-s, c, 0), 0, step / 2},
          rays, received);
    }
    for (std::size_t bin = 0; bin < bins; ++bin) {
      received[bin] = receiver.received(received[bin], first_ping + row, static_cast<std::uint32_t>(bin));
      out.level_db[row * bins + bin] = receiver.shown_db(received[bin], acoustics.bin_centre_m(static_cast<int>(bin)));
    }
    const double threshold = receiver.noise() * std::pow(10.0, model.detection_db / 10);
    out.ranges_m[row] = static_cast<float>(detect(received, threshold) * acoustics.bin_m());
  };
  SingleBeamProfiles out{std::vector<float>(angles_rad.size() * bins), std::vector<float>(angles_rad.size())};
  parallel_ranges(
      angles_rad.size(), threads,
      [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) ping(k, out);
      },
      1);
  return out;
}

}  // namespace uwsim
