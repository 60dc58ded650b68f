#include <algorithm>
#include <cmath>

#include "uwsim/world/waves.h"

// The part of Waves that moves what grows on the bed.
namespace uwsim {

double Waves::speed_1_s(const Wave& w, double z_world_m) const {
  const double z = std::clamp(z_world_m, -depth_m_, 0.0), k = w.number_rad_m;
  const double decay = w.deep * (std::exp(k * z) + (w.deep < 1 ? std::exp(-k * (z + 2 * depth_m_)) : 0));
  return w.omega_rad_s * w.shallow * decay;
}

/// For u = a cos(phi) with dphi/dt = -omega, x = a (rate cos(phi) - omega sin(phi)) / (rate^2 + omega^2).
Eigen::Vector2d Waves::held_m(const Eigen::Vector3d& p, double time_s, double rate_1_s) const {
  const std::size_t count = count_reaching(p.z());
  if (count == 0) return Eigen::Vector2d::Zero();
  Crests crests;
  crests_at(p.x(), p.y(), time_s, count, crests);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < std::min(count * WaveBlock::kLanes, waves_.size()); ++k) {
    const Wave& w = waves_[k];
    const CrestBlock& crest = crests[k / WaveBlock::kLanes];
    const std::size_t lane = k % WaveBlock::kLanes;
    const double held = (rate_1_s * crest.cosine_m[lane] - w.omega_rad_s * crest.sine_m[lane]) /
                        (rate_1_s * rate_1_s + w.omega_rad_s * w.omega_rad_s);
    sum += speed_1_s(w, p.z()) / w.number_rad_m * held * Eigen::Vector2d(w.number_x_rad_m, w.number_y_rad_m);
  }
  return sum;
}

double Waves::mean_square_m2_s2(double z_world_m) const {
  double sum = 0;
  for (const Wave& w : waves_) {
    const double speed = w.amplitude_m * speed_1_s(w, z_world_m);
    sum += 0.5 * speed * speed;
  }
  return sum;
}

}  // namespace uwsim
