#include "uwsim/camera/wave_window.h"

#include <cmath>
#include <complex>

namespace uwsim {

/// Each wave is a turn e^(i phase) that is carried from node to node by a constant turn.
WaveField::WaveField(const Water& water, const Eigen::Vector3d& centre, double time_s) {
  if (!water.waves) return;
  const double west = (std::floor(centre.x() / kSpacing_m) - kSide / 2) * kSpacing_m;
  const double south = (std::floor(centre.y() / kSpacing_m) - kSide / 2) * kSpacing_m;
  left_m_ = west - centre.x();
  bottom_m_ = south - centre.y();
  std::vector<double> sums(3 * kSide * kSide, 0.0);
  for (const WaveComponent& wave : water.waves->components()) {
    const double k = wave_number_rad_m(wave.angular_frequency_rad_s, water.waves->depth_m(), water.gravity_m_s2);
    const double kx = k * std::cos(wave.heading_rad), ky = k * std::sin(wave.heading_rad);
    const std::complex<double> east = std::polar(1.0, kx * kSpacing_m);
    for (int j = 0; j < kSide; ++j) {
      const double phase =
          kx * west + ky * (south + j * kSpacing_m) - wave.angular_frequency_rad_s * time_s + wave.phase_rad;
      std::complex<double> turn = std::polar(wave.amplitude_m, phase);
      double* node = sums.data() + 3 * j * kSide;
      for (int i = 0; i < kSide; ++i, node += 3, turn *= east) {
        node[0] += turn.real();
        node[1] -= kx * turn.imag();
        node[2] -= ky * turn.imag();
      }
    }
  }
  cells_.assign(sums.begin(), sums.end());
}

camera::WaveWindow WaveField::window() const {
  return {cells_.empty() ? nullptr : cells_.data(), kSide, static_cast<float>(kSpacing_m), static_cast<float>(left_m_),
          static_cast<float>(bottom_m_)};
}

}  // namespace uwsim
