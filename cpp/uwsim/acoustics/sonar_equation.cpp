#include "uwsim/acoustics/sonar_equation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

const double kMinSteeringCosine = std::cos(80 * std::numbers::pi / 180);

void require_in(double value, double low, double high, const char* path, const char* rule) {
  require(value >= low && value <= high, path, value, rule);
}

}  // namespace

void SonarParameters::check() const {
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

double SonarParameters::processing_gain_db() const {
  return 10 * std::log10(std::max(1.0, bandwidth_hz * pulse_length_s));
}

double SonarParameters::lossless_snr_db() const {
  return source_level_db + processing_gain_db() + directivity_index_db - noise_level_db;
}

double SonarParameters::range_cell_m(double sound_speed_m_s) const { return 0.5 * sound_speed_m_s / bandwidth_hz; }

double SonarParameters::beam_solid_angle_sr() const {
  return std::numbers::pi / (4 * std::numbers::ln2) * beam_width_along_rad * beam_width_across_rad;
}

double steered_widening(double steering_rad) { return 1 / std::max(std::cos(steering_rad), kMinSteeringCosine); }

double echo_extent_m(const SonarParameters& sonar, const BottomMaterial& bottom, const BottomPlace& place,
                     double sound_speed_m_s) {
  const double across_rad = sonar.beam_width_across_rad * steered_widening(place.steering_rad);
  const double relief_m = bottom.relief * place.range_m * std::sqrt(sonar.beam_width_along_rad * across_rad);
  const double slope_m = std::sqrt(std::numbers::pi / (4 * std::numbers::ln2)) * across_rad * place.range_m;
  return std::hypot(sonar.range_cell_m(sound_speed_m_s), relief_m * std::cos(place.incidence_rad),
                    slope_m * std::tan(place.incidence_rad));
}

double echo_area_m2(const SonarParameters& sonar, const BottomMaterial& bottom, const BottomPlace& place,
                    double sound_speed_m_s) {
  const double solid_angle_sr = sonar.beam_solid_angle_sr() * steered_widening(place.steering_rad);
  return solid_angle_sr * place.range_m * place.range_m / std::cos(place.incidence_rad) *
         sonar.range_cell_m(sound_speed_m_s) / echo_extent_m(sonar, bottom, place, sound_speed_m_s);
}

double echo_snr_db(const SonarParameters& sonar, const BottomMaterial& bottom, const BottomPlace& place,
                   double sound_speed_m_s, double absorption_db_m) {
  const double directivity_lost_db = 10 * std::log10(steered_widening(place.steering_rad));
  return sonar.lossless_snr_db() - directivity_lost_db + bottom.strength_db +
         20 * std::log10(std::cos(place.incidence_rad)) +
         10 * std::log10(echo_area_m2(sonar, bottom, place, sound_speed_m_s)) - 40 * std::log10(place.range_m) -
         2 * absorption_db_m * place.range_m;
}

}  // namespace uwsim
