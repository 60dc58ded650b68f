#pragma once

#include <Eigen/Core>
#include <vector>

namespace uwsim {

/// The wind 10 m above the water: a mean velocity, and gusts along it as a sum of harmonics. It depends on time alone.
struct Wind {
  struct Gust {
    double amplitude_m_s = 0, omega_rad_s = 0, phase_rad = 0;
  };
  double speed_m_s = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, towards which it blows; level
  std::vector<Gust> gusts;

  bool blows() const { return speed_m_s > 0; }
  /// World frame.
  Eigen::Vector3d velocity_m_s(double time_s) const;
  /// Throws InvalidValue naming wind.<field>.
  void check() const;
};

}  // namespace uwsim
