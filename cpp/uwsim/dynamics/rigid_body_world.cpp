#include "uwsim/dynamics/rigid_body_world.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kDiverged = 1e7;              // m, m/s and rad/s: only a diverging body gets this far
constexpr std::size_t kContactsPerBody = 128;  // with more contacts, a step allocates memory
// In each part of a step, a body near a contact turns by at most this angle and moves by at most this fraction of its
// thickness.
constexpr double kMostTurn_rad = 0.2, kMostTravel = 0.25;
constexpr double kMostParts = 100;

/// Returns the spec with its collision pieces filled in. Throws InvalidValue.
BodySpec checked(BodySpec spec) {
  spec.check();
  spec.collision_pieces_body_m =
      collision_pieces(spec.craft->hull().mesh_body(), spec.shape, std::move(spec.collision_pieces_body_m));
  return spec;
}

/// The mean nu' over a step, computed from the changes of the linear and the angular velocity along the world axes. The
/// plain difference of nu is taken along rotating axes and thus belongs to the middle of the step. Added to w x v at
/// the step's end, it would yield a spurious acceleration, dt/2 w x (w x v) for a body that turns while moving
/// straight, and integrating that would yield motion.
Vector6d mean_rate(const BodyState& before, const BodyState& now, double step_s) {
  const Eigen::Quaterniond now_from_before =
      now.world_from_body.orientation.conjugate() * before.world_from_body.orientation;
  Vector6d rate;
  rate << (now.linear_body_m_s() - now_from_before * before.linear_body_m_s()) / step_s -
              now.angular_body_rad_s().cross(now.linear_body_m_s()),
      (now.angular_body_rad_s() - now_from_before * before.angular_body_rad_s()) / step_s;
  return rate;
}

}  // namespace

void BodySpec::check() const {
  require(craft != nullptr, "vehicle '" + name + "' craft", "none", "must be set");
  require(friction >= 0 && friction <= 10, "vehicle.friction", friction, "must be in [0, 10]");
  require(restitution >= 0 && restitution <= 1, "vehicle.restitution", restitution, "must be in [0, 1]");
}

RigidBodyWorld::RigidBodyWorld(const World& world, double step_s) : step_s_(step_s), finder_(world) {}

std::size_t RigidBodyWorld::add_body(BodySpec spec, const BodyState& state) {
  spec = checked(std::move(spec));
  finder_.add_body(spec.collision_pieces_body_m);
  bodies_.push_back({.spec = std::move(spec), .state = state});
  const std::size_t count = bodies_.size();
  for (std::vector<BodyState>* states : {&states_, &next_states_}) states->resize(count);
  for (std::vector<std::uint8_t>* flags : {&takes_part_, &rests_, &may_stop_}) flags->resize(count);
  for (std::vector<ContactBody>* bodies : {&contact_bodies_, &stopped_bodies_}) bodies->resize(count);
  for (std::vector<Contact>* contacts : {&contacts_, &stopped_contacts_}) contacts->reserve(kContactsPerBody * count);
  free_velocities_body_.resize(count);
  parts_.resize(count);
  moving_.resize(count);
  groups_.reserve(count);
  solver_.reserve(count, kContactsPerBody * count);
  forget_rests();
  return count - 1;
}

void RigidBodyWorld::change_bodies(std::vector<BodySpec> specs) {
  require(specs.size() == bodies_.size(), "bodies", specs.size(), "must be one for each");
  for (BodySpec& spec : specs) spec = checked(std::move(spec));
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (specs[k].collision_pieces_body_m != bodies_[k].spec.collision_pieces_body_m) {
      finder_.set_body(k, specs[k].collision_pieces_body_m);
    }
    bodies_[k].spec = std::move(specs[k]);
  }
  forget_rests();
}

void RigidBodyWorld::set_state(std::size_t body, const BodyState& state) {
  bodies_.at(body).state = state;
  bodies_[body].acceleration_body.setZero();
  bodies_[body].in_contact = false;
  forget_rests();
}

void RigidBodyWorld::hold(std::size_t body, bool held) {
  bodies_.at(body).held = held;
  forget_rests();
}

/// Needed because a body that is known to rest may have been supported by another.
void RigidBodyWorld::forget_rests() {
  for (Body& body : bodies_) body.resting.forget();
}

void RigidBodyWorld::step(const WaterField& water, double time_s) {
  const Interval whole{water, time_s, step_s_};
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    takes_part_[k] = bodies_[k].held ? 0 : 1;
    begin_step(k);
  }
  move(whole);
  find_parts();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (parts_[k] > 1) repeat_in_parts(k, whole);
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) require_plausible(bodies_[k], next_states_[k], time_s);
  // Either all bodies move, or, if the step fails, none.
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    Body& body = bodies_[k];
    body.acceleration_body = mean_rate(body.state, next_states_[k], step_s_);
    body.state = next_states_[k];
  }
}

void RigidBodyWorld::begin_step(std::size_t body) {
  states_[body] = next_states_[body] = bodies_[body].state;
  bodies_[body].in_contact = false;
}

/// Determines, for each body, into how many parts its step must be divided because of its contacts.
void RigidBodyWorld::find_parts() {
  std::ranges::fill(parts_, 1);
  for (const Contact& contact : contacts_) {
    for (const int touched : {contact.a, contact.b}) {
      if (touched == kFixedBody) continue;
      const auto body = static_cast<std::size_t>(touched);
      double turn_rad_s = 0, travel_m_s = 0;
      for (const BodyState& state : {states_[body], next_states_[body]}) {
        turn_rad_s = std::max(turn_rad_s, state.angular_body_rad_s().norm());
        travel_m_s = std::max(travel_m_s, state.linear_body_m_s().norm());
      }
      const double parts =
          step_s_ * std::max(turn_rad_s / kMostTurn_rad, travel_m_s / (kMostTravel * finder_.thickness_m(body)));
      if (std::isfinite(parts)) parts_[body] = static_cast<int>(std::clamp(std::ceil(parts), 1.0, kMostParts));
    }
  }
}

/// Repeats the step, in parts, for a body and for all bodies that it could touch, directly or through others.
void RigidBodyWorld::repeat_in_parts(std::size_t body, const Interval& whole) {
  std::ranges::fill(takes_part_, 0);
  takes_part_[body] = 1;
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t a = 0; a < bodies_.size(); ++a) {
      for (std::size_t b = 0; b < bodies_.size(); ++b) {
        if (takes_part_[a] == 0 || takes_part_[b] != 0 || bodies_[b].held || !are_near(a, b, whole.step_s)) continue;
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
    begin_step(k);
  }
  const double part_s = whole.step_s / parts;
  for (int part = 0; part < parts; ++part) {
    move({whole.water, whole.time_s + part * part_s, part_s});
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      if (takes_part_[k] != 0) states_[k] = next_states_[k];
    }
  }
}

void RigidBodyWorld::exchange_state(StateArchive& archive) {
  archive.same("bodies", bodies_.size());
  for (Body& body : bodies_) {
    archive(body.state);
    archive(body.tau_body);
    archive(body.acceleration_body);
    archive(body.held);
    archive(body.in_contact);
    require_plausible(body, body.state, 0);
  }
  if (archive.restoring()) forget_rests();
}

void RigidBodyWorld::require_plausible(const Body& body, const BodyState& next, double time_s) const {
  const bool plausible = next.velocity_body.cwiseAbs().maxCoeff() < kDiverged &&
                         next.world_from_body.position_m.cwiseAbs().maxCoeff() < kDiverged &&
                         next.world_from_body.orientation.coeffs().allFinite();  // false for NaN as well
  if (!plausible) {
    std::ostringstream last;
    last << "[" << body.state.world_from_body.position_m.transpose() << " m; " << body.state.velocity_body.transpose()
         << " m/s, rad/s]";
    std::ostringstream path;
    path << "vehicle '" << body.spec.name << "', step " << std::llround(time_s / step_s_) << ": last finite state";
    require(false, path.str(), last.str(),
            "the motion diverged: use a smaller step_s or check the vehicle's coefficients");
  }
}

}  // namespace uwsim
