#pragma once

#include <random>
#include <string>
#include <vector>

#include "dynamics/bodies.h"
#include "uwsim/dynamics/arm.h"

namespace uwsim {

inline ArmLink rod(const std::string& name, std::uint64_t parent, const Eigen::Vector3d& at_m, double mass_kg = 1) {
  ArmLink link;
  link.name = name;
  link.parent = parent;
  link.parent_from_link.position_m = at_m;
  link.axis = Eigen::Vector3d::UnitY();
  link.mass_kg = mass_kg;
  link.centre_of_mass_m = {0.2, 0, 0};
  link.inertia_kg_m2 = Eigen::Vector3d(0.001, 0.015, 0.015).asDiagonal();
  return link;
}

/// Hinges and slides in any direction.
inline std::vector<ArmLink> tree(int seed, std::size_t links) {
  std::mt19937 draw(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<ArmLink> all;
  for (std::size_t k = 0; k < links; ++k) {
    const std::uint64_t parent = k == 0 ? ArmLink::kBase : draw() % k;
    ArmLink link = rod("l" + std::to_string(k), parent, {unit(draw), unit(draw), unit(draw)});
    link.joint = k % 3 == 2 ? ArmLink::Joint::kSlide : ArmLink::Joint::kHinge;
    link.axis = {unit(draw), unit(draw), 1};
    link.parent_from_link.orientation = Eigen::Quaterniond(1, unit(draw), unit(draw), unit(draw)).normalized();
    all.push_back(link);
  }
  return all;
}

}  // namespace uwsim
