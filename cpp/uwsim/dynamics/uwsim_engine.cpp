#include "uwsim/dynamics/uwsim_engine.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace uwsim {
namespace {

constexpr std::size_t kContactsPerBody = 128;  // with more contacts, a step allocates memory
// In each part of a step, a body near a contact turns by at most this angle and moves by at most this fraction of its
// thickness.
constexpr double kMostTurn_rad = 0.2, kMostTravel = 0.25;
constexpr double kMostParts = 100;

/// The convex hull of a link's shape.
std::vector<ConvexPiece> pieces_of(const ArmLink& link) {
  if (link.surface_m == nullptr) return {};
  return {link.surface_m->vertices_m};
}

}  // namespace

UwsimEngine::UwsimEngine(const World& world, double step_s) : step_s_(step_s), finder_(world) {}

void UwsimEngine::add_body(const BodySpec& spec) {
  const std::size_t body = hulls_.size();
  hulls_.push_back(colliders_.size());
  colliders_.push_back({body, kHull});
  finder_.add_body(spec.collision_pieces_body_m, spec.round);
  for (std::size_t k = 0; k < spec.arm.size(); ++k) {
    colliders_.push_back({body, static_cast<int>(k)});
    finder_.add_body(pieces_of(spec.arm[k]));
  }
  resting_.emplace_back();
  const std::size_t count = resting_.size();
  states_.resize(count);
  free_steps_.resize(count);
  for (std::vector<std::size_t>* indices : {&awake_, &moves_}) indices->reserve(count);
  for (std::vector<std::uint8_t>* flags : {&takes_part_, &rests_, &may_stop_, &is_clear_}) flags->resize(count);
  for (std::vector<ContactBody>* bodies : {&contact_bodies_, &stopped_bodies_}) bodies->resize(count);
  for (std::vector<Contact>* contacts : {&contacts_, &stopped_contacts_}) contacts->reserve(kContactsPerBody * count);
  impulses_world_.reserve(kContactsPerBody * count);
  free_velocities_body_.resize(count);
  parts_.resize(count);
  moving_.resize(colliders_.size());
  link_motions_.resize(colliders_.size());
  extents_m_.resize(count);
  reaches_m_.resize(count);
  arms_.resize(count);
  groups_.reserve(count);
  solver_.reserve(count, kContactsPerBody * count);
  forget(count - 1);
}

void UwsimEngine::change_body(std::size_t body, const BodySpec& from, const BodySpec& to) {
  const std::size_t hull = hulls_[body];
  if (from.collision_pieces_body_m != to.collision_pieces_body_m || from.round != to.round)
    finder_.set_body(hull, to.collision_pieces_body_m, to.round);
  for (std::size_t k = 0; k < to.arm.size(); ++k) {
    if (from.arm[k].surface_m != to.arm[k].surface_m) finder_.set_body(hull + 1 + k, pieces_of(to.arm[k]));
  }
  forget(body);
}

/// Forgets all, because a body that is known to be at rest may have been supported by another.
void UwsimEngine::forget(std::size_t) {
  for (Resting& resting : resting_) resting.forget();
  for (FreeStep& step : free_steps_) step.is_known = false;
}

void UwsimEngine::exchange_contacts(StateArchive& archive) {
  for (Resting& resting : resting_) resting.exchange_state(archive);
}

void UwsimEngine::step(std::span<MovedBody> bodies, std::span<BodyState> next_states, const WaterField& water,
                       double time_s) {
  bodies_ = bodies;
  next_states_ = next_states;
  const Interval whole{water, time_s, step_s_};
  watch(water);
  find_sleepers(whole);
  for (const std::size_t k : awake_) {
    takes_part_[k] = bodies_[k].held ? 0 : 1;
    begin_step(k);
    if (bodies_[k].held && bodies_[k].arm) bodies_[k].arm->advance(HeldBase(), states_[k], water, time_s, step_s_);
  }
  move(whole);
  find_parts();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (parts_[k] > 1) repeat_in_parts(k, whole);
  }
}

/// Lets those bodies sleep of which is known that the whole step will leave them at rest, unless another comes near.
void UwsimEngine::find_sleepers(const Interval& whole) {
  awake_.clear();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    MovedBody& body = bodies_[k];
    const FreeStep& free = free_steps_[k];
    body.sleeps = free.is_known && rests_[k] != 0 && is_unloaded(body);
    if (!body.sleeps) {
      awake_.push_back(k);
      continue;
    }
    takes_part_[k] = rests_[k] = 1;
    reaches_m_[k] = moving_[hulls_[k]].reach_m = free.reach_m;
    moving_[hulls_[k]].collides = false;
    body.motions.back().time_s = whole.time_s;  // the rest of the last step holds for this one
  }
}

/// Makes a body that sleeps take part in the step under way.
void UwsimEngine::wake(std::size_t body) {
  bodies_[body].sleeps = bodies_[body].in_contact = bodies_[body].motions.back().stops = false;
  next_states_[body] = free_steps_[body].to;
  awake_.push_back(body);
}

/// Wakes all bodies if the water is not as it was in the last step.
void UwsimEngine::watch(const WaterField& water) {
  const std::optional<SteadyWater> now = water.steady();
  if (now != steady_) {
    for (FreeStep& step : free_steps_) step.is_known = false;
  }
  steady_ = now;
}

bool UwsimEngine::is_unloaded(const MovedBody& body) {
  Vector6d size = body.tau_body.cwiseAbs();
  for (const Vector6d* load : {&body.applied.body, &body.applied.world, &body.tether_world, &body.canopy_world})
    size += load->cwiseAbs();
  return size.sum() == 0;
}

void UwsimEngine::begin_step(std::size_t body) {
  states_[body] = next_states_[body] = bodies_[body].state;
  bodies_[body].in_contact = bodies_[body].sleeps = false;
  bodies_[body].motions.clear();
  if (bodies_[body].arm) bodies_[body].arm->begin();
}

/// Determines, for each body, into how many parts its step must be divided because of its contacts.
void UwsimEngine::find_parts() {
  std::ranges::fill(parts_, 1);
  for (const Contact& contact : contacts_) {
    for (const bool is_a : {true, false}) {
      const int touched = is_a ? contact.a : contact.b, link = is_a ? contact.link_a : contact.link_b;
      if (touched == kFixedBody) continue;
      const auto body = static_cast<std::size_t>(touched);
      const std::size_t collider = hulls_[body] + static_cast<std::size_t>(1 + link);
      double turn_rad_s = 0, travel_m_s = 0;
      for (const BodyState& state : {states_[body], next_states_[body]}) {
        if (link != kHull) break;
        turn_rad_s = std::max(turn_rad_s, state.angular_body_rad_s().norm());
        travel_m_s = std::max(travel_m_s, state.linear_body_m_s().norm());
      }
      if (link != kHull) {
        turn_rad_s = link_motions_[collider].turn_rad_s;
        travel_m_s = link_motions_[collider].linear_m_s;
      }
      const double parts =
          step_s_ * std::max(turn_rad_s / kMostTurn_rad, travel_m_s / (kMostTravel * finder_.thickness_m(collider)));
      if (!std::isfinite(parts)) continue;
      const int count = static_cast<int>(std::clamp(std::ceil(parts), 1.0, kMostParts));
      parts_[body] = bodies_[body].arm ? std::max(parts_[body], count) : count;
    }
  }
}

/// Repeats the step, in parts, for a body and for all bodies that it could touch, directly or through others.
void UwsimEngine::repeat_in_parts(std::size_t body, const Interval& whole) {
  awake_.resize(bodies_.size());
  std::iota(awake_.begin(), awake_.end(), 0);
  std::ranges::fill(takes_part_, 0);
  takes_part_[body] = 1;
  find_reaches(whole.step_s);
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t a = 0; a < bodies_.size(); ++a) {
      for (std::size_t b = 0; b < bodies_.size(); ++b) {
        if (takes_part_[a] == 0 || takes_part_[b] != 0 || bodies_[b].held || !are_near(a, b)) continue;
        takes_part_[b] = 1;
        grows = true;
      }
    }
  }
  int parts = 1;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (takes_part_[k] == 0) continue;
    parts = std::max(parts, parts_[k]);
    parts_[k] = 1;
    bodies_[k].touches.clear();
    begin_step(k);
  }
  const double part_s = whole.step_s / parts;
  for (int part = 0; part < parts; ++part) {
    move({whole.water, whole.time_s + part * part_s, part_s});
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      if (takes_part_[k] == 0) continue;
      states_[k] = next_states_[k];
      if (bodies_[k].arm) bodies_[k].arm->next_part();
    }
  }
}

}  // namespace uwsim
