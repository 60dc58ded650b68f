#include "uwsim/acoustics/modem/ambient_noise.h"

#include <cmath>

namespace uwsim {

double ambient_noise_db_hz(double frequency_hz, const NoiseSources& sources) {
  const double khz = 1e-3 * frequency_hz;
  const double turbulence = 17 - 30 * std::log10(khz);
  const double shipping = 40 + 20 * (sources.shipping - 0.5) + 26 * std::log10(khz) - 60 * std::log10(khz + 0.03);
  const double wind = 50 + 7.5 * std::sqrt(sources.wind_m_s) + 20 * std::log10(khz) - 40 * std::log10(khz + 0.4);
  const double thermal = -15 + 20 * std::log10(khz);
  double power = 0;
  for (const double level : {turbulence, shipping, wind, thermal}) power += std::pow(10, 0.1 * level);
  return 10 * std::log10(power);
}

}  // namespace uwsim
