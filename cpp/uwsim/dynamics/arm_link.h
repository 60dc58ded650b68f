#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// A link of an articulated body, and the joint by which an earlier link, or the base, holds it. The joint's axis goes
/// through the link's origin. Units: rad and N m for a hinge, m and N for a slide.
struct ArmLink {
  static constexpr std::uint64_t kBase = std::numeric_limits<std::uint64_t>::max();
  enum class Joint : std::uint64_t { kFixed, kHinge, kSlide };

  std::string name = "link";
  std::uint64_t parent = kBase;  ///< index of an earlier link
  Joint joint = Joint::kHinge;
  Pose parent_from_link;                            ///< where the joint is at its zero
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< along the link's axes
  double mass_kg = 0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre of mass
  double volume_m3 = 0;
  Eigen::Vector3d centre_of_buoyancy_m = Eigen::Vector3d::Zero();
  Matrix6d added_mass = Matrix6d::Zero();  ///< at the link's origin, order as in CraftParameters
  // At the centre of buoyancy along the link's axes: force = -(linear + quadratic |v|) v [N s/m, N s^2/m^2, ...]
  Vector6d linear_drag = Vector6d::Zero(), quadratic_drag = Vector6d::Zero();

  std::shared_ptr<const TriangleMesh> surface_m;  ///< what light, sound and contacts meet, in the link's frame

  std::optional<double> friction;  ///< of its surface in contacts; none: that of the vehicle

  double start = 0;  ///< the joint's position at the start
  double lowest = -std::numeric_limits<double>::infinity(), highest = std::numeric_limits<double>::infinity();
  double viscous_friction = 0;  ///< torque per speed
  double coulomb_friction = 0;  ///< torque, at any speed, and at most this at rest
  double gear_ratio = 1;        ///< turns of the motor per turn of the joint, or rad/m
  double rotor_inertia_kg_m2 = 0;
  double strongest = 0;                                      ///< of the motor, at the joint; 0: there is none
  double fastest = std::numeric_limits<double>::infinity();  ///< that the motor's controller asks for
  double response_s = 0.1;                                   ///< time constant of the position controller
  double torque_per_ampere = 0;                              ///< at the joint; 0: unknown

  /// The rotor's inertia as the joint feels it: the square of the ratio times it. The gyroscopic moment of a rotor
  /// whose axis turns is not in it.
  double reflected_inertia() const { return gear_ratio * gear_ratio * rotor_inertia_kg_m2; }
  /// The link's frame in that of what holds it, for a position of its joint.
  Pose parent_from_link_at(double position) const;
  /// Throws InvalidValue naming link and field.
  void check() const;
};

/// Checks all links, their order and their names. Throws InvalidValue.
void check_links(const std::vector<ArmLink>& links);

}  // namespace uwsim
