#include "uwsim/acoustics/detection_theory.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwsim {
namespace {

constexpr double kMostLooks = 100;
constexpr double kPhaseTurn_rad = 0.886 * std::numbers::pi;
constexpr double kPhaseFloor_rad = 0.3;
constexpr double kLeastSnr = 1e-3;

double cube(double x) { return x * x * x; }

double looks_of(double extent_m, double cell_m) { return std::max(1.0, extent_m / cell_m); }

}  // namespace

double averaged_looks(double extent_m, double cell_m) { return std::min(looks_of(extent_m, cell_m), kMostLooks); }

double speckle_intensity(double looks, double normal_draw) {
  return cube(std::max(0.0, 1 - 1 / (9 * looks) + normal_draw / (3 * std::sqrt(looks))));
}

double received_intensity(double echo, double looks, double normal_draw) {
  const double variance = (1 + 2 * echo) / (9 * looks * (1 + echo) * (1 + echo));
  return (1 + echo) * cube(std::max(0.0, 1 - variance + std::sqrt(variance) * normal_draw));
}

DetectionThreshold::DetectionThreshold(double detection_threshold_db) {
  const double one_look = (1 + std::pow(10, detection_threshold_db / 10)) * speckle_intensity(1, 0);
  normal_draw_ = 3 * (std::cbrt(one_look) - 1 + 1.0 / 9);
  false_alarm_ = std::exp(-one_look);
}

double DetectionThreshold::intensity(double looks) const { return speckle_intensity(looks, normal_draw_); }

double DetectionThreshold::needed_snr(double looks) const {
  return std::max(kLeastSnr, intensity(looks) / speckle_intensity(looks, 0) - 1);
}

double DetectionThreshold::detection_probability(double snr, double looks) const {
  const double needed = std::cbrt(intensity(looks) / (1 + snr));
  const double draw = (needed - 1 + 1 / (9 * looks)) * 3 * std::sqrt(looks);
  return 0.5 * std::erfc(draw / std::numbers::sqrt2);
}

double RangeDeviation::total_m() const { return std::sqrt(speckle_m * speckle_m + noise_m * noise_m); }

RangeDeviation amplitude_range_deviation(double extent_m, double cell_m, double snr) {
  const double speckle_m = std::max(extent_m, cell_m) / std::sqrt(12.0);
  return {speckle_m, speckle_m * std::sqrt((2 + 1 / snr) / snr)};
}

RangeDeviation phase_range_deviation(double extent_m, double cell_m, double snr) {
  const double per_rad_m = extent_m / kPhaseTurn_rad / std::sqrt(looks_of(extent_m, cell_m));
  return {per_rad_m * kPhaseFloor_rad, per_rad_m * std::sqrt(1 / snr + 0.5 / (snr * snr))};
}

}  // namespace uwsim
