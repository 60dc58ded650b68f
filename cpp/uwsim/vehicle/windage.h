#pragma once

#include <Eigen/Core>

#include "uwsim/core/body_state.h"

namespace uwsim {

/// A floating hull in the wind: the load (Fossen 2011, "Handbook of Marine Craft Hydrodynamics and
/// Motion Control", sec. 8.1, for hulls symmetric fore and aft: C_X = -c_x cos g, C_Y = c_y sin g, C_N = c_n sin 2g,
/// where g is the angle of attack, and the experiments cited there have c_x of 0.5 to 0.9, c_y of 0.7 to 0.95 and c_n
/// of 0.05 to 0.2):
///
///   X = 1/2 rho V^2 C_X A_F,  Y = 1/2 rho V^2 C_Y A_L,  N = 1/2 rho V^2 C_N A_L L
///
/// with the air's speed V relative to the hull. X and Y act at `height_m`, so that they pitch and heel it. Heave is
/// neglected.
struct Windage {
  static constexpr double kAir_kg_m3 = 1.225;  ///< at 15 degrees C and 101325 Pa (ISO 2533)
  double frontal_area_m2 = 0, lateral_area_m2 = 0, length_m = 0;
  double height_m = 0;                  ///< of the areas' centre above the body's origin
  double surge = 0, sway = 0, yaw = 0;  ///< c_x, c_y, c_n
  double speed_share = 1;               ///< the wind at that height, relative to that at 10 m
  double dry_volume_m3 = 0;             ///< of the hull above the water as it floats

  /// The wind's load, body frame, at the origin [N, N m]. `air_body_m_s`: velocity of the air relative to the hull.
  /// `dry`: the volume out of the water over `dry_volume_m3`.
  Vector6d load(const Eigen::Vector3d& air_body_m_s, double dry) const;
  /// Throws InvalidValue naming windage.<field>.
  void check() const;
};

}  // namespace uwsim
