#pragma once

#include <memory>
#include <span>
#include <vector>

#include "uwsim/core/water_field.h"
#include "uwsim/dynamics/arm_link.h"
#include "uwsim/dynamics/link_loads.h"

namespace uwsim {

struct ContactArm;

/// The drive of a joint: a torque, or an acceleration that it has whatever torque it takes.
struct JointDrive {
  bool has_acceleration = false;
  double value = 0;  ///< torque, besides viscous friction, or acceleration
};

/// A tree of links on a base, in reduced coordinates: the articulated-body algorithm (Featherstone 2008, "Rigid Body
/// Dynamics Algorithms", table 7.1; sec. 9.2 for joints with a given acceleration, 9.4 for the floating base). Work is
/// proportional to the number of links.
///
/// All spatial vectors and inertias are at the base's origin along the base's axes, so that the passes between base and
/// links transform nothing. What is fixed to a
/// moving link, its carrier, moves with its velocity and adds to its inertia. RigidPart and ArmLinkWater have what acts
/// on a link.
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
  const Reaction& fold(std::span<const JointDrive> drives);
  /// As the last fold() found it.
  const Reaction& reaction() const { return reaction_; }
  /// Finds how the joints accelerate when the base does at `base_acceleration`, nu'. After fold().
  void unfold(const Vector6d& base_acceleration);

  /// Forces on a link from outside, constant along the world's axes, from the next place() on.
  void push(std::size_t link, const Vector6d& wrench_world);
  void clear_pushes();
  /// The origin, along the base's axes, of the frame that the link moves with, about which it is pushed. After place().
  Eigen::Vector3d push_origin_m(std::size_t link) const;
  /// Writes the joints' axes and the mass matrix with that of the base, whose own is `base_mass`. After place().
  void describe(const Matrix6d& base_mass, double step_s, ContactArm& arm) const;
  /// The moving link whose joint is `joint` of those that describe() writes.
  std::size_t link_of_joint(std::size_t joint) const { return moving_[joint]; }

  /// How far from the base's origin the links' surfaces, and what of them may be wet, may reach, whatever the positions
  /// of hinges.
  double reach_m(std::span<const double> positions) const;
  /// How fast a point of a link may move relative to the base.
  double fastest_m_s(std::span<const double> positions, std::span<const double> speeds) const;
  double acceleration(std::size_t link) const { return carrier_[link] == link ? work_[link].acceleration : 0; }
  /// The torque at the joint besides viscous friction: the given one, or the one that its given acceleration takes.
  double torque(std::size_t link) const;
  Pose world_from_link(std::size_t link) const;
  /// Momentum of the links at the base's origin along its axes, with that of the water that they move. After place().
  Vector6d momentum_base() const;
  /// The links' inertia at the base's origin, with that of the water that they move, if no joint moved. After place().
  Matrix6d locked_inertia() const;
  /// Kinetic energy of the links, the rotors and the still water around [J]. After place().
  double kinetic_energy_j() const;
  /// Energy of height of weight less buoyancy, in water of the density at each link [J]. After place().
  double potential_energy_j() const;

 private:
  /// Where a moving link is in the frame that its joint is in, another moving link's or the base's: turn + sin(q)
  /// by_sine + (1 - cos(q)) by_cosine, at origin_m + q slide.
  struct Joint {
    Eigen::Matrix3d turn, by_sine, by_cosine;
    Eigen::Vector3d origin_m, slide, axis;
    std::uint64_t parent;
  };
  /// All that moves with a link, or with the base.
  struct Carrier {
    RigidPart rigid;
    ImmersedPart immersed;
    std::vector<std::size_t> links;
  };
  struct Work {
    Matrix6d mass, inertia;  // M_RB + s M_A with all that is fixed to it; of the articulated body
    Vector6d axis;           // S: the motion per speed of its joint
    Vector6d velocity, bias_velocity, own_bias, bias, reach, rate;
    PlacedLink placed;
    double scale, force, speed, acceleration, torque;
    bool is_given;
  };

  void place_link(std::size_t link, double position, double speed);
  bool is_immersed(const BodyState& base, std::span<const double> positions, const WaterField& water) const;
  void add_pushes(const Eigen::Matrix3d& base_from_world);
  void add_loads(const Carrier& carrier, const PlacedLink& at, const Vector6d& velocity, const BaseSurroundings& around,
                 Matrix6d& mass, Vector6d& bias);

  std::vector<ArmLink> links_;
  std::vector<ArmLinkWater> water_;     // by link
  std::vector<PlacedLink> in_carrier_;  // by link: where it is in the frame that it moves with
  std::vector<std::uint64_t> carrier_;  // by link: the link that it moves with, or kBase
  std::vector<std::size_t> moving_;     // the links whose joints move
  std::vector<Joint> joints_;           // by link
  std::vector<Carrier> carriers_;       // by link, and that of the base
  std::vector<double> way_m_;           // by link: the length of the way from the base along the joints at their zeros
  double reach_m_ = 0;                  // with all joints at their zeros
  bool has_directions_ = false;         // added mass of some link is not alike in all directions
  std::vector<Work> work_;
  std::vector<Vector6d> pushes_world_;  // by moving link, and that of the base
  bool is_pushed_ = false;
  std::vector<std::size_t> order_;           // by moving link: its place in moving_
  mutable std::vector<Matrix6d> composite_;  // by link, kept so that steps allocate nothing
  std::vector<double> lift_n_, weight_n_;
  BodyState base_;
  Reaction fixed_, reaction_;  // of the links that are fixed to the base; of all
};

}  // namespace uwsim
