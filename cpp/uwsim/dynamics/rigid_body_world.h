#pragma once

#include <memory>
#include <string>
#include <vector>

#include "uwsim/dynamics/contact_solver.h"
#include "uwsim/vehicle/craft.h"
#include "uwsim/world/world.h"

namespace uwsim {

enum class CollisionShape { kHull, kBox };

/// A craft as a body that collides.
struct BodySpec {
  std::string name;
  std::shared_ptr<const Craft> craft;
  CollisionShape shape = CollisionShape::kHull;
  double friction = 0.5;     ///< Coulomb coefficient; a pair's is the product's square root
  double restitution = 0.1;  ///< 0 dead .. 1 elastic; a pair's is the larger

  /// Throws InvalidValue that names the field.
  void check() const;
};

/// Six-degree-of-freedom bodies among the world's terrain and solids.
///
/// Bullet (double precision) holds the shapes and finds the contacts. Its own integrator and solver know one scalar
/// mass a body, which cannot carry added mass: so velocity and pose are advanced here by Runge-Kutta with the full
/// 6x6 mass (Craft), and contacts are solved with it (ContactSolver).
class RigidBodyWorld {
 public:
  RigidBodyWorld(const World& world, double step_s);
  ~RigidBodyWorld();
  RigidBodyWorld(RigidBodyWorld&&) noexcept;
  RigidBodyWorld& operator=(RigidBodyWorld&&) noexcept;

  std::size_t add_body(BodySpec spec, const BodyState& state);

  const BodyState& state(std::size_t body) const;
  void set_state(std::size_t body, const BodyState& state);
  /// A held body neither moves nor collides: a vehicle in its dock.
  void hold(std::size_t body, bool held);
  bool held(std::size_t body) const;
  /// The actuators' wrench for the next steps, body frame at the origin [N, N m].
  void set_wrench(std::size_t body, const Vector6d& tau_body);
  /// Whether the body touched anything in the last step.
  bool in_contact(std::size_t body) const;
  /// nu' over the last step, contacts included [m/s^2, rad/s^2].
  const Vector6d& acceleration_body(std::size_t body) const;

  /// One fixed step. Throws InvalidValue naming the body and its last finite state when a state stops being finite.
  void step(const Fluid& fluid);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
