#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/sonar/imaging/beam_pattern.h"
#include "uwsim/sonar/imaging/fan_speckle.h"
#include "uwsim/sonar/imaging/imaging_sonar.h"
#include "uwsim/sonar/imaging/surface_echo.h"

namespace uwsim {
namespace {

constexpr double kPencilTaper = 0.46;
constexpr double kSpan = 1.2;  // multiple of the width, to either side; beyond this, a Hamming pattern is below -25 dB
constexpr int kMeanOver = 2;   // bins to either side
constexpr double kEdge = 0.1;  // fraction of the peak

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

/// The position of the echo in bins; infinite if nothing exceeds the threshold.
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

/// A profiling sonar: a single pencil beam that a motor steps about the head's z axis. Pings once at each of the
/// request's angles, measured from its x axis, positive to port, all from one pose. Returns level_db (angles, bins), dB
/// re 1 uPa, and ranges_m (angles,), infinite without an echo; on request also labels (angles, bins).
///
/// The range is the centroid of the power around the echo's peak, out to where a running mean over five bins has fallen
/// to a tenth of the peak. Near nadir, this is the bottom straight below; at oblique angles, it is the middle of the
/// beam. 1 / R^2, Lambert's law and absorption shift the centroid towards shorter ranges; on a flat bottom below 45
/// degrees, the relative shift is less than the square of the beam width.
class SingleBeam final : public ImagingSonar {
 public:
  SingleBeam(const ImagingAcoustics& acoustics, const ParameterValues& parameters)
      : ImagingSonar(acoustics),
        bins_(static_cast<std::size_t>(acoustics.range_bins)),
        detection_db_(number(parameters, "detection_db")),
        width_rad_(number(parameters, "beam_width_rad")),
        pattern_(width_rad_, kPencilTaper, 0) {
    const int rays_across = whole_number(parameters, "rays_across");
    step_rad_ = 2 * kSpan * width_rad_ / rays_across;
    for (int k = 0; k < rays_across; ++k) offsets_rad_.push_back(-kSpan * width_rad_ + (k + 0.5) * step_rad_);
  }

  std::vector<ImagingArray> ping(const ImagingRequest& request) const override {
    require(request.world_from_sonar.size() == 1, "poses.size", request.world_from_sonar.size(), "must be 1");
    const Pose& pose = request.world_from_sonar.front();
    const double absorption = acoustics().absorption_db_m(request.water, pose.position_m.z());
    const SurfaceEchoes echoes(request.scene, pose.position_m, acoustics(), absorption);
    const ImagingReceiver receiver(acoustics(), absorption, request.random);
    const Eigen::Matrix3d rotation = pose.rotation();
    const double threshold = receiver.noise() * std::pow(10.0, detection_db_ / 10);
    const std::size_t pings = request.angles_rad.size();
    std::vector<float> levels(pings * bins_), ranges(pings), labels(request.with_labels ? pings * bins_ : 0);
    const auto ping_once = [&](std::size_t row) {
      const double angle_rad = request.angles_rad[row];
      const FanSpeckle speckle({pattern_, width_rad_}, acoustics(), request.random, pose, angle_rad, angle_rad);
      std::vector<FanSpeckle::Amplitude> amplitudes;
      const std::span<const FanSpeckle::Amplitude> scattered = speckle.of_beam(angle_rad, amplitudes);
      EchoesByLabel by_label(bins_);
      std::vector<double> received = beam_echo(echoes, rotation, angle_rad, request.with_labels ? &by_label : nullptr);
      for (std::size_t bin = 0; request.with_labels && bin < bins_; ++bin) {
        labels[row * bins_ + bin] = by_label.strongest(bin, receiver.echo_at_noise());
      }
      receiver.receive({request.first_ping + row, 0, 1}, scattered, received,
                       std::span(levels).subspan(row * bins_, bins_));
      ranges[row] = static_cast<float>(detect(received, threshold) * acoustics().bin_m());
    };
    parallel_ranges(
        pings, request.threads,
        [&](std::size_t first, std::size_t last) {
          for (std::size_t k = first; k < last; ++k) ping_once(k);
        },
        1);
    std::vector<ImagingArray> result;
    result.push_back({"level_db", {pings, bins_}, std::move(levels)});
    result.push_back({"ranges_m", {pings}, std::move(ranges)});
    if (request.with_labels) result.push_back({"labels", {pings, bins_}, std::move(labels)});
    return result;
  }

 private:
  /// Mean echo power by range, from a square grid of rays over the beam.
  std::vector<double> beam_echo(const SurfaceEchoes& echoes, const Eigen::Matrix3d& rotation, double angle_rad,
                                EchoesByLabel* by_label) const {
    std::vector<double> echo(bins_, 0.0);
    std::vector<ArcRay> rays = arc_rays(offsets_rad_);
    for (const double across : offsets_rad_) {
      for (ArcRay& ray : rays) {
        const double off_axis = std::acos(std::clamp(std::cos(ray.angle_rad) * std::cos(across), -1.0, 1.0));
        ray.gain_sr = pattern_.power(off_axis) * std::cos(ray.angle_rad) * step_rad_ * step_rad_;
      }
      const double c = std::cos(angle_rad + across), s = std::sin(angle_rad + across);
      echoes.add({rotation * Eigen::Vector3d(c, s, 0), rotation.col(2), rotation * Eigen::Vector3d(-s, c, 0), 0,
                  step_rad_ / 2},
                 rays, echo, by_label);
    }
    return echo;
  }

  std::size_t bins_;
  double detection_db_;
  double width_rad_;
  BeamPattern pattern_;
  double step_rad_;
  std::vector<double> offsets_rad_;  ///< of the rays from the beam's axis, the same in both directions
};

constexpr Parameter kSingleBeamParameters[] = {
    {"beam_width_rad", 1, kRequired, 1e-4, 1, "rad", "between half-power points, two-way"},
    {"rays_across", 1, kRequired, 2, 256, "", "of the square grid of rays", ParameterType::kWholeNumber},
    {"detection_db", 1, kRequired, kAboveZero, 100, "dB", "of an echo's peak, above the noise"}};

}  // namespace

extern const ImagingKind kSingleBeam;
constinit const ImagingKind kSingleBeam = {"single_beam", "a profile of one steered pencil beam", kSingleBeamParameters,
                                           make_imaging_sonar<SingleBeam>};

}  // namespace uwsim
