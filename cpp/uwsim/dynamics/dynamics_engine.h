#pragma once

#include <memory>
#include <span>

#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/moved_body.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// Integrates the bodies of a RigidBodyWorld and solves their contacts.
///
/// The motion in a step depends only on the bodies, the water and what exchange_contacts() saves: nothing else that an
/// engine keeps from one step to the next affects the result. A simulation therefore continues identically from a saved
/// and restored state.
class DynamicsEngine {
 public:
  virtual ~DynamicsEngine() = default;
  DynamicsEngine() = default;
  DynamicsEngine(const DynamicsEngine&) = delete;
  DynamicsEngine& operator=(const DynamicsEngine&) = delete;

  virtual void add_body(const BodySpec& spec) = 0;
  virtual void change_body(std::size_t body, const BodySpec& from, const BodySpec& to) = 0;
  /// Called after a body has been placed, held or released.
  virtual void forget(std::size_t body) = 0;

  /// Writes the states of all bodies at the end of a step from `time_s` to `next_states`, and whether each touched
  /// anything to `in_contact`; changes nothing else. Throws InvalidValue.
  virtual void step(std::span<MovedBody> bodies, std::span<BodyState> next_states, const WaterField& water,
                    double time_s) = 0;
  /// Called after the bodies have moved to the states that step() wrote.
  virtual void moved() {}
  /// Saves or restores what the contacts of the last step mean for the next. Throws InvalidValue.
  virtual void exchange_contacts(StateArchive&) {}
};

/// kUwsim: UwsimEngine; kBullet: BulletEngine.
enum class EngineKind { kUwsim, kBullet };

std::unique_ptr<DynamicsEngine> make_engine(EngineKind kind, const World& world, double step_s);

}  // namespace uwsim
