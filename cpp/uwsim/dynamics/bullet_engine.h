#pragma once

#include <memory>

#include "uwsim/dynamics/dynamics_engine.h"

namespace uwsim {

/// Bullet's own dynamics: a btDiscreteDynamicsWorld finds the contacts, solves them with its sequential impulses and
/// integrates by semi-implicit Euler. The forces are those of Craft::load, evaluated at the start of the step; mass and
/// inertia are a FoldedMass.
///
/// Bullet's contact points and their impulses, with which the next solution starts, are kept from step to step and are
/// part of the state (ContactKeeper), so that identical states have identical continuations. A body at rest does not
/// sleep. The terrain is a surface: a body that is wholly below it is not pushed out.
class BulletEngine final : public DynamicsEngine {
 public:
  BulletEngine(const World& world, double step_s);
  ~BulletEngine() override;

  void add_body(const BodySpec& spec) override;
  void change_body(std::size_t body, const BodySpec& from, const BodySpec& to) override;
  void forget(std::size_t body) override;
  void moved() override;
  void exchange_contacts(StateArchive& archive) override;
  void step(std::span<MovedBody> bodies, std::span<BodyState> next_states, const WaterField& water,
            double time_s) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uwsim
