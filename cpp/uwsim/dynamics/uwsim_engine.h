#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "uwsim/dynamics/body_groups.h"
#include "uwsim/dynamics/contact_finder.h"
#include "uwsim/dynamics/contact_solver.h"
#include "uwsim/dynamics/dynamics_engine.h"
#include "uwsim/dynamics/resting.h"

namespace uwsim {

/// The default engine: Runge-Kutta with the full 6x6 mass (Craft). ContactFinder finds where bodies come near surfaces;
/// ContactSolver computes the impulses with the same mass. Physics engines' own integrators and solvers use a scalar
/// mass for each body, which cannot represent added mass. Terrain, solids and cover adopt the material of the body that
/// touches them.
///
/// Contacts are linear within a step: contact points are assumed to move with the initial velocity of the body. Near a
/// contact, the step of a body that turns or moves too far for this assumption is divided into parts.
class UwsimEngine final : public DynamicsEngine {
 public:
  UwsimEngine(const World& world, double step_s);

  void add_body(const BodySpec& spec) override;
  void change_body(std::size_t body, const BodySpec& from, const BodySpec& to) override;
  void forget(std::size_t body) override;
  void exchange_contacts(StateArchive& archive) override;
  void step(std::span<MovedBody> bodies, std::span<BodyState> next_states, const WaterField& water,
            double time_s) override;

 private:
  /// A step or part of a step, in which some of the bodies take part.
  struct Interval {
    const WaterField& water;
    double time_s, step_s;
  };

  void begin_step(std::size_t body);
  void find_sleepers(const Interval& whole);
  void wake(std::size_t body);
  void find_parts();
  void repeat_in_parts(std::size_t body, const Interval& whole);
  void move(const Interval& now);
  BodyState state_after(std::size_t body, const BodyState& state, const Loads& loads, const Interval& now) const;
  void watch(const WaterField& water);
  static bool is_unloaded(const MovedBody& body);
  void find_rests(const Interval& now);
  void stop(std::size_t body);
  void find_reaches(double step_s);
  bool are_near(std::size_t a, std::size_t b) const;
  bool is_clear(std::size_t body) const;
  void describe_arm(std::size_t body, const Interval& now);
  Vector6d push_arm(std::size_t body, const Interval& now);
  void find_contacts();
  void name_contact(Contact& contact) const;
  const ArmLink* link_of(int body, int link) const;
  void solve_contacts(const Interval& now);
  void record_touches();
  void stop_groups(const Interval& now);
  void stop_if_held(std::size_t group, const Interval& now);
  bool try_stopping(std::size_t group, const Interval& now);
  bool is_within(const Contact& contact, std::size_t group) const;

  /// A body of the finder: one of ours, or a link of its arm.
  struct Collider {
    std::size_t body;
    int link;
  };

  double step_s_;
  ContactFinder finder_;
  ContactSolver solver_;
  std::vector<Resting> resting_;     // by body
  std::vector<Collider> colliders_;  // those of a body follow each other, its hull first
  std::vector<std::size_t> hulls_;   // by body: the collider of its hull
  // Where a body at rest with nothing but weight and water on it, in steady water, would be at the end of a step
  // without contacts: the same in each step. While nothing comes near it, such a body sleeps: a step leaves it out.
  // This is a pure cache.
  struct FreeStep {
    bool is_known = false;
    BodyState from, to;
    double reach_m = 0;
  };
  std::optional<SteadyWater> steady_;  // the water of the last step
  std::vector<FreeStep> free_steps_;   // by body
  std::vector<std::size_t> awake_;     // the bodies that do not sleep, in order
  std::vector<std::size_t> moves_;     // those that do not rest
  // The step under way.
  std::span<MovedBody> bodies_;
  std::span<BodyState> next_states_;
  // Kept so that steps allocate nothing; indexed by body, except for contacts.
  std::vector<BodyState> states_;  // at the start of an interval
  std::vector<Vector6d> free_velocities_body_;
  std::vector<std::uint8_t> takes_part_, rests_, may_stop_, is_clear_;
  std::vector<int> parts_;  // number of parts of the step
  // How far from its origin a body extends, with its arm, and how far it or its links may go in the interval.
  std::vector<double> extents_m_, reaches_m_;
  std::vector<ContactArm> arms_;               // of bodies that have one, while they are in contact
  std::vector<Arm::LinkMotion> link_motions_;  // by collider, but those of hulls and clear arms are unused
  std::vector<MovingBody> moving_;
  std::vector<ContactBody> contact_bodies_, stopped_bodies_;
  std::vector<Contact> contacts_, stopped_contacts_;
  std::vector<Eigen::Vector3d> impulses_world_;  // of contacts_, on their bodies a [N s]
  BodyGroups groups_;                            // bodies that press on each other
};

}  // namespace uwsim
