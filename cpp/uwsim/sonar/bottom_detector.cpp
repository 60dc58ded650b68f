#include "uwsim/sonar/bottom_detector.h"

#include <cmath>

namespace uwsim {
namespace {

constexpr double kPhaseLooks = 4;

}  // namespace

BottomDetector::BottomDetector(const SonarParameters& parameters, bool range_noise)
    : range_noise_(range_noise),
      system_ratio_(std::pow(10, parameters.lossless_snr_db() / 10)),
      threshold_(parameters.detection_threshold_db) {}

BottomDetection BottomDetector::bottom(const BeamEcho& echo, const BeamRays& beam, double cell_m,
                                       const BeamDraws& draws, double background) const {
  if (!(echo.peak > 0)) return {};
  double extent_m = echo.extent_m(static_cast<float>(cell_m));
  double snr = system_ratio_ * echo.peak / background;
  BottomDetection found{Detection::kAmplitude, echo.centre_range_m, 0, 0};
  bool by_phase = false;
  if (echo.of_surface && averaged_looks(extent_m, cell_m) >= kPhaseLooks) {
    const double on_axis_m = axis_range_m(echo.rays, beam);
    if (on_axis_m > 0) {
      by_phase = true;
      found = {Detection::kPhase, on_axis_m, 0, 0};
      const AxisEcho on_axis = axis_echo(echo, beam, on_axis_m, static_cast<float>(cell_m));
      extent_m = on_axis.extent_m;
      snr = system_ratio_ * on_axis.level / background;
      if (!(snr > 0)) return {};
    }
  }
  const double looks = averaged_looks(extent_m, cell_m);
  found.intensity = received_intensity(snr * speckle_intensity(looks, draws.speckle), looks, draws.noise);
  if (!(found.intensity > threshold_.intensity(looks))) return {};
  if (range_noise_) {
    const RangeDeviation deviation =
        by_phase ? phase_range_deviation(extent_m, cell_m, snr) : amplitude_range_deviation(extent_m, cell_m, snr);
    found.deviation_m = deviation.total_m();
    found.range_m += draws.speckle_range * deviation.speckle_m + draws.noise_range * deviation.noise_m;
  }
  return found;
}

double BottomDetector::false_alarm(double range_max_m, double cell_m) const {
  return -std::expm1(std::log1p(-threshold_.false_alarm()) * range_max_m / cell_m);
}

BottomDetection BottomDetector::noise(double draw, double false_alarm, double range_m, double cell_m) const {
  const double intensity = threshold_.intensity(1) - std::log(draw / false_alarm);
  const double deviation_m = range_noise_ ? amplitude_range_deviation(cell_m, cell_m, intensity).total_m() : 0;
  return {Detection::kFalse, range_m, intensity, deviation_m};
}

}  // namespace uwsim
