#pragma once

#include <array>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/articulated_body.h"
#include "uwsim/dynamics/integrator.h"
#include "uwsim/dynamics/joint_law.h"

namespace uwsim {

/// The base that carries an arm, and how it would move without it.
class ArmBase {
 public:
  virtual ~ArmBase() = default;
  struct Load {
    Matrix6d mass;    ///< with added mass
    Vector6d wrench;  ///< all that acts on it, with -C(nu) nu, along its axes at its origin
  };
  virtual Load at(const BodyState& state, double time_s) const = 0;
  /// A held base does not move, whatever the arm does.
  virtual bool held() const { return false; }
};

/// A base that does not move.
class HeldBase final : public ArmBase {
 public:
  Load at(const BodyState&, double) const override { return {}; }
  bool held() const override { return true; }
};

/// A craft in the water.
class CraftBase final : public ArmBase {
 public:
  CraftBase(const Craft& craft, const Loads& loads, const WaterField& water)
      : craft_(craft), loads_(loads), water_(water) {}
  Load at(const BodyState& state, double time_s) const override;

 private:
  const Craft& craft_;
  const Loads& loads_;
  const WaterField& water_;
};

/// An articulated body whose joints have motors, friction and stops, and the state of its joints.
///
/// A step is that of `advance` (classical Runge-Kutta) with base and joints together. At its start, Coulomb friction,
/// stops and the motors' controllers, which may be as stiff as they like, are solved together for the speeds at its end
/// (JointLaw): a joint has the speed of a jump, as long as that takes no more torque than the jump has, or the torque
/// between two jumps. That is a linear complementarity problem with a positive definite matrix; Murty's least-index
/// method solves it (Murty 1974, Linear Algebra and its Applications 9:145). In the step, such joints accelerate
/// evenly, and the others have that torque. Stops are inelastic, and momentum is exchanged exactly.
class Arm {
 public:
  /// Throws InvalidValue, also if a joint's viscous friction is too large for a step.
  Arm(std::vector<ArmLink> links, double step_s);

  /// The same arm with other properties: as many links, and joints of the same kinds. Throws InvalidValue.
  Arm with_links(std::vector<ArmLink> links, double step_s) const;

  std::size_t size() const { return body_.size(); }
  const std::vector<ArmLink>& links() const { return body_.links(); }
  double position(std::size_t joint) const { return now_.positions[joint]; }
  double speed(std::size_t joint) const { return now_.speeds[joint]; }
  /// Torque of the motor at the joint at the start of the last step.
  double motor_torque(std::size_t joint) const { return now_.motor_torques[joint]; }
  const JointCommand& command(std::size_t joint) const { return commands_[joint]; }
  /// Throws InvalidValue for a joint that does not move, and beyond its limits.
  void command(std::size_t joint, const JointCommand& command);
  /// Throws InvalidValue beyond the joint's stops.
  void place(std::size_t joint, double position, double speed);
  /// Adds where the links are, for a pose of the base, in their order.
  void add_link_poses(const Pose& world_from_base, std::vector<Pose>& poses) const;
  /// The links for a state of the base, for reading: momentum, energy, poses.
  const ArticulatedBody& placed(const BodyState& base, const WaterField& water, double time_s);

  /// Starts a step at the present state.
  void begin() {
    start_ = now_;
    body_.clear_pushes();
  }
  /// Returns the base's state at the end of a step, or part of one, from `state`, and finds that of the joints.
  BodyState advance(const ArmBase& base, const BodyState& state, const WaterField& water, double time_s, double step_s);
  /// Continues from the end of the part.
  void next_part() { start_ = next_; }
  /// How a link moves in the step, or the part of one, that advance() made last.
  struct LinkMotion {
    Pose world_from_link;           ///< at its start
    double linear_m_s, turn_rad_s;  ///< the greater of start and end; of the link's origin
  };
  /// Bounds of the same: how far from the base's origin the links' surfaces extend, and how fast their points are.
  struct Bounds {
    double extent_m, fastest_m_s;
  };
  Bounds bounds(const BodyState& from, const BodyState& to) const;
  void find_motions(const BodyState& from, const BodyState& to, std::span<LinkMotion> motions);
  /// Describes the joints at the start of that step for contacts. `base`: the mass of the base.
  void describe(const Matrix6d& base_mass, const BodyState& from, const WaterField& water, double time_s, double step_s,
                ContactArm& contact);
  /// A force on a link at a point throughout the next advance(). After describe() for the same step.
  void push(std::size_t link, const BodyState& from, const Eigen::Vector3d& point_world_m,
            const Eigen::Vector3d& force_world_n);
  void clear_pushes() { body_.clear_pushes(); }
  /// Moves the joints at the end of the step, within their stops, at the speeds that separate overlaps.
  void displace(const ContactArm& contact, double step_s);
  /// The step is made.
  void accept() { now_ = next_; }
  /// Throws InvalidValue if the joints' motion diverged.
  void require_plausible(const char* kind, const std::string& name) const;

  /// The wrench of the arm on its base in each stage of the last advance(), along the base's axes.
  const std::array<Vector6d, 4>& stage_wrenches() const { return wrenches_; }
  /// The arm's inertia as the base feels it, at the start of the last advance().
  const Matrix6d& folded_inertia() const { return inertia_; }

  /// Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  struct Joints {
    std::vector<double> positions, speeds, motor_torques;
  };
  Vector6d accelerate(const ArmBase::Load& load, bool held);
  Vector6d solve_joints(const ArmBase::Load& load, bool held, double step_s);
  void drive(double step_s);
  void record_motors();

  ArticulatedBody body_;
  Joints now_, start_, next_;
  std::vector<JointCommand> commands_;
  // The step under way, kept so that steps allocate nothing.
  std::vector<JointLaw> laws_;
  std::vector<JointDrive> drives_;
  std::vector<double> law_torques_;  // at the start of the last advance()
  std::vector<Pose> link_poses_;
  std::vector<Vector6d> link_velocities_;
  Joints stage_, sum_;
  std::array<Vector6d, 4> wrenches_;
  Vector6d wrench_ = Vector6d::Zero();
  Matrix6d inertia_ = Matrix6d::Zero();
};

}  // namespace uwsim
