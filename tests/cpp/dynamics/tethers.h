#pragma once

#include <algorithm>

#include "dynamics/bodies.h"

namespace uwsim {

inline TetherSpec between(const Eigen::Vector3d& first, const Eigen::Vector3d& second, double length_m, std::uint64_t n,
                          double mass_kg_m = 1, double axial_stiffness_n = 1e7) {
  TetherSpec spec;
  spec.first.point_m = first;
  spec.second.point_m = second;
  spec.length_m = length_m;
  spec.elements = n;
  spec.diameter_m = 0.02;
  spec.mass_kg_m = mass_kg_m;
  spec.axial_stiffness_n = axial_stiffness_n;
  spec.bending_stiffness_n_m2 = 0;
  return spec;
}

/// Bodies, and the steps that they have made.
class Rig {
 public:
  explicit Rig(const World& world = {}, double step_s = kStep_s) : step_s(step_s), bodies(world, step_s) {}
  void step(const WaterField& water, int count = 1) {
    for (int k = 0; k < count; ++k, ++steps) bodies.step(water, steps * step_s);
  }
  Tether& add(const TetherSpec& spec, const WaterField& water) {
    return bodies.tether(bodies.add_tether(spec, water, 0));
  }

  double step_s;
  RigidBodyWorld bodies;
  int steps = 0;
};

inline Eigen::Vector3d momentum(const Tether& tether) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i <= tether.elements(); ++i) sum += tether.mass_kg(i) * tether.velocity_m_s(i);
  return sum;
}

/// Kinetic, and of height, stretching and bending.
inline double energy_j(const Tether& tether, double gravity) {
  double energy = 0;
  for (std::size_t i = 0; i <= tether.elements(); ++i) {
    const double mass = tether.mass_kg(i);
    energy += mass * (0.5 * tether.velocity_m_s(i).squaredNorm() + gravity * tether.position_m(i).z());
    if (i == tether.elements() || tether.broken() == i) continue;
    const double rest = tether.rest_m(i);
    const Eigen::Vector3d way = tether.position_m(i + 1) - tether.position_m(i);
    const double stretch = std::max(0.0, way.norm() - rest);
    energy += 0.5 * tether.spec().axial_stiffness_n / rest * stretch * stretch;
    if (i == 0 || tether.broken() == i - 1) continue;
    const double before = tether.rest_m(i - 1);
    const Eigen::Vector3d turn = way / rest - (tether.position_m(i) - tether.position_m(i - 1)) / before;
    energy += tether.spec().bending_stiffness_n_m2 / (rest + before) * turn.squaredNorm();
  }
  return energy;
}

inline double contact_energy_j(const Tether& tether) {
  double energy = 0;
  for (const TetherContact& contact : tether.contacts())
    energy += 0.5 * contact.force_n * contact.force_n / contact.stiffness;
  return energy;
}

}  // namespace uwsim
