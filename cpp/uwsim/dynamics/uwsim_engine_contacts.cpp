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

bool same(const BodyState& a, const BodyState& b) {
  return a.velocity_body == b.velocity_body && a.world_from_body.position_m == b.world_from_body.position_m &&
         a.world_from_body.orientation.coeffs() == b.world_from_body.orientation.coeffs();
}

/// The velocity at the end of an interval along the axes at its start, in which contacts are solved. For others than
/// round bodies, which roll on and on, it is that along the axes at its end, as if they did not turn in between.
Vector6d end_velocity(const BodySpec& spec, const BodyState& start, const BodyState& end) {
  if (!spec.round) return end.velocity_body;
  const Eigen::Quaterniond turned = start.world_from_body.orientation.conjugate() * end.world_from_body.orientation;
  return joined(turned * end.linear_body_m_s(), turned * end.angular_body_rad_s());
}

}  // namespace

void UwsimEngine::move(const Interval& now) {
  for (const std::size_t k : awake_) {
    if (takes_part_[k] == 0) continue;
    MovedBody& body = bodies_[k];
    body.motions.push_back({.start = states_[k],
                            .actuators_body = body.tau_body,
                            .applied = body.applied,
                            .wind_body = body.wind_body,
                            .tether_world = body.tether_world,
                            .all = body.loads(Vector6d::Zero(), now.step_s),
                            .time_s = now.time_s,
                            .step_s = now.step_s});
    if (body.arm) body.arm->clear_pushes();
    FreeStep& free = free_steps_[k];
    if (free.is_known && now.step_s == step_s_ && is_unloaded(body) && same(states_[k], free.from)) {
      next_states_[k] = free.to;
      continue;
    }
    free.is_known = false;
    next_states_[k] = state_after(k, states_[k], body.motions.back().all, now);
    body.record_stages();
    body.require_plausible(next_states_[k], now.time_s, step_s_);  // before it hits another body
  }
  find_reaches(now.step_s);
  find_rests(now);
  find_contacts();
  if (!contacts_.empty()) solve_contacts(now);
}

/// A body's state at the end of the interval.
BodyState UwsimEngine::state_after(std::size_t body, const BodyState& state, const Loads& loads,
                                   const Interval& now) const {
  if (const BodyPath* const path = bodies_[body].spec.path.get()) {
    if (bodies_[body].arm) bodies_[body].arm->advance(HeldBase(), state, now.water, now.time_s, now.step_s);
    return path->at(now.time_s + now.step_s);
  }
  return bodies_[body].advanced(state, loads, now.water, now.time_s, now.step_s);
}

/// Finds the bodies that are known to stay where they are. A body counts only if all bodies near it stay, too: each
/// that moves wakes those near it.
void UwsimEngine::find_rests(const Interval& now) {
  moves_.clear();
  for (const std::size_t k : awake_) {
    const bool lasts =
        takes_part_[k] != 0 && now.step_s == step_s_ && resting_[k].lasts(states_[k], next_states_[k].velocity_body);
    rests_[k] = lasts ? 1 : 0;
    if (takes_part_[k] != 0 && !lasts) moves_.push_back(k);
    const bool has_parts = bodies_[k].arm.has_value();  // with states of their own, which go on
    if (lasts && steady_ && !has_parts && is_unloaded(bodies_[k])) {
      free_steps_[k] = {true, states_[k], next_states_[k], reaches_m_[k]};
    }
  }
  const std::size_t awake = awake_.size();
  if (std::ranges::find(rests_, 1) == rests_.end()) moves_.clear();  // nothing to wake
  for (std::size_t next = 0; next < moves_.size(); ++next) {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      if (rests_[k] == 0 || !are_near(k, moves_[next])) continue;
      rests_[k] = 0;
      moves_.push_back(k);
      if (bodies_[k].sleeps) wake(k);
    }
  }
  if (awake_.size() > awake) std::ranges::sort(awake_);
  for (const std::size_t k : awake_) {
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
bool UwsimEngine::are_near(std::size_t a, std::size_t b) const {
  const double near_m = extents_m_[a] + extents_m_[b] + reaches_m_[a] + reaches_m_[b];
  const Eigen::Vector3d between = states_[a].world_from_body.position_m - states_[b].world_from_body.position_m;
  return between.squaredNorm() < near_m * near_m;
}

void UwsimEngine::find_reaches(double step_s) {
  const auto reach_m = [&](double fastest) {
    // A diverged state is rejected later; its reach must not be infinite.
    return std::isfinite(fastest) ? std::max(kLeastReach_m, kReachPerMotion * fastest * step_s) : 0;
  };
  for (const std::size_t k : awake_) {
    const std::size_t hull = hulls_[k];
    extents_m_[k] = finder_.radius_m(hull);
    const double fastest = std::max(fastest_m_s(states_[k].velocity_body, extents_m_[k]),
                                    fastest_m_s(next_states_[k].velocity_body, extents_m_[k]));
    reaches_m_[k] = moving_[hull].reach_m = reach_m(fastest);
    if (!bodies_[k].arm) continue;
    const Arm::Bounds bounds = bodies_[k].arm->bounds(states_[k], next_states_[k]);
    extents_m_[k] = std::max(extents_m_[k], bounds.extent_m);
    reaches_m_[k] = std::max(reaches_m_[k], reach_m(bounds.fastest_m_s));
  }
  for (const std::size_t k : awake_) {
    if (!bodies_[k].arm) continue;
    is_clear_[k] = is_clear(k) ? 1 : 0;
    if (is_clear_[k] != 0) continue;
    const std::size_t hull = hulls_[k], links = bodies_[k].arm->size();
    extents_m_[k] = finder_.radius_m(hull);
    reaches_m_[k] = moving_[hull].reach_m;
    bodies_[k].arm->find_motions(states_[k], next_states_[k], std::span(link_motions_).subspan(hull + 1, links));
    for (std::size_t link = hull + 1; link <= hull + links; ++link) {
      const Arm::LinkMotion& motion = link_motions_[link];
      const double radius_m = finder_.radius_m(link);
      if (radius_m == 0) continue;
      moving_[link].reach_m = reach_m(motion.linear_m_s + radius_m * motion.turn_rad_s);
      reaches_m_[k] = std::max(reaches_m_[k], moving_[link].reach_m);
      const Eigen::Vector3d out = motion.world_from_link.position_m - states_[k].world_from_body.position_m;
      extents_m_[k] = std::max(extents_m_[k], out.norm() + radius_m);
    }
  }
}

/// Returns true if nothing is where the body's arm could touch it within the interval.
bool UwsimEngine::is_clear(std::size_t body) const {
  for (std::size_t other = 0; other < bodies_.size(); ++other) {
    if (other != body && are_near(body, other)) return false;
  }
  return !finder_.may_touch_world(states_[body].world_from_body.position_m, extents_m_[body] + reaches_m_[body]);
}

/// Finds the contacts at the present poses whose gaps this interval could close.
void UwsimEngine::find_contacts() {
  for (const std::size_t body : awake_) {
    const std::size_t hull = hulls_[body];
    const bool meets_world = bodies_[body].spec.path == nullptr,
               may_touch = takes_part_[body] != 0 && rests_[body] == 0;
    moving_[hull] = {states_[body].world_from_body, moving_[hull].reach_m, may_touch, meets_world, body};
    const std::size_t links = bodies_[body].arm ? bodies_[body].arm->size() : 0;
    for (std::size_t k = hull + 1; k <= hull + links; ++k) {
      moving_[k] = {link_motions_[k].world_from_link, moving_[k].reach_m, may_touch && is_clear_[body] == 0,
                    meets_world, body};
    }
  }
  try {
    finder_.find(moving_, contacts_);
  } catch (const ContactBudgetExceeded& error) {
    throw InvalidValue("vehicle '" + bodies_[colliders_[error.body].body].spec.name + "', " + error.what());
  }
  for (Contact& contact : contacts_) name_contact(contact);
}

const ArmLink* UwsimEngine::link_of(int body, int link) const {
  return link == kHull ? nullptr : &bodies_[static_cast<std::size_t>(body)].spec.arm[static_cast<std::size_t>(link)];
}

/// Replaces the finder's bodies by ours, and adds the materials.
void UwsimEngine::name_contact(Contact& contact) const {
  const Collider& first = colliders_[static_cast<std::size_t>(contact.a)];
  contact.a = static_cast<int>(first.body);
  contact.link_a = first.link;
  if (contact.b != kFixedBody) {
    const Collider& second = colliders_[static_cast<std::size_t>(contact.b)];
    contact.b = static_cast<int>(second.body);
    contact.link_b = second.link;
  }
  const BodySpec& a = bodies_[first.body].spec;
  const BodySpec& b = contact.b == kFixedBody ? a : bodies_[static_cast<std::size_t>(contact.b)].spec;
  const ArmLink* const link_a = link_of(contact.a, contact.link_a);
  const ArmLink* const link_b = contact.b == kFixedBody ? link_a : link_of(contact.b, contact.link_b);
  contact.friction = pair_friction(a, link_a, b, link_b);
  contact.restitution = pair_restitution(a, b);
}

/// Impulses are found for the velocities at the end of an interval without contacts, and then act as constant forces
/// over it. Thus the momentum of two bodies is conserved, and the work done equals that of the impulses.
void UwsimEngine::solve_contacts(const Interval& now) {
  for (const std::size_t k : awake_) {
    contact_bodies_[k] = {.world_from_body = states_[k].world_from_body,
                          .velocity_body = end_velocity(bodies_[k].spec, states_[k], next_states_[k]),
                          .start_velocity_body = states_[k].velocity_body};
  }
  for (const Contact& contact : contacts_) {
    for (const int body : {contact.a, contact.b}) {
      if (body == kFixedBody) continue;
      ContactBody& touched = contact_bodies_[static_cast<std::size_t>(body)];
      if (!touched.inverse_mass.isZero(0) || touched.arm != nullptr) continue;
      MovedBody& moved = bodies_[static_cast<std::size_t>(body)];
      if (moved.arm) {
        describe_arm(static_cast<std::size_t>(body), now);
        continue;
      }
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
  for (const std::size_t k : awake_) {
    const ContactBody& solved = contact_bodies_[k];
    if (rests_[k] != 0 || (bodies_[k].spec.path && !bodies_[k].arm)) continue;
    if (solved.impulse_body.isZero(0) && solved.push_body.isZero(0)) continue;
    const Eigen::Quaterniond& q = solved.world_from_body.orientation;
    Vector6d impulse_world;
    impulse_world << q * solved.impulse_body.head<3>(), q * solved.impulse_body.tail<3>();
    if (bodies_[k].arm) impulse_world = push_arm(k, now);
    Loads& all = bodies_[k].motions.back().all;
    all = bodies_[k].loads(impulse_world, now.step_s);
    next_states_[k] = state_after(k, states_[k], all, now);
    bodies_[k].record_stages();
    if (bodies_[k].arm) bodies_[k].arm->displace(arms_[k], now.step_s);
    if (bodies_[k].spec.path) continue;
    next_states_[k].world_from_body = displaced(next_states_[k].world_from_body, solved.push_body, now.step_s);
  }
}

void UwsimEngine::describe_arm(std::size_t body, const Interval& now) {
  MovedBody& moved = bodies_[body];
  const Matrix6d base_mass = moved.spec.path ? Matrix6d(Matrix6d::Identity() / kUnmoved)
                                             : moved.base_mass(states_[body].world_from_body, now.water, now.time_s);
  moved.arm->describe(base_mass, states_[body], now.water, now.time_s, now.step_s, arms_[body]);
  contact_bodies_[body].arm = &arms_[body];
}

/// Pushes the links of a body by the impulses of their contacts, and returns that of its hull, as Loads has it.
Vector6d UwsimEngine::push_arm(std::size_t body, const Interval& now) {
  Vector6d hull = Vector6d::Zero();
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (impulses_world_[k].isZero(0)) continue;
    const Contact& contact = contacts_[k];
    for (const bool is_a : {true, false}) {
      if ((is_a ? contact.a : contact.b) != static_cast<int>(body)) continue;
      const int link = is_a ? contact.link_a : contact.link_b;
      const Eigen::Vector3d impulse = is_a ? impulses_world_[k] : Eigen::Vector3d(-impulses_world_[k]);
      if (link != kHull) {
        bodies_[body].arm->push(static_cast<std::size_t>(link), states_[body], contact.point_world_m,
                                impulse / now.step_s);
        continue;
      }
      hull.head<3>() += impulse;
      hull.tail<3>() += (contact.point_world_m - states_[body].world_from_body.position_m).cross(impulse);
    }
  }
  return hull;
}

void UwsimEngine::record_touches() {
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (impulses_world_[k].isZero(0)) continue;
    const Contact& contact = contacts_[k];
    const Eigen::Vector3d force_n = impulses_world_[k] / step_s_;
    const auto other = contact.b == kFixedBody ? Touch::kNoBody : static_cast<std::uint64_t>(contact.b);
    const auto link_a = static_cast<std::uint64_t>(contact.link_a), link_b = static_cast<std::uint64_t>(contact.link_b);
    const Eigen::Vector3d& point_m = contact.point_world_m;
    bodies_[static_cast<std::size_t>(contact.a)].touches.push_back({other, point_m, force_n, link_a, link_b});
    if (contact.b != kFixedBody)
      bodies_[other].touches.push_back({static_cast<std::uint64_t>(contact.a), point_m, -force_n, link_b, link_a});
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
  for (const std::size_t k : awake_) {
    if (may_stop_[k] != 0) may_stop_[groups_.of(k)] = 1;
  }
  for (const std::size_t k : awake_) {
    // A body with an arm never stops: its joints may move, or its arm may pull it away. Nor does one on a path.
    const bool is_slow = fastest_m_s(states_[k].velocity_body, finder_.radius_m(hulls_[k])) <= kSlow_m_s;
    if (!is_slow || bodies_[k].arm || bodies_[k].spec.path) may_stop_[groups_.of(k)] = 0;
  }
  for (const std::size_t group : awake_) {
    if (groups_.of(group) == group && may_stop_[group] != 0) stop_if_held(group, now);
  }
}

void UwsimEngine::stop_if_held(std::size_t group, const Interval& now) {
  const bool is_new = try_stopping(group, now);
  bool holds = true, is_firm = true, pushes = false;
  for (const std::size_t k : awake_) {
    if (groups_.of(k) != group) continue;
    const Hold hold(stopped_bodies_[k], free_velocities_body_[k], finder_.radius_m(hulls_[k]), now.step_s);
    holds = holds && hold.holds;
    is_firm = is_firm && hold.is_firm;
    pushes = pushes || hold.pushes;
  }
  if (!holds) return;
  for (std::size_t k = 0, stopped = 0; is_new && k < contacts_.size(); ++k) {
    if (!is_within(contacts_[k], group)) continue;
    impulses_world_[k] = solver_.impulse_world(contacts_[k], stopped++);
  }
  for (const std::size_t k : awake_) {
    if (groups_.of(k) != group) continue;
    stop(k);
    if (pushes) {
      free_steps_[k].is_known = false;
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
  for (const std::size_t k : awake_) {
    if (groups_.of(k) != group) continue;
    are_still = are_still && states_[k].velocity_body.isZero(0);
    stopped_bodies_[k] = contact_bodies_[k];
    free_velocities_body_[k] = next_states_[k].velocity_body;
  }
  if (are_still) return false;
  for (const std::size_t k : awake_) {
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
