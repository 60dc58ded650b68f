#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/body_groups.h"
#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/dynamics/contact_finder.h"
#include "uwsim/dynamics/contact_solver.h"
#include "uwsim/dynamics/resting.h"
#include "uwsim/vehicle/hydrodynamics.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A craft and its collision properties.
struct BodySpec {
  std::string name;
  std::shared_ptr<const Craft> craft;
  CollisionShape shape = CollisionShape::kHull;
  /// Coulomb friction coefficient; a pair of bodies uses the geometric mean of both
  double friction = 0.5;
  /// 0 (inelastic) to 1 (elastic); a pair of bodies uses the larger value
  double restitution = 0.1;
  std::vector<ConvexPiece> collision_pieces_body_m = {};  ///< for CollisionShape::kPieces

  /// Throws InvalidValue naming the field.
  void check() const;
};

/// Bodies with six degrees of freedom among terrain and solids.
///
/// The state is pose and velocity, and a step depends on nothing else. It is integrated by Runge-Kutta with the full
/// 6x6 mass (Craft). ContactFinder finds where bodies come near surfaces; ContactSolver computes the impulses with the
/// same mass. Physics engines' own integrators and solvers use a scalar mass for each body, which cannot represent
/// added mass. Terrain and solids adopt the material of the body that touches them.
///
/// Contacts are linear within a step: contact points are assumed to move with the initial velocity of the body. Near a
/// contact, the step of a body that turns or moves too far for this assumption is divided into parts.
class RigidBodyWorld {
 public:
  RigidBodyWorld(const World& world, double step_s);

  std::size_t add_body(BodySpec spec, const BodyState& state);

  /// Replaces the bodies' properties, one spec per body; the bodies keep their states. On error, throws InvalidValue
  /// and changes nothing.
  void change_bodies(std::vector<BodySpec> specs);

  const BodyState& state(std::size_t body) const { return bodies_.at(body).state; }
  void set_state(std::size_t body, const BodyState& state);
  /// A held body, such as a docked vehicle, neither moves nor collides.
  void hold(std::size_t body, bool held);
  bool held(std::size_t body) const { return bodies_.at(body).held; }
  /// Sets the actuators' wrench for the following steps, body frame, at the origin [N, N m].
  void set_wrench(std::size_t body, const Vector6d& tau_body) { bodies_.at(body).tau_body = tau_body; }
  /// Whether the body touched anything in the last step.
  bool in_contact(std::size_t body) const { return bodies_.at(body).in_contact; }
  /// Mean nu' over the last step, including contacts, defined so that nu' + w x v is the mean acceleration along the
  /// body axes at the end of the step [m/s^2, rad/s^2].
  const Vector6d& acceleration_body(std::size_t body) const { return bodies_.at(body).acceleration_body; }

  /// Advances by one fixed step from `time_s`. Throws InvalidValue if the motion diverges (naming step, body and its
  /// last finite state) or if a contact search costs too much (naming body and counts); in both cases no body has
  /// moved.
  void step(const WaterField& water, double time_s);

  /// Saves or restores the state of all bodies. Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  struct Body {
    BodySpec spec;
    BodyState state;
    Vector6d tau_body = Vector6d::Zero();
    Vector6d acceleration_body = Vector6d::Zero();
    bool held = false;
    bool in_contact = false;
    Resting resting = {};
  };

  /// A step or part of a step, in which some of the bodies take part.
  struct Interval {
    const WaterField& water;
    double time_s, step_s;
  };

  void forget_rests();
  void begin_step(std::size_t body);
  void find_parts();
  void repeat_in_parts(std::size_t body, const Interval& whole);
  void move(const Interval& now);
  BodyState moved(std::size_t body, const BodyState& state, const Vector6d& impulse_world, const Interval& now) const;
  void find_rests(const Interval& now);
  void stop(std::size_t body);
  bool are_near(std::size_t a, std::size_t b, double step_s) const;
  double reach_m(std::size_t body, double step_s) const;
  void find_contacts(const Interval& now);
  void combine_materials(Contact& contact) const;
  void solve_contacts(const Interval& now);
  void stop_groups(const Interval& now);
  void stop_if_held(std::size_t group, const Interval& now);
  void try_stopping(std::size_t group, const Interval& now);
  void require_plausible(const Body& body, const BodyState& next, double time_s) const;

  double step_s_;
  ContactFinder finder_;
  ContactSolver solver_;
  std::vector<Body> bodies_;
  // Kept so that steps allocate nothing; indexed by body, except for contacts.
  std::vector<BodyState> states_, next_states_;  // at the start and at the end of an interval
  std::vector<Vector6d> free_velocities_body_;
  std::vector<std::uint8_t> takes_part_, rests_, may_stop_;
  std::vector<int> parts_;  // number of parts of the step
  std::vector<MovingBody> moving_;
  std::vector<ContactBody> contact_bodies_, stopped_bodies_;
  std::vector<Contact> contacts_, stopped_contacts_;
  BodyGroups groups_;  // bodies that press on each other
};

}  // namespace uwsim
