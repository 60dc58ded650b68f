#include "uwsim/dynamics/rigid_body_world.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/dynamics/contact_budget.h"
#include "uwsim/dynamics/integrator.h"

namespace uwsim {
namespace {

constexpr double kDiverged = 1e7;  // m, m/s and rad/s; only a diverging body reaches this
// A gap smaller than this counts as touching, as does every contact with an impulse.
constexpr double kTouch_m = 1e-3;
constexpr double kReachPerMotion = 1.5;        // search distance for contacts, as a multiple of the motion in a step
constexpr double kLeastReach_m = 0.0015;       // must exceed kTouch_m
constexpr std::size_t kContactsPerBody = 128;  // a step that needs more allocates

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
  next_states_.resize(bodies_.size());
  rests_.resize(bodies_.size());
  moving_.resize(bodies_.size());
  contact_bodies_.resize(bodies_.size());
  contacts_.reserve(kContactsPerBody * bodies_.size());
  solver_.reserve(bodies_.size(), kContactsPerBody * bodies_.size());
  return bodies_.size() - 1;
}

void RigidBodyWorld::change_bodies(std::vector<BodySpec> specs) {
  require(specs.size() == bodies_.size(), "bodies", specs.size(), "must be one for each");
  for (BodySpec& spec : specs) spec = checked(std::move(spec));
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (specs[k].collision_pieces_body_m != bodies_[k].spec.collision_pieces_body_m) {
      finder_.set_body(k, specs[k].collision_pieces_body_m);
    }
    bodies_[k].spec = std::move(specs[k]);
    bodies_[k].resting.forget();
  }
}

void RigidBodyWorld::set_state(std::size_t body, const BodyState& state) {
  bodies_.at(body).state = state;
  bodies_[body].acceleration_body.setZero();
  bodies_[body].in_contact = false;
}

void RigidBodyWorld::step(const WaterField& water, double time_s) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Body& body = bodies_[k];
    next_states_[k] =
        body.held ? body.state : advance(*body.spec.craft, body.state, {.body = body.tau_body}, water, time_s, step_s_);
    require_plausible(body, next_states_[k], time_s);  // checked before a diverging body can hit another
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) rests_[k] = stays_at_rest(k) ? 1 : 0;
  find_contacts();
  if (!contacts_.empty()) solve_contacts(water, time_s);
  for (std::size_t k = 0; k < bodies_.size(); ++k) require_plausible(bodies_[k], next_states_[k], time_s);
  // Either all bodies move, or, if the step fails, none.
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    Body& body = bodies_[k];
    body.acceleration_body = mean_rate(body.state, next_states_[k], step_s_);
    body.state = next_states_[k];
  }
}

/// Whether a body is known to stay where it is: held by terrain and solids, with no other body nearby.
bool RigidBodyWorld::stays_at_rest(std::size_t body) const {
  const Body& it = bodies_[body];
  if (it.held || !it.resting.lasts(it.state, next_states_[body].velocity_body)) return false;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (k == body || bodies_[k].held) continue;
    const double near_m = finder_.radius_m(body) + finder_.radius_m(k) + reach_m(body) + reach_m(k);
    const Eigen::Vector3d between = bodies_[k].state.world_from_body.position_m - it.state.world_from_body.position_m;
    if (between.squaredNorm() < near_m * near_m) return false;
  }
  return true;
}

/// Finds the contacts, at the present poses, whose gaps this step could close.
void RigidBodyWorld::find_contacts() {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const bool rests = rests_[k] != 0;
    bodies_[k].in_contact = rests;
    if (rests) next_states_[k] = bodies_[k].state;
    moving_[k] = {bodies_[k].state.world_from_body, reach_m(k), !bodies_[k].held && !rests};
  }
  try {
    finder_.find(moving_, contacts_);
  } catch (const ContactBudgetExceeded& error) {
    throw InvalidValue("vehicle '" + bodies_[error.body].spec.name + "', " + error.what());
  }
  for (Contact& contact : contacts_) combine_materials(contact);
}

double RigidBodyWorld::reach_m(std::size_t body) const {
  const auto speed = [&](const BodyState& state) {
    return state.linear_body_m_s().norm() + finder_.radius_m(body) * state.angular_body_rad_s().norm();
  };
  const double fastest_m_s = std::max(speed(bodies_[body].state), speed(next_states_[body]));
  // A diverged state is rejected later; its reach must not be infinite.
  if (!std::isfinite(fastest_m_s)) return 0;
  return std::max(kLeastReach_m, kReachPerMotion * fastest_m_s * step_s_);
}

void RigidBodyWorld::combine_materials(Contact& contact) const {
  const BodySpec& a = bodies_[static_cast<std::size_t>(contact.a)].spec;
  const BodySpec& b = contact.b == kFixedBody ? a : bodies_[static_cast<std::size_t>(contact.b)].spec;
  contact.friction = std::sqrt(a.friction * b.friction);
  contact.restitution = std::max(a.restitution, b.restitution);
}

/// Computes impulses for the velocities at the end of a step without contacts, then applies them as constant forces
/// over the step. A body at rest thus stays at rest, the momentum of two bodies is conserved, and the work done equals
/// that of the impulses.
void RigidBodyWorld::solve_contacts(const WaterField& water, double time_s) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    contact_bodies_[k] = {.world_from_body = bodies_[k].state.world_from_body,
                          .velocity_body = next_states_[k].velocity_body,
                          .start_velocity_body = bodies_[k].state.velocity_body};
  }
  for (const Contact& contact : contacts_) {
    for (const int body : {contact.a, contact.b}) {
      if (body == kFixedBody) continue;
      ContactBody& touched = contact_bodies_[static_cast<std::size_t>(body)];
      if (!touched.inverse_mass.isZero(0)) continue;
      touched.inverse_mass =
          bodies_[static_cast<std::size_t>(body)].spec.craft->inverse_mass(touched.world_from_body, water, time_s);
    }
  }
  solver_.solve(contact_bodies_, contacts_, step_s_);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const ContactBody& solved = contact_bodies_[k];
    if (solved.impulse_body.isZero(0) && solved.push_body.isZero(0)) continue;
    if (bodies_[k].resting.begins(solved, next_states_[k].velocity_body, finder_.radius_m(k))) {
      next_states_[k] = {bodies_[k].state.world_from_body, Vector6d::Zero()};
      continue;
    }
    Loads loads{.body = bodies_[k].tau_body};
    const Eigen::Quaterniond& q = solved.world_from_body.orientation;
    loads.world << q * solved.impulse_body.head<3>() / step_s_, q * solved.impulse_body.tail<3>() / step_s_;
    next_states_[k] = advance(*bodies_[k].spec.craft, bodies_[k].state, loads, water, time_s, step_s_);
    next_states_[k].world_from_body = displaced(next_states_[k].world_from_body, solved.push_body, step_s_);
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (contacts_[k].gap_m > kTouch_m && solver_.normal_impulse(k) == 0) continue;
    bodies_[static_cast<std::size_t>(contacts_[k].a)].in_contact = true;
    if (contacts_[k].b != kFixedBody) bodies_[static_cast<std::size_t>(contacts_[k].b)].in_contact = true;
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
