#pragma once

#include <memory>
#include <string>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/collision_shape.h"
#include "uwsim/dynamics/contact_finder.h"
#include "uwsim/dynamics/contact_solver.h"
#include "uwsim/vehicle/craft.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// A craft as a body that collides.
struct BodySpec {
  std::string name;
  std::shared_ptr<const Craft> craft;
  CollisionShape shape = CollisionShape::kHull;
  double friction = 0.5;     ///< Coulomb coefficient; a pair's is the product's square root
  double restitution = 0.1;  ///< 0 dead .. 1 elastic; a pair's is the larger
  std::vector<ConvexPiece> collision_pieces_body_m = {};  ///< of CollisionShape::kPieces

  /// Throws InvalidValue that names the field.
  void check() const;
};

/// Six-degree-of-freedom bodies among the world's terrain and solids.
///
/// Velocity and pose are the state, advanced by Runge-Kutta with the full 6x6 mass (Craft); ContactFinder says where
/// bodies come near things, ContactSolver finds the impulses with that same mass. A physics engine's own integrator and
/// solver know one scalar mass a body, which cannot carry added mass. The state is all that a step depends on.
/// What is fixed has the material of what touches it.
class RigidBodyWorld {
 public:
  RigidBodyWorld(const World& world, double step_s);

  std::size_t add_body(BodySpec spec, const BodyState& state);

  const BodyState& state(std::size_t body) const { return bodies_.at(body).state; }
  void set_state(std::size_t body, const BodyState& state);
  /// A held body neither moves nor collides: a vehicle in its dock.
  void hold(std::size_t body, bool held) { bodies_.at(body).held = held; }
  bool held(std::size_t body) const { return bodies_.at(body).held; }
  /// The actuators' wrench for the next steps, body frame at the origin [N, N m].
  void set_wrench(std::size_t body, const Vector6d& tau_body) { bodies_.at(body).tau_body = tau_body; }
  /// Whether the body touched anything in the last step.
  bool in_contact(std::size_t body) const { return bodies_.at(body).in_contact; }
  /// nu' over the last step, contacts included [m/s^2, rad/s^2].
  const Vector6d& acceleration_body(std::size_t body) const { return bodies_.at(body).acceleration_body; }

  /// One fixed step from `time_s`. Throws InvalidValue naming the step, the body and its last finite state when a state
  /// stops being finite.
  void step(const WaterField& water, double time_s);

  /// Saves or restores how the bodies are and move. Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  struct Body {
    BodySpec spec;
    BodyState state;
    Vector6d tau_body = Vector6d::Zero();
    Vector6d acceleration_body = Vector6d::Zero();
    bool held = false;
    bool in_contact = false;
  };

  void find_contacts();
  double reach_m(std::size_t body) const;
  void mix_materials(Contact& contact) const;
  void solve_contacts(const WaterField& water, double time_s);
  void require_sane(const Body& body, const BodyState& next, double time_s) const;

  double step_s_;
  ContactFinder finder_;
  ContactSolver solver_;
  std::vector<Body> bodies_;
  // Kept to spare allocation.
  std::vector<BodyState> next_states_;
  std::vector<MovingBody> moving_;
  std::vector<ContactBody> contact_bodies_;
  std::vector<Contact> contacts_;
};

}  // namespace uwsim
