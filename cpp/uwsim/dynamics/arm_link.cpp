#include "uwsim/dynamics/arm_link.h"

#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/core/symmetric.h"

namespace uwsim {

Pose ArmLink::parent_from_link_at(double position) const {
  Pose pose = parent_from_link;
  if (joint == Joint::kHinge) {
    pose.orientation = pose.orientation * Eigen::Quaterniond(Eigen::AngleAxisd(position, axis.normalized()));
  } else if (joint == Joint::kSlide) {
    pose.position_m += pose.orientation * (position * axis.normalized());
  }
  return pose;
}

void ArmLink::check() const {
  const std::string path = "link '" + name + "' ";
  const auto at_least_0 = [&](const char* field, double value, bool finite = true) {
    require(value >= 0 && (!finite || std::isfinite(value)), path + field, value, "must be 0 or positive");
  };
  require(std::isfinite(mass_kg) && mass_kg > 0, path + "mass_kg", mass_kg, "must be positive");
  require(centre_of_mass_m.allFinite() && centre_of_buoyancy_m.allFinite(), path + "centre_of_mass_m",
          centre_of_mass_m.transpose(), "must be finite, as must centre_of_buoyancy_m");
  require(inertia_kg_m2.allFinite() && inertia_kg_m2.isApprox(inertia_kg_m2.transpose(), 1e-9), path + "inertia_kg_m2",
          inertia_kg_m2.diagonal().transpose(), "must be finite and symmetric");
  const Eigen::Vector3d principal = eigenvalues(inertia_kg_m2);
  require(principal(0) > 0 && principal(0) + principal(1) >= principal(2) * (1 - 1e-9), path + "inertia_kg_m2",
          principal.transpose(), "principal moments must be positive and obey the triangle inequality");
  require(added_mass.allFinite() && (added_mass.isZero() || added_mass.isApprox(added_mass.transpose(), 1e-9)),
          path + "added_mass", added_mass.diagonal().transpose(), "must be finite and symmetric");
  const double least = eigenvalues(added_mass)(0);
  require(least >= -1e-9 * added_mass.cwiseAbs().maxCoeff(), path + "added_mass", least,
          "must be positive semi-definite (smallest eigenvalue shown)");
  require(linear_drag.allFinite() && linear_drag.minCoeff() >= 0, path + "linear_drag", linear_drag.transpose(),
          "must be 0 or positive");
  require(quadratic_drag.allFinite() && quadratic_drag.minCoeff() >= 0, path + "quadratic_drag",
          quadratic_drag.transpose(), "must be 0 or positive");
  require(joint == Joint::kFixed || (axis.allFinite() && axis.norm() > 1e-6), path + "axis", axis.transpose(),
          "must have a direction");
  require(parent_from_link.position_m.allFinite(), path + "position_m", parent_from_link.position_m.transpose(),
          "must be finite");
  require(lowest <= highest, path + "limits", lowest, "must be at most the upper limit");
  require(std::isfinite(start) && start >= lowest && start <= highest, path + "start", start,
          "must be within the joint's limits");
  if (surface_m != nullptr) require_closed(*surface_m, path + "surface_m");
  at_least_0("volume_m3", volume_m3);
  if (friction) at_least_0("friction", *friction);
  at_least_0("viscous_friction", viscous_friction);
  at_least_0("coulomb_friction", coulomb_friction);
  at_least_0("rotor_inertia_kg_m2", rotor_inertia_kg_m2);
  at_least_0("strongest", strongest, false);
  at_least_0("torque_per_ampere", torque_per_ampere);
  require(std::isfinite(gear_ratio) && gear_ratio > 0, path + "gear_ratio", gear_ratio, "must be positive");
  require(fastest > 0, path + "fastest", fastest, "must be positive");
  require(std::isfinite(response_s) && response_s > 0, path + "response_s", response_s, "must be positive");
}

void check_links(const std::vector<ArmLink>& links) {
  for (std::size_t k = 0; k < links.size(); ++k) {
    links[k].check();
    require(links[k].parent == ArmLink::kBase || links[k].parent < k, "link '" + links[k].name + "' parent",
            links[k].parent, "must be the base or an earlier link");
    for (std::size_t other = 0; other < k; ++other)
      require(links[k].name != links[other].name, "link", links[k].name, "must be unique");
  }
}

}  // namespace uwsim
