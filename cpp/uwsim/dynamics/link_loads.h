#pragma once

#include <vector>

#include "uwsim/core/water_field.h"
#include "uwsim/dynamics/arm_link.h"

namespace uwsim {

/// A frame along the axes of the base.
struct PlacedLink {
  Eigen::Matrix3d base_from_link = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();

  PlacedLink operator*(const PlacedLink& child) const {
    return {base_from_link * child.base_from_link, origin_m + base_from_link * child.origin_m};
  }
};

/// The water and gravity around a base at an instant.
struct BaseSurroundings {
  const WaterField& water;
  double time_s, gravity_m_s2;
  Eigen::Matrix3d world_from_base;
  Eigen::Vector3d position_world_m;
};

/// Mass and loads of what moves as one, at the base's origin along its axes. Mass that is alike in all directions, as
/// that of rigid bodies, needs ten numbers.
struct LinkSum {
  double mass_kg = 0;
  Eigen::Vector3d first_moment_kg_m = Eigen::Vector3d::Zero();
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;  ///< moments and products of inertia [kg m^2]
  // All terms of the equation but M a.
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero(), moment_nm = Eigen::Vector3d::Zero();

  void add_point(double point_kg, const Eigen::Vector3d& at_m);
  void add_force(const Eigen::Vector3d& at_m, const Eigen::Vector3d& n) {
    force_n += n;
    moment_nm += at_m.cross(n);
  }
  void write(Matrix6d& mass, Vector6d& bias) const;
};

/// A rigid body in a frame that moves with it.
class RigidPart {
 public:
  void add(const PlacedLink& at, const ArmLink& link);
  void add(double mass_kg, const Eigen::Vector3d& centre_m, const Eigen::Matrix3d& inertia_kg_m2);
  /// Adds M_RB, V x* M_RB V and the weight of the body, which moves at `velocity`. `lift_m_s2`: against gravity.
  void add_to(LinkSum& sum, const PlacedLink& at, const Vector6d& velocity, const Eigen::Vector3d& lift_m_s2) const;

  double mass_kg() const { return mass_kg_; }
  Eigen::Vector3d moment_kg_m() const { return mass_kg_ * centre_m_; }

 private:
  double mass_kg_ = 0;
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_kg_m2_ = Eigen::Matrix3d::Zero();  // about the centre
};

/// The water's forces on a link.
///
/// A link obeys (McMillan, Orin and McGhee 1995, IEEE Trans. SMC 25:1194; Fossen 2011, 8.1; see Craft)
///
///   (M_RB + s M_A) a + V x* M_RB V + s (V_r x* M_A V_r - M_A a_c) = weight + buoyancy + drag(V_r) + joints
///
/// where V_r = V - V_c is the motion relative to the water at the centre of buoyancy, which does not turn, a_c is the
/// rate of V_c along the link's axes, and x* is the rate of a momentum along moving axes: added mass has its own
/// Coriolis and centripetal forces, of its relative motion. Buoyancy includes the pressure that accelerates the water
/// (Froude-Krylov). s, the submerged fraction, grows linearly while a sphere of the link's volume dips into the water.
/// Added mass is that of the link alone: the flow around its neighbours is not in it.
class ArmLinkWater {
 public:
  /// `at`: where the link is in the frame that it moves with.
  ArmLinkWater(const ArmLink& link, const PlacedLink& at);

  /// Adds the water's part to `sum`, for a frame at `at` that moves at `velocity`; if the added mass is not alike in
  /// all directions, to mass and bias instead. Returns the buoyancy [N].
  double add_to(LinkSum& sum, Matrix6d& mass, Vector6d& bias, const PlacedLink& at, const Vector6d& velocity,
                const BaseSurroundings& around) const;
  bool has_directions() const { return has_any_added_mass_; }
  /// Within this distance of the link's origin, all is wet that may be.
  double extent_m() const { return (centre_m_ - at_.origin_m).norm() + diameter_m_; }

 private:
  friend class ImmersedPart;
  double submerged(const Eigen::Vector3d& centre_world_m, const BaseSurroundings& around) const;
  void add_drag(LinkSum& sum, const PlacedLink& frame, const Eigen::Vector3d& centre_m,
                const Eigen::Vector3d& relative_m_s, const Eigen::Vector3d& spin, double wet) const;
  Eigen::Vector3d drag_along_link(const Eigen::Vector3d& velocity, int first) const;

  double volume_m3_, diameter_m_;
  PlacedLink at_;
  Eigen::Vector3d centre_m_;  // of buoyancy
  bool is_turned_, has_drag_, has_turning_drag_, has_any_added_mass_;
  double added_kg_;  // alike in all directions, as a point there
  Eigen::Vector3d added_at_m_;
  Matrix6d added_mass_;
  Vector6d linear_drag_, quadratic_drag_;
};

/// Water that is the same everywhere at an instant, along the axes of a base in it.
struct EvenSurroundings {
  double density_kg_m3;
  Eigen::Vector3d lift_m_s2;  ///< against gravity
  Eigen::Vector3d velocity_m_s, rate_m_s2;
};

/// Links that move as one, entirely in such water, with added mass that is alike in all directions. The equation of
/// ArmLinkWater then has a closed form: the relative motion's part of V_r x* M_A V_r - M_A a_c that is due to the water
/// cancels but for its rate, so that added mass moves as if it were the body's, and weight, buoyancy and the water's
/// rate act as two forces.
class ImmersedPart {
 public:
  void add(const PlacedLink& at, const ArmLink& link, const ArmLinkWater& water);
  /// Adds mass and loads of a frame at `at` that moves at `velocity`.
  void add_to(LinkSum& sum, const PlacedLink& at, const Vector6d& velocity, const EvenSurroundings& around) const;

 private:
  RigidPart all_;  // with added mass
  double mass_kg_ = 0, volume_m3_ = 0, added_kg_ = 0;
  // Each of the above times where it is.
  Eigen::Vector3d mass_moment_ = Eigen::Vector3d::Zero(), volume_moment_ = Eigen::Vector3d::Zero(),
                  added_moment_ = Eigen::Vector3d::Zero();
  std::vector<ArmLinkWater> dragged_;
};

}  // namespace uwsim
