#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/integrator.h"
#include "uwsim/dynamics/resting.h"
#include "uwsim/dynamics/uwsim_engine.h"

// The part of UwsimEngine that advances the participating bodies over an interval: a step or part of one.
namespace uwsim {
namespace {

constexpr double kReachPerMotion = 1.5;   // the search distance for contacts, relative to the motion in an interval
constexpr double kLeastReach_m = 0.0015;  // more than kTouch_m
// The inverse mass [1/kg, 1/(kg m^2)] of a body on a path, in contacts: what it hits takes all of the change.
constexpr double kUnmoved = 1e-15;

}  // namespace

void UwsimEngine::move(const Interval& now) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (takes_part_[k] == 0) continue;
    MovedBody& body = bodies_[k];
    body.motions.push_back({.start = states_[k],
                            .actuators_body = body.tau_body,
                            .applied = body.applied,
                            .tether_world = body.tether_world,
                            .all = body.loads(Vector6d::Zero(), now.step_s),
                            .time_s = now.time_s,
                            .step_s = now.step_s});
    next_states_[k] = state_after(k, states_[k], body.motions.back().all, now);
    if (body.arm) body.motions.back().arm_body = body.arm->stage_wrenches();
    body.require_plausible(next_states_[k], now.time_s, step_s_);  // before it hits another body
  }
  find_rests(now);
  find_contacts(now);
  if (!contacts_.empty()) solve_contacts(now);
}

/// A body's state at the end of the interval.
BodyState UwsimEngine::state_after(std::size_t body, const BodyState& state, const Loads& loads,
                                   const Interval& now) const {
  if (const BodyPath* const path = bodies_[body].spec.path.get()) return path->at(now.time_s + now.step_s);
  return bodies_[body].advanced(state, loads, now.water, now.time_s, now.step_s);
}

/// Finds the bodies that are known to stay where they are. A body counts only if all bodies near it stay, too.
void UwsimEngine::find_rests(const Interval& now) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const bool lasts =
        takes_part_[k] != 0 && now.step_s == step_s_ && resting_[k].lasts(states_[k], next_states_[k].velocity_body);
    rests_[k] = lasts ? 1 : 0;
  }
  for (bool changes = true; changes;) {
    changes = false;
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      for (std::size_t other = 0; rests_[k] != 0 && other < bodies_.size(); ++other) {
        if (takes_part_[other] == 0 || rests_[other] != 0 || !are_near(k, other, now.step_s)) continue;
        rests_[k] = 0;
        changes = true;
      }
    }
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (takes_part_[k] == 0) continue;
    if (rests_[k] != 0) {
      stop(k);
    } else {
      resting_[k].forget();
      if (now.step_s == step_s_) bodies_[k].touches.clear();  // those of a body that rests stay as they are
    }
  }
}

void UwsimEngine::stop(std::size_t body) {
  next_states_[body] = {states_[body].world_from_body, Vector6d::Zero()};
  bodies_[body].in_contact = true;
  bodies_[body].motions.back().stops = true;
  rests_[body] = 1;
}

/// Returns true if two bodies could meet within the interval.
bool UwsimEngine::are_near(std::size_t a, std::size_t b, double step_s) const {
  const double near_m = finder_.radius_m(a) + finder_.radius_m(b) + reach_m(a, step_s) + reach_m(b, step_s);
  const Eigen::Vector3d between = states_[a].world_from_body.position_m - states_[b].world_from_body.position_m;
  return between.squaredNorm() < near_m * near_m;
}

double UwsimEngine::reach_m(std::size_t body, double step_s) const {
  const double radius_m = finder_.radius_m(body);
  const double fastest = std::max(fastest_m_s(states_[body].velocity_body, radius_m),
                                  fastest_m_s(next_states_[body].velocity_body, radius_m));
  // A diverged state is rejected later; its reach must not be infinite.
  if (!std::isfinite(fastest)) return 0;
  return std::max(kLeastReach_m, kReachPerMotion * fastest * step_s);
}

/// Finds the contacts at the present poses whose gaps this interval could close.
void UwsimEngine::find_contacts(const Interval& now) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    moving_[k] = {states_[k].world_from_body, reach_m(k, now.step_s), takes_part_[k] != 0 && rests_[k] == 0,
                  bodies_[k].spec.path == nullptr};
  }
  try {
    finder_.find(moving_, contacts_);
  } catch (const ContactBudgetExceeded& error) {
    throw InvalidValue("vehicle '" + bodies_[error.body].spec.name + "', " + error.what());
  }
  for (Contact& contact : contacts_) combine_materials(contact);
}

void UwsimEngine::combine_materials(Contact& contact) const {
  const BodySpec& a = bodies_[static_cast<std::size_t>(contact.a)].spec;
  const BodySpec& b = contact.b == kFixedBody ? a : bodies_[static_cast<std::size_t>(contact.b)].spec;
  contact.friction = pair_friction(a, b);
  contact.restitution = pair_restitution(a, b);
}

/// Impulses are found for the velocities at the end of an interval without contacts, and then act as constant forces
/// over it. Thus the momentum of two bodies is conserved, and the work done equals that of the impulses.
void UwsimEngine::solve_contacts(const Interval& now) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    contact_bodies_[k] = {.world_from_body = states_[k].world_from_body,
                          .velocity_body = next_states_[k].velocity_body,
                          .start_velocity_body = states_[k].velocity_body};
  }
  for (const Contact& contact : contacts_) {
    for (const int body : {contact.a, contact.b}) {
      if (body == kFixedBody) continue;
      ContactBody& touched = contact_bodies_[static_cast<std::size_t>(body)];
      if (!touched.inverse_mass.isZero(0)) continue;
      MovedBody& moved = bodies_[static_cast<std::size_t>(body)];
      touched.inverse_mass = moved.spec.path ? Matrix6d(kUnmoved * Matrix6d::Identity())
                                             : moved.inverse_mass(touched.world_from_body, now.water, now.time_s);
    }
  }
  solver_.solve(contact_bodies_, contacts_, now.step_s);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (contacts_[k].gap_m > kTouch_m && solver_.normal_impulse(k) == 0) continue;
    bodies_[static_cast<std::size_t>(contacts_[k].a)].in_contact = true;
    if (contacts_[k].b != kFixedBody) bodies_[static_cast<std::size_t>(contacts_[k].b)].in_contact = true;
  }
  impulses_world_.clear();
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    impulses_world_.push_back(solver_.impulse_world(contacts_[k], k));
  }
  stop_groups(now);
  record_touches();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const ContactBody& solved = contact_bodies_[k];
    if (rests_[k] != 0 || bodies_[k].spec.path) continue;
    if (solved.impulse_body.isZero(0) && solved.push_body.isZero(0)) continue;
    const Eigen::Quaterniond& q = solved.world_from_body.orientation;
    Vector6d impulse_world;
    impulse_world << q * solved.impulse_body.head<3>(), q * solved.impulse_body.tail<3>();
    Loads& all = bodies_[k].motions.back().all;
    all = bodies_[k].loads(impulse_world, now.step_s);
    next_states_[k] = state_after(k, states_[k], all, now);
    if (bodies_[k].arm) bodies_[k].motions.back().arm_body = bodies_[k].arm->stage_wrenches();
    next_states_[k].world_from_body = displaced(next_states_[k].world_from_body, solved.push_body, now.step_s);
  }
}

void UwsimEngine::record_touches() {
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (impulses_world_[k].isZero(0)) continue;
    const Contact& contact = contacts_[k];
    const Eigen::Vector3d force_n = impulses_world_[k] / step_s_;
    const auto other = contact.b == kFixedBody ? Touch::kNoBody : static_cast<std::uint64_t>(contact.b);
    bodies_[static_cast<std::size_t>(contact.a)].touches.push_back({other, contact.point_world_m, force_n});
    if (contact.b != kFixedBody)
      bodies_[other].touches.push_back({static_cast<std::uint64_t>(contact.a), contact.point_world_m, -force_n});
  }
}

/// Stops groups of bodies that press on each other and on the fixed world, are slow, and would stay at rest
/// (resting.h).
void UwsimEngine::stop_groups(const Interval& now) {
  groups_.separate(bodies_.size());
  std::ranges::fill(may_stop_, 0);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (!(solver_.normal_impulse(k) > 0)) continue;
    const auto a = static_cast<std::size_t>(contacts_[k].a);
    if (contacts_[k].b == kFixedBody) {
      may_stop_[a] = 1;
    } else {
      groups_.join(a, static_cast<std::size_t>(contacts_[k].b));
    }
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (may_stop_[k] != 0) may_stop_[groups_.of(k)] = 1;
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    // A body with an arm never stops: its joints may move, or its arm may pull it away. Nor does one on a path.
    const bool is_slow = fastest_m_s(states_[k].velocity_body, finder_.radius_m(k)) <= kSlow_m_s;
    if (!is_slow || bodies_[k].arm || bodies_[k].spec.path) may_stop_[groups_.of(k)] = 0;
  }
  for (std::size_t group = 0; group < bodies_.size(); ++group) {
    if (groups_.of(group) == group && may_stop_[group] != 0) stop_if_held(group, now);
  }
}

void UwsimEngine::stop_if_held(std::size_t group, const Interval& now) {
  const bool is_new = try_stopping(group, now);
  bool holds = true, is_firm = true, pushes = false;
  for (std::size_t k = group; k < bodies_.size(); ++k) {
    if (groups_.of(k) != group) continue;
    const Hold hold(stopped_bodies_[k], free_velocities_body_[k], finder_.radius_m(k), now.step_s);
    holds = holds && hold.holds;
    is_firm = is_firm && hold.is_firm;
    pushes = pushes || hold.pushes;
  }
  if (!holds) return;
  for (std::size_t k = 0, stopped = 0; is_new && k < contacts_.size(); ++k) {
    if (!is_within(contacts_[k], group)) continue;
    impulses_world_[k] = solver_.impulse_world(contacts_[k], stopped++);
  }
  for (std::size_t k = group; k < bodies_.size(); ++k) {
    if (groups_.of(k) != group) continue;
    stop(k);
    if (pushes) {
      next_states_[k].world_from_body = displaced(states_[k].world_from_body, stopped_bodies_[k].push_body, now.step_s);
    } else if (now.step_s == step_s_) {
      resting_[k].begin(states_[k].world_from_body, free_velocities_body_[k], is_firm);
    }
  }
}

bool UwsimEngine::is_within(const Contact& contact, std::size_t group) const {
  const auto is_member = [&](int body) { return groups_.of(static_cast<std::size_t>(body)) == group; };
  return is_member(contact.a) && (contact.b == kFixedBody || is_member(contact.b));
}

/// Computes how the bodies would move if they were stopped now: `stopped_bodies_` with contacts and
/// `free_velocities_body_` without them. Returns false if they are still, so that this is what was solved last.
bool UwsimEngine::try_stopping(std::size_t group, const Interval& now) {
  bool are_still = true;
  for (std::size_t k = group; k < bodies_.size(); ++k) {
    if (groups_.of(k) != group) continue;
    are_still = are_still && states_[k].velocity_body.isZero(0);
    stopped_bodies_[k] = contact_bodies_[k];
    free_velocities_body_[k] = next_states_[k].velocity_body;
  }
  if (are_still) return false;
  for (std::size_t k = group; k < bodies_.size(); ++k) {
    if (groups_.of(k) != group) continue;
    const BodyState stopped{.world_from_body = states_[k].world_from_body};
    free_velocities_body_[k] = state_after(k, stopped, bodies_[k].motions.back().all, now).velocity_body;
    stopped_bodies_[k] = {.world_from_body = stopped.world_from_body,
                          .velocity_body = free_velocities_body_[k],
                          .inverse_mass = contact_bodies_[k].inverse_mass};
  }
  stopped_contacts_.clear();
  for (const Contact& contact : contacts_) {
    if (is_within(contact, group)) stopped_contacts_.push_back(contact);
  }
  solver_.solve(stopped_bodies_, stopped_contacts_, now.step_s);
  return true;
}

}  // namespace uwsim
