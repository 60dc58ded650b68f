#pragma once

#include <Eigen/Core>

namespace uwsim {

/// The water around a vehicle: still surface at z = 0, uniform irrotational current.
struct Fluid {
  double density_kg_m3 = 1000;
  double gravity_m_s2 = 9.80665;
  Eigen::Vector3d current_world_m_s = Eigen::Vector3d::Zero();
};

}  // namespace uwsim
