#include "uwsim/dynamics/rigid_body_world.h"

#include <algorithm>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/symmetric.h"
#include "uwsim/dynamics/contact_shapes.h"

namespace uwsim {
namespace {

constexpr std::size_t kMotions = 4, kTouches = 32;  // with more, a step allocates memory

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
  return joined((now.linear_body_m_s() - now_from_before * before.linear_body_m_s()) / step_s -
                    now.angular_body_rad_s().cross(now.linear_body_m_s()),
                (now.angular_body_rad_s() - now_from_before * before.angular_body_rad_s()) / step_s);
}

}  // namespace

RigidBodyWorld::RigidBodyWorld(const World& world, double step_s, EngineKind engine)
    : step_s_(step_s),
      kind_(engine),
      engine_(make_engine(engine, world, step_s)),
      world_(world),
      covered_(world.cover().empty() ? nullptr : fixed_surfaces(world)) {}

std::size_t RigidBodyWorld::add_body(BodySpec spec, const BodyState& state) {
  spec = checked(std::move(spec));
  require(spec.arm.empty() || kind_ == EngineKind::kUwsim, "dynamics.engine", "bullet",
          "must be uwsim for an arm: Bullet's bodies have no mass matrix that it could share");
  std::optional<Arm> arm;
  if (!spec.arm.empty()) arm.emplace(spec.arm, step_s_);
  require(!spec.path || kind_ == EngineKind::kUwsim, "dynamics.engine", "bullet", "must be uwsim for bodies on a path");
  engine_->add_body(spec);
  MovedBody& body = bodies_.emplace_back();
  body.spec = std::move(spec);
  body.state = state;
  body.arm = std::move(arm);
  body.motions.reserve(kMotions);
  body.touches.reserve(kTouches);
  next_states_.push_back(state);
  return bodies_.size() - 1;
}

void RigidBodyWorld::change_bodies(std::vector<BodySpec> specs) {
  require(specs.size() == bodies_.size(), "bodies", specs.size(), "must be one for each");
  std::vector<std::optional<Arm>> arms(specs.size());
  for (std::size_t k = 0; k < specs.size(); ++k) {
    specs[k] = checked(std::move(specs[k]));
    require(specs[k].arm.size() == bodies_[k].spec.arm.size(), "arm.links", specs[k].arm.size(), "cannot be changed");
    if (bodies_[k].arm) arms[k].emplace(bodies_[k].arm->with_links(specs[k].arm, step_s_));
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    engine_->change_body(k, bodies_[k].spec, specs[k]);
    bodies_[k].spec = std::move(specs[k]);
    bodies_[k].arm = std::move(arms[k]);
    bodies_[k].forget_step();
  }
  for (Tether& tether : tethers_) tether.set_bodies(bodies_);
}

void RigidBodyWorld::change_links(std::size_t body, std::vector<ArmLink> links) {
  MovedBody& changed = bodies_.at(body);
  require(changed.arm.has_value(), "arm", "none", "must be there");
  changed.arm = changed.arm->with_links(links, step_s_);
  changed.spec.arm = std::move(links);
  changed.forget_step();
  engine_->forget(body);
}

Matrix6d RigidBodyWorld::inverse_mass(std::size_t body, const WaterField& water, double time_s) {
  MovedBody& moved = bodies_.at(body);
  if (moved.held) return Matrix6d::Zero();
  Matrix6d mass = moved.base_mass(moved.state.world_from_body, water, time_s);
  if (moved.arm) mass += moved.arm->placed(moved.state, water, time_s).locked_inertia();
  return inverse_of_positive(mass);
}

void RigidBodyWorld::set_state(std::size_t body, const BodyState& state) {
  bodies_.at(body).state = state;
  bodies_[body].acceleration_body.setZero();
  bodies_[body].in_contact = false;
  bodies_[body].forget_step();
  engine_->forget(body);
}

void RigidBodyWorld::hold(std::size_t body, bool held) {
  bodies_.at(body).held = held;
  bodies_[body].forget_step();
  engine_->forget(body);
}

std::size_t RigidBodyWorld::add_tether(const TetherSpec& spec, const WaterField& water, double time_s) {
  require(kind_ == EngineKind::kUwsim, "dynamics.engine", "bullet",
          "must be uwsim for a tether: Bullet's bodies have no mass matrix that it could share");
  for (const TetherEnd* end : {&spec.first, &spec.second}) {
    require(end->body < bodies_.size() || end->body == TetherEnd::kNoBody, spec.name + " end", end->body,
            "must be a body");
  }
  tethers_.emplace_back(spec, world_, bodies_).lay(bodies_, water, time_s);
  return tethers_.size() - 1;
}

void RigidBodyWorld::require_tethers_reach(std::size_t body, const Pose& world_from_body, const WaterField& water,
                                           double time_s) const {
  if (tethers_.empty()) return;
  std::vector<MovedBody> placed = bodies_;
  placed.at(body).state.world_from_body = world_from_body;
  for (const Tether& tether : tethers_) {
    if (tether.holds(body)) tether.require_reaches(placed, water, time_s);
  }
}

void RigidBodyWorld::lay_tethers(std::size_t body, const WaterField& water, double time_s) {
  for (Tether& tether : tethers_) {
    if (tether.holds(body)) tether.lay(bodies_, water, time_s);
  }
}

void RigidBodyWorld::step(const WaterField& water, double time_s) {
  if (!tethers_.empty()) {
    for (MovedBody& body : bodies_) body.tether_world.setZero();
    for (Tether& tether : tethers_) tether.step(bodies_, water, time_s, step_s_);
  }
  if (has_plants()) {
    for (MovedBody& body : bodies_) body.canopy_world = canopy_drag(body, body.state, water, time_s);
  }
  engine_->step(bodies_, next_states_, water, time_s);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (bodies_[k].sleeps) continue;
    if (bodies_[k].spec.path)
      next_states_[k] = bodies_[k].spec.path->at(time_s + step_s_);  // whatever the step's parts
    bodies_[k].require_plausible(next_states_[k], time_s, step_s_);
  }
  // Either all bodies move, or, if the step fails, none.
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    MovedBody& body = bodies_[k];
    if (body.sleeps) continue;
    body.acceleration_body = mean_rate(body.state, next_states_[k], step_s_);
    body.state = next_states_[k];
    if (body.arm) body.arm->accept();
  }
  engine_->moved();
  for (Tether& tether : tethers_) tether.moved(bodies_, step_s_);
}

void RigidBodyWorld::exchange_state(StateArchive& archive) {
  archive.same("bodies", bodies_.size());
  for (MovedBody& body : bodies_) {
    archive(body.state);
    archive(body.tau_body);
    archive(body.acceleration_body);
    archive(body.held);
    archive(body.in_contact);
    body.require_plausible(body.state, 0, step_s_);
  }
  if (!archive.restoring()) return;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    bodies_[k].forget_step();
    engine_->forget(k);
  }
}

void RigidBodyWorld::exchange_contacts(StateArchive& archive) { engine_->exchange_contacts(archive); }

void RigidBodyWorld::exchange_last_step(StateArchive& archive) {
  for (MovedBody& body : bodies_) {
    archive.list(body.motions, [&](Motion& motion) {
      archive(motion.start);
      archive(motion.actuators_body);
      for (Loads* loads : {&motion.applied, &motion.all}) {
        archive(loads->body);
        archive(loads->world);
      }
      archive(motion.time_s);
      archive(motion.step_s);
      archive(motion.stops);
      require(motion.step_s > 0 && motion.step_s <= step_s_, "state.motion.step_s", motion.step_s,
              "must be a part of a step");
    });
    archive.list(body.touches, [&](Touch& touch) {
      archive(touch.other);
      for (Eigen::Vector3d* vector : {&touch.point_world_m, &touch.force_world_n}) {
        for (double& value : *vector) archive(value);
      }
      require(touch.other < bodies_.size() || touch.other == Touch::kNoBody, "state.touch", touch.other,
              "must be a body");
    });
  }
}

void RigidBodyWorld::exchange_wind(StateArchive& archive) {
  for (MovedBody& body : bodies_) {
    for (Motion& motion : body.motions) archive(motion.wind_body);
  }
}

void RigidBodyWorld::exchange_tethers(StateArchive& archive) {
  if (tethers_.empty()) return;
  archive.same("tethers", tethers_.size());
  for (Tether& tether : tethers_) tether.exchange_state(archive);
  for (MovedBody& body : bodies_) {
    archive(body.tether_world);
    for (Motion& motion : body.motions) motion.tether_world = body.tether_world;
  }
}

namespace {

void exchange_link(StateArchive& archive, std::uint64_t& link, const MovedBody& body) {
  archive(link);
  require(link == Touch::kNoLink || (body.arm && link < body.arm->size()), "state.touch.link", link,
          "must be a link of the arm");
}

}  // namespace

void RigidBodyWorld::exchange_arms(StateArchive& archive) {
  for (MovedBody& body : bodies_) {
    if (!body.arm) continue;
    body.arm->exchange_state(archive);
    for (Motion& motion : body.motions) {
      if (!motion.arm_body) motion.arm_body.emplace();
      for (Vector6d& wrench : *motion.arm_body) archive(wrench);
    }
  }
  if (std::ranges::none_of(bodies_, [](const MovedBody& body) { return body.arm.has_value(); })) return;
  for (MovedBody& body : bodies_) {
    for (Touch& touch : body.touches) {
      exchange_link(archive, touch.link, body);
      if (touch.other != Touch::kNoBody) exchange_link(archive, touch.other_link, bodies_[touch.other]);
    }
  }
}

void RigidBodyWorld::require_forces() const {
  require(kind_ == EngineKind::kUwsim, "dynamics.engine", "bullet",
          "must be uwsim for forces: Bullet folds added mass into mass and inertia, which is not in these terms");
}

Forces RigidBodyWorld::forces(std::size_t body, const WaterField& water, double time_s) const {
  require_forces();
  const BodySpec& spec = bodies_.at(body).spec;
  require(!spec.path, "forces", spec.name, "must not follow a path, on which no force moves it");
  const MovedBody& moved = bodies_.at(body);
  if (!has_plants()) return forces_on(moved, Vector6d::Zero(), water, time_s, step_s_);
  const bool has_moved = !moved.held && !moved.motions.empty();
  const Vector6d drag = has_moved ? canopy_drag(moved, moved.motions.front().start, water, moved.motions.front().time_s)
                                  : canopy_drag(moved, moved.state, water, time_s);
  return forces_on(moved, drag, water, time_s, step_s_);
}

bool RigidBodyWorld::has_plants() const { return covered_ && covered_->canopy; }

const CoverLayer* RigidBodyWorld::cover_around(const Eigen::Vector3d& point_world_m) const {
  return covered_ && covered_->cover ? covered_->cover->layer_around(point_world_m) : nullptr;
}

/// The drag of plants on a body in a step that begins at this state.
Vector6d RigidBodyWorld::canopy_drag(const MovedBody& body, const BodyState& state, const WaterField& water,
                                     double time_s) const {
  if (body.held || body.spec.path) return Vector6d::Zero();
  return covered_->canopy->drag_world(*body.spec.craft, state, water, time_s, step_s_);
}

const std::vector<Touch>& RigidBodyWorld::touches(std::size_t body) const {
  require_forces();
  return bodies_.at(body).touches;
}

}  // namespace uwsim
