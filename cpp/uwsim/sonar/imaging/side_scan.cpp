#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "uwsim/core/parallel.h"
#include "uwsim/sonar/imaging/beam_pattern.h"
#include "uwsim/sonar/imaging/fan_speckle.h"
#include "uwsim/sonar/imaging/imaging_sonar.h"
#include "uwsim/sonar/imaging/surface_echo.h"

namespace uwsim {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSparsest_rad = 0.1 * kDegree;
constexpr double kHighest_rad = 30 * kDegree;  // highest elevation of rays above the horizontal
constexpr double kOutsideBeam = 1e-3;          // -30 dB: a transducer's sensitivity outside its beam; assumed
constexpr double kArrayTaper = 0.46;

/// Angles from straight down to above the horizontal, dense enough to sample a flat bottom at equal steps in range.
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

/// A side-scan sonar with one beam to either side, narrow along the track (the sonar's x axis) and wide across it.
/// Pings once from each pose and returns port_db and starboard_db (pings, bins), dB re 1 uPa by slant range, and
/// altitude_m (pings,), the range of the first return on either side, infinite if there is none; on request also
/// port_labels and starboard_labels (pings, bins).
///
/// Rays lie in planes across the track, from straight down to above the horizontal. They are as dense as the range bins
/// on a flat bottom at the depth straight below, and never sparser than a tenth of a degree. Neither side receives the
/// other's echoes.
class SideScan final : public ImagingSonar {
 public:
  SideScan(const ImagingAcoustics& acoustics, const ParameterValues& parameters)
      : ImagingSonar(acoustics),
        bins_(static_cast<std::size_t>(acoustics.range_bins)),
        planes_(whole_number(parameters, "planes")),
        along_width_rad_(number(parameters, "along_width_rad")),
        vertical_width_rad_(number(parameters, "vertical_width_rad")),
        depression_rad_(number(parameters, "depression_rad")),
        detection_db_(number(parameters, "detection_db")),
        along_(along_width_rad_, kArrayTaper, 0),
        vertical_(vertical_width_rad_, kArrayTaper, kOutsideBeam) {}

  std::vector<ImagingArray> ping(const ImagingRequest& request) const override {
    const std::size_t pings = request.world_from_sonar.size();
    Lines lines{
        std::vector<float>(pings * bins_), std::vector<float>(pings * bins_), std::vector<float>(pings), {}, {}};
    if (request.with_labels) {
      lines.port_labels.resize(pings * bins_);
      lines.starboard_labels.resize(pings * bins_);
    }
    parallel_ranges(
        pings, request.threads,
        [&](std::size_t first, std::size_t last) {
          for (std::size_t k = first; k < last; ++k) ping_once(request, k, lines);
        },
        1);
    std::vector<ImagingArray> result;
    result.push_back({"port_db", {pings, bins_}, std::move(lines.port_db)});
    result.push_back({"starboard_db", {pings, bins_}, std::move(lines.starboard_db)});
    result.push_back({"altitude_m", {pings}, std::move(lines.altitude_m)});
    if (request.with_labels) {
      result.push_back({"port_labels", {pings, bins_}, std::move(lines.port_labels)});
      result.push_back({"starboard_labels", {pings, bins_}, std::move(lines.starboard_labels)});
    }
    return result;
  }

 private:
  struct Lines {
    std::vector<float> port_db, starboard_db, altitude_m;
    std::vector<float> port_labels, starboard_labels;  // empty unless requested
  };

  /// Fills line `row`.
  void ping_once(const ImagingRequest& request, std::size_t row, Lines& lines) const {
    const Pose& pose = request.world_from_sonar[row];
    const double absorption = acoustics().absorption_db_m(request.water, pose.position_m.z());
    const SurfaceEchoes echoes(request.scene, pose.position_m, acoustics(), absorption);
    const ImagingReceiver receiver(acoustics(), absorption, request.random);
    const Eigen::Matrix3d rotation = pose.rotation();
    const double height = request.scene.cast({pose.position_m, -rotation.col(2)}, acoustics().range_max_m).distance_m;
    std::vector<ArcRay> rays = arc_rays(across_angles(acoustics(), height));

    std::vector<double> both(bins_, 0.0);
    std::vector<FanSpeckle::Amplitude> amplitudes;
    for (const int side : {0, 1}) {
      const double bearing_rad = side == 0 ? std::numbers::pi / 2 : -std::numbers::pi / 2;
      const FanSpeckle speckle({along_, vertical_width_rad_}, acoustics(), request.random, pose, bearing_rad,
                               bearing_rad);
      const std::span<const FanSpeckle::Amplitude> scattered = speckle.of_beam(bearing_rad, amplitudes);
      EchoesByLabel by_label(bins_);
      std::vector<double> received =
          side_echo(echoes, rotation, side == 0 ? 1.0 : -1.0, rays, request.with_labels ? &by_label : nullptr);
      std::vector<float>& levels = side == 0 ? lines.port_db : lines.starboard_db;
      const auto first_cell = static_cast<std::uint32_t>(static_cast<std::size_t>(side) * bins_);
      receiver.receive({request.first_ping + row, first_cell, 1}, scattered, received,
                       std::span(levels).subspan(row * bins_, bins_));
      for (std::size_t bin = 0; bin < bins_; ++bin) both[bin] += received[bin];
      if (!request.with_labels) continue;
      float* labels = (side == 0 ? lines.port_labels : lines.starboard_labels).data() + row * bins_;
      for (std::size_t bin = 0; bin < bins_; ++bin) labels[bin] = by_label.strongest(bin, receiver.echo_at_noise());
    }
    lines.altitude_m[row] = first_return_m(both, 2 * receiver.noise());
  }

  /// Mean echo power by range on one side; `port`: 1 for port, -1 for starboard.
  std::vector<double> side_echo(const SurfaceEchoes& echoes, const Eigen::Matrix3d& rotation, double port,
                                std::vector<ArcRay>& rays, EchoesByLabel* by_label) const {
    std::vector<double> echo(bins_, 0.0);
    // Planes cover twice the beam width, where the main lobe of a Hamming pattern is down by 15 dB.
    const double step = 2 * along_width_rad_ / planes_;
    for (int plane = 0; plane < planes_; ++plane) {
      const double aside = -along_width_rad_ + (plane + 0.5) * step;
      const double weight = along_.power(aside) * std::cos(aside) * step;
      for (ArcRay& ray : rays) {
        const double off_axis = ray.angle_rad + depression_rad_;
        ray.gain_sr = weight * vertical_.power(off_axis) * (ray.upper_rad - ray.lower_rad);
      }
      const RayArc arc{port * rotation.col(1), rotation.col(2), rotation.col(0), aside, step / 2};
      echoes.add(arc, rays, echo, by_label);
    }
    return echo;
  }

  float first_return_m(std::span<const double> received, double noise) const {
    const double threshold = noise * std::pow(10.0, detection_db_ / 10);
    const auto first = std::find_if(received.begin(), received.end(), [&](double power) { return power > threshold; });
    if (first == received.end()) return std::numeric_limits<float>::infinity();
    return static_cast<float>(acoustics().bin_centre_m(static_cast<int>(first - received.begin())));
  }

  std::size_t bins_;
  int planes_;
  double along_width_rad_, vertical_width_rad_, depression_rad_, detection_db_;
  BeamPattern along_, vertical_;
};

constexpr Parameter kSideScanParameters[] = {
    {"along_width_rad", 1, kRequired, 1e-4, 0.5, "rad", "along the track, between half-power points, two-way"},
    {"vertical_width_rad", 1, kRequired, 1e-4, std::numbers::pi, "rad", "across the track, two-way"},
    {"depression_rad", 1, kRequired, 0, std::numbers::pi / 2, "rad", "of the beams' axes below the sonar's level"},
    {"planes", 1, kRequired, 1, 256, "", "of rays across the track, over the beam", ParameterType::kWholeNumber},
    {"detection_db", 1, kRequired, kAboveZero, 100, "dB", "of the first bottom return, above the noise"}};

}  // namespace

extern const ImagingKind kSideScan;
constinit const ImagingKind kSideScan = {"side_scan", "a line by slant range to either side", kSideScanParameters,
                                         make_imaging_sonar<SideScan>};

}  // namespace uwsim
