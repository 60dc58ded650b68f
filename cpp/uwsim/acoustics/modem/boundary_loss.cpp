#include "uwsim/acoustics/modem/boundary_loss.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "uwsim/acoustics/modem/bottom_reflection.h"

namespace uwsim {
namespace {

constexpr double kWorst_db = 60;

}  // namespace

double surface_loss_db(double frequency_hz, double sound_speed_m_s, double rms_height_m, double grazing_rad) {
  const double rayleigh = 2 * std::numbers::pi * frequency_hz / sound_speed_m_s * rms_height_m * std::sin(grazing_rad);
  return std::min(kWorst_db, 20 * std::numbers::log10e * 2 * rayleigh * rayleigh);
}

std::complex<double> bottom_reflection(const FluidBottom& bottom, double grazing_rad) {
  // alpha [dB per wavelength] is 40 pi log10(e) times the ratio of the wave number's imaginary part to its real part.
  const double lossy = bottom.attenuation_db_wavelength / (40 * std::numbers::pi * std::numbers::log10e);
  const std::complex<double> index = std::complex<double>(1, lossy) / bottom.speed_ratio;
  const double cosine = std::cos(grazing_rad);
  const std::complex<double> below = std::sqrt(index * index - cosine * cosine);
  const std::complex<double> above = bottom.density_ratio * std::sin(grazing_rad);
  return (above - below) / (above + below);
}

double bottom_loss_db(const FluidBottom& bottom, double grazing_rad) {
  const double amplitude = std::abs(bottom_reflection(bottom, grazing_rad));
  return std::min(kWorst_db, -20 * std::log10(std::max(amplitude, 1e-6)));
}

}  // namespace uwsim
