#pragma once

#include <memory>
#include <span>

#include "uwsim/dynamics/moved_body.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// Integrates the bodies of a RigidBodyWorld and solves their contacts.
///
/// The motion in a step depends only on the bodies and the water: nothing that an engine keeps from one step to the
/// next affects the result. A simulation therefore continues identically from a saved and restored state.
class DynamicsEngine {
 public:
  virtual ~DynamicsEngine() = default;
  DynamicsEngine() = default;
  DynamicsEngine(const DynamicsEngine&) = delete;
  DynamicsEngine& operator=(const DynamicsEngine&) = delete;

  virtual void add_body(const BodySpec& spec) = 0;
  virtual void change_body(std::size_t body, const BodySpec& from, const BodySpec& to) = 0;
  /// Called after bodies have been placed, held, released or changed.
  virtual void forget() = 0;

  /// Writes the states of all bodies at the end of a step from `time_s` to `next_states`, and whether each touched
  /// anything to `in_contact`; changes nothing else. Throws InvalidValue.
  virtual void step(std::span<MovedBody> bodies, std::span<BodyState> next_states, const WaterField& water,
                    double time_s) = 0;
};

/// kUwsim: UwsimEngine; kBullet: BulletEngine.
enum class EngineKind { kUwsim, kBullet };

std::unique_ptr<DynamicsEngine> make_engine(EngineKind kind, const World& world, double step_s);

}  // namespace uwsim
