#include "uwsim/acoustics/modem/packet_error.h"

#include <cmath>

namespace uwsim {

double bit_error(Modulation modulation, bool fading, double gamma) {
  if (modulation == Modulation::kFsk) return fading ? 1 / (2 + gamma) : 0.5 * std::exp(-0.5 * gamma);
  return fading ? 0.5 / ((1 + gamma) * (1 + std::sqrt(gamma / (1 + gamma)))) : 0.5 * std::erfc(std::sqrt(gamma));
}

double packet_error(double bit_error, double bits) { return -std::expm1(bits * std::log1p(-bit_error)); }

}  // namespace uwsim
