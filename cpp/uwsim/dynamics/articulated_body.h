#pragma once

#include <memory>
#include <span>
#include <vector>

#include "uwsim/core/water_field.h"
#include "uwsim/dynamics/arm_link.h"
#include "uwsim/dynamics/spatial.h"

namespace uwsim {

/// The drive of a joint: a torque, or an acceleration that it has whatever torque it takes.
struct JointDrive {
  bool has_acceleration = false;
  double value = 0;  ///< torque, besides viscous friction, or acceleration
};

/// A tree of links on a base, in reduced coordinates: the articulated-body algorithm (Featherstone 2008, "Rigid Body
/// Dynamics Algorithms", table 7.1; sec. 9.2 for joints with a given acceleration, 9.4 for the floating base). Work is
/// proportional to the number of links.
///
/// Each link obeys, at its origin along its axes (McMillan, Orin and McGhee 1995, IEEE Trans. SMC 25:1194; Fossen 2011,
/// 8.1; see Craft):
///
///   (M_RB + s M_A) a + V x* M_RB V + s (V_r x* M_A V_r - M_A a_c) = weight + buoyancy + drag(V_r) + joints
///
/// where V_r = V - V_c is the motion relative to the water at the centre of buoyancy, which does not turn, a_c is the
/// rate of V_c along the link's axes, and x* is the rate of a momentum along moving axes: added mass has its own
/// Coriolis and centripetal forces, of its relative motion. Buoyancy includes the pressure that accelerates the water
/// (Froude-Krylov). s, the submerged fraction, grows linearly while a sphere of the link's volume dips into the water.
/// Added mass is that of the link alone: the flow around its neighbours is not in it. Links do not touch anything.
class ArticulatedBody {
 public:
  /// Throws InvalidValue.
  explicit ArticulatedBody(std::vector<ArmLink> links);

  std::size_t size() const { return links_.size(); }
  const std::vector<ArmLink>& links() const { return links_; }

  /// Places the links for the base's state and the joints' positions and speeds, and computes what acts on them.
  void place(const BodyState& base, std::span<const double> positions, std::span<const double> speeds,
             const WaterField& water, double time_s);
  /// The links as the base feels them: inertia a + bias is the force with which it moves them, at its origin.
  struct Reaction {
    Matrix6d inertia = Matrix6d::Zero();
    Vector6d bias = Vector6d::Zero();
  };
  /// After place().
  Reaction fold(std::span<const JointDrive> drives);
  /// Finds how the joints accelerate when the base does at `base_acceleration`, nu'. After fold().
  void unfold(const Vector6d& base_acceleration);

  double acceleration(std::size_t link) const { return work_[link].acceleration; }
  /// The torque at the joint besides viscous friction: the given one, or the one that its given acceleration takes.
  double torque(std::size_t link) const { return work_[link].torque; }
  const Pose& world_from_link(std::size_t link) const { return work_[link].world_from_link; }
  const Vector6d& velocity(std::size_t link) const { return work_[link].velocity; }
  /// Momentum of the links at the base's origin along its axes, with that of the water that they move. After place().
  Vector6d momentum_base() const;
  /// Kinetic energy of the links, the rotors and the still water around [J]. After place().
  double kinetic_energy_j() const;
  /// Energy of height of weight less buoyancy, in water of the density at each link [J]. After place().
  double potential_energy_j() const;

 private:
  struct Work {
    SpatialTransform parent;
    Pose world_from_link;
    Matrix6d mass, inertia;  // M_RB + s M_A; of the articulated body
    Vector6d velocity, bias_velocity, bias, own_bias, reach, rate;
    double scale, force, speed, acceleration, torque, lift_n, weight_n;
    bool is_given;
  };

  void set_loads(std::size_t link, const WaterField& water, double time_s);

  std::vector<ArmLink> links_;
  std::vector<Matrix6d> rigid_mass_;
  std::vector<Vector6d> axes_;  // S: the link's motion per speed of its joint
  std::vector<Work> work_;
};

}  // namespace uwsim
