#include "uwsim/acoustics/sonar_equation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kPhaseTurn_rad = 0.886 * std::numbers::pi;
constexpr double kPhaseFloor_rad = 0.3;

double ratio(double level_db) { return std::pow(10, level_db / 10); }

double cube(double x) { return x * x * x; }

void require_in(double value, double low, double high, const char* path, const char* rule) {
  require(value >= low && value <= high, path, value, rule);
}

double looks_of(double extent_m, double cell_m) { return std::max(1.0, extent_m / cell_m); }

}  // namespace

void SonarFigures::check() const {
  require_in(frequency_hz, 1e3, 5e6, "sonar.frequency_hz", "must be in [1000, 5000000] Hz");
  require_in(beam_width_along_rad, 1e-4, 1.5, "sonar.beam_width_along_rad", "must be in [0.0001, 1.5] rad");
  require_in(beam_width_across_rad, 1e-4, 1.5, "sonar.beam_width_across_rad", "must be in [0.0001, 1.5] rad");
  require_in(pulse_length_s, 1e-6, 1, "sonar.pulse_length_s", "must be in [0.000001, 1] s");
  require_in(bandwidth_hz, 1, frequency_hz, "sonar.bandwidth_hz", "must be in [1, frequency_hz] Hz");
  require_in(bandwidth_hz * pulse_length_s, 0.99, 1e9, "sonar.bandwidth_hz x pulse_length_s", "must be at least 1");
  require_in(source_level_db, 50, 300, "sonar.source_level_db", "must be in [50, 300] dB");
  require_in(directivity_index_db, 0, 60, "sonar.directivity_index_db", "must be in [0, 60] dB");
  require_in(noise_level_db, -100, 200, "sonar.noise_level_db", "must be in [-100, 200] dB");
  require_in(detection_threshold_db, -20, 60, "sonar.detection_threshold_db", "must be in [-20, 60] dB");
}

double SonarFigures::processing_gain_db() const {
  return 10 * std::log10(std::max(1.0, bandwidth_hz * pulse_length_s));
}

double SonarFigures::figure_db() const {
  return source_level_db + processing_gain_db() + directivity_index_db - noise_level_db;
}

double SonarFigures::range_cell_m(double sound_speed_m_s) const { return 0.5 * sound_speed_m_s / bandwidth_hz; }

double SonarFigures::beam_solid_angle_sr() const {
  return std::numbers::pi / (4 * std::numbers::ln2) * beam_width_along_rad * beam_width_across_rad;
}

double nadir_area_m2(const SonarFigures& sonar, const BottomMaterial& bottom, double range_m, double sound_speed_m_s) {
  const double cell_m = sonar.range_cell_m(sound_speed_m_s);
  const double width_m = range_m * std::sqrt(sonar.beam_width_along_rad * sonar.beam_width_across_rad);
  return sonar.beam_solid_angle_sr() * range_m * range_m * cell_m / std::hypot(cell_m, bottom.relief * width_m);
}

double nadir_snr_db(const SonarFigures& sonar, const BottomMaterial& bottom, double range_m, double sound_speed_m_s,
                    double absorption_db_m) {
  return sonar.figure_db() + bottom.strength_db +
         10 * std::log10(nadir_area_m2(sonar, bottom, range_m, sound_speed_m_s)) - 40 * std::log10(range_m) -
         2 * absorption_db_m * range_m;
}

double fading_intensity(double snr, double looks, double normal_draw) {
  const double root = 1 - 1 / (9 * looks) + normal_draw / (3 * std::sqrt(looks));
  return (1 + snr) * cube(std::max(0.0, root));
}

double intensity_threshold(double detection_threshold_db, double looks) {
  return fading_intensity(ratio(detection_threshold_db), looks, 0);
}

double detection_probability(double snr, double looks, double detection_threshold_db) {
  const double needed = std::cbrt(intensity_threshold(detection_threshold_db, looks) / (1 + snr));
  const double draw = (needed - 1 + 1 / (9 * looks)) * 3 * std::sqrt(looks);
  return 0.5 * std::erfc(draw / std::numbers::sqrt2);
}

double false_alarm_probability(double detection_threshold_db) {
  return std::exp(-intensity_threshold(detection_threshold_db, 1));
}

double amplitude_range_std_m(double extent_m, double cell_m, double snr) {
  return std::max(extent_m, cell_m) / std::sqrt(12.0) * (1 + 1 / snr);
}

double phase_range_std_m(double extent_m, double cell_m, double snr) {
  const double phase_rad = std::sqrt(1 / snr + 0.5 / (snr * snr) + kPhaseFloor_rad * kPhaseFloor_rad);
  return extent_m / kPhaseTurn_rad * phase_rad / std::sqrt(looks_of(extent_m, cell_m));
}

}  // namespace uwsim
