#pragma once

#include <memory>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/dynamics_engine.h"
#include "uwsim/dynamics/forces.h"
#include "uwsim/dynamics/moved_body.h"
#include "uwsim/dynamics/tether.h"
#include "uwsim/world/world.h"

namespace uwsim {

struct FixedSurfaces;

/// Bodies with six degrees of freedom among terrain, solids and cover.
///
/// The state is pose and velocity and, for Bullet's engine, its contacts; a step depends on nothing else. A
/// DynamicsEngine moves the bodies.
class RigidBodyWorld {
 public:
  RigidBodyWorld(const World& world, double step_s, EngineKind engine = EngineKind::kUwsim);

  std::size_t add_body(BodySpec spec, const BodyState& state);

  /// Replaces the bodies' properties, one spec per body; the bodies keep their states. On error, throws InvalidValue
  /// and changes nothing.
  void change_bodies(std::vector<BodySpec> specs);

  /// Adds a tether, after the bodies that it holds, and lays it. Throws InvalidValue, also for Bullet's engine.
  std::size_t add_tether(const TetherSpec& spec, const WaterField& water, double time_s);
  std::size_t tethers() const { return tethers_.size(); }
  Tether& tether(std::size_t index) { return tethers_.at(index); }
  const Tether& tether(std::size_t index) const { return tethers_.at(index); }
  /// Throws InvalidValue unless the body's tethers reach it at this pose.
  void require_tethers_reach(std::size_t body, const Pose& world_from_body, const WaterField& water,
                             double time_s) const;
  /// Lays a body's tethers again, after it has been placed.
  void lay_tethers(std::size_t body, const WaterField& water, double time_s);

  /// The body's arm; null if it has none.
  Arm* arm(std::size_t body) { return bodies_.at(body).arm ? &*bodies_[body].arm : nullptr; }
  const Arm* arm(std::size_t body) const { return bodies_.at(body).arm ? &*bodies_[body].arm : nullptr; }

  /// Replaces the properties of a body's links: as many, with the same names, parents and kinds of joint. Throws
  /// InvalidValue.
  void change_links(std::size_t body, std::vector<ArmLink> links);
  /// The inverse of a body's mass with added mass, and with its links as if no joint moved; zero for a held body.
  Matrix6d inverse_mass(std::size_t body, const WaterField& water, double time_s);

  const BodyState& state(std::size_t body) const { return bodies_.at(body).state; }
  void set_state(std::size_t body, const BodyState& state);
  /// A held body, such as a docked vehicle, neither moves nor collides.
  void hold(std::size_t body, bool held);
  /// Moves a held body along with what holds it.
  void carry(std::size_t body, const BodyState& state) { bodies_.at(body).state = state; }
  bool held(std::size_t body) const { return bodies_.at(body).held; }
  /// Sets the actuators' wrench for the following steps, body frame, at the origin [N, N m].
  void set_wrench(std::size_t body, const Vector6d& tau_body) { bodies_.at(body).tau_body = tau_body; }
  /// Sets what else acts on the body in the following steps, at its origin.
  void apply(std::size_t body, const Loads& applied, const Vector6d& wind_body = Vector6d::Zero()) {
    bodies_.at(body).applied = applied;
    bodies_[body].wind_body = wind_body;
  }
  std::size_t size() const { return bodies_.size(); }
  const BodySpec& spec(std::size_t body) const { return bodies_.at(body).spec; }
  /// See forces_on(). Throws InvalidValue for a body on a path, and for Bullet's engine, which folds added mass into
  /// its own.
  Forces forces(std::size_t body, const WaterField& water, double time_s) const;
  /// Where the body was pressed in the last step; contacts without a force are left out. Throws InvalidValue for
  /// Bullet's engine.
  const std::vector<Touch>& touches(std::size_t body) const;
  /// The layer of cover of which a solid piece encloses the point; null if there is none.
  const CoverLayer* cover_around(const Eigen::Vector3d& point_world_m) const;
  /// Whether the body touched anything in the last step.
  bool in_contact(std::size_t body) const { return bodies_.at(body).in_contact; }
  /// Mean nu' over the last step, including contacts, defined so that nu' + w x v is the mean acceleration along the
  /// body axes at the end of the step [m/s^2, rad/s^2].
  const Vector6d& acceleration_body(std::size_t body) const { return bodies_.at(body).acceleration_body; }

  /// Advances by one fixed step from `time_s`. Throws InvalidValue if the motion diverges (naming step, body and its
  /// last finite state) or if a contact search costs too much (naming body and counts); in both cases no body has
  /// moved.
  void step(const WaterField& water, double time_s);

  /// Saves or restores the state of all bodies; restoring drops the engine's contacts. Throws InvalidValue.
  void exchange_state(StateArchive& archive);
  /// Saves or restores the engine's contacts, after the bodies. Throws InvalidValue.
  void exchange_contacts(StateArchive& archive);
  /// Saves or restores what moved the bodies in the last step. Throws InvalidValue.
  void exchange_last_step(StateArchive& archive);
  /// Its part in the last step.
  void exchange_wind(StateArchive& archive);
  /// Saves or restores the tethers, after all else. Throws InvalidValue.
  void exchange_tethers(StateArchive& archive);
  /// Saves or restores the joints of arms, after all else. Throws InvalidValue.
  void exchange_arms(StateArchive& archive);
  /// Saves or restores the waves that hulls have made, after all else. Throws InvalidValue.

 private:
  void require_forces() const;
  bool has_plants() const;
  Vector6d canopy_drag(const MovedBody& body, const BodyState& state, const WaterField& water, double time_s) const;

  double step_s_;
  EngineKind kind_;
  std::unique_ptr<DynamicsEngine> engine_;
  World world_;                                   // for tethers
  std::shared_ptr<const FixedSurfaces> covered_;  // null without cover
  std::vector<MovedBody> bodies_;
  std::vector<Tether> tethers_;
  std::vector<BodyState> next_states_;  // kept so that steps allocate nothing
};

}  // namespace uwsim
