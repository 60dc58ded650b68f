#include "uwsim/dynamics/forces.h"

#include <array>
#include <optional>

namespace uwsim {
namespace {

constexpr std::array kTerms = {&Craft::Terms::weight, &Craft::Terms::buoyancy, &Craft::Terms::drag,
                               &Craft::Terms::added_mass, &Craft::Terms::coriolis};

void add(Forces& sum, double share, const Craft::Terms& terms) {
  for (const auto term : kTerms) sum.craft.*term += share * terms.*term;
}

/// `arm` is a copy, which moves on.
Vector6d arm_at_instant(Arm arm, const MovedBody& body, const WaterField& water, double time_s, double step_s) {
  const Loads none;
  arm.begin();
  if (body.held) {
    arm.advance(HeldBase(), body.state, water, time_s, step_s);
  } else {
    arm.advance(CraftBase(*body.spec.craft, none, water), body.state, water, time_s, step_s);
  }
  return arm.stage_wrenches()[0];
}

Forces at_instant(const MovedBody& body, const Vector6d& canopy_world, const WaterField& water, double time_s,
                  double step_s) {
  const Craft& craft = *body.spec.craft;
  Forces forces;
  if (body.arm) forces.arm = arm_at_instant(*body.arm, body, water, time_s, step_s);
  Vector6d of_parts = forces.arm;
  const Vector6d canopy = in_body_axes(canopy_world, body.state.world_from_body.orientation);
  if (!canopy.isZero(0)) of_parts += canopy;
  const Vector6d rate = body.held ? Vector6d::Zero() : craft.acceleration_body(body.state, of_parts, water, time_s);
  forces.craft = craft.terms(body.state, rate, water, time_s);
  if (!canopy.isZero(0)) forces.craft.drag += canopy;
  if (body.held) forces.dock = -forces.sum();
  return forces;
}

/// The applied part includes the wind's.
void part_wind(Forces& forces, const Motion& motion) {
  if (motion.wind_body.isZero(0)) return;
  forces.wind = motion.wind_body;
  forces.applied -= motion.wind_body;
}

Forces that_stop(const Craft& craft, const Motion& motion, const WaterField& water) {
  const BodyState still{.world_from_body = motion.start.world_from_body};
  const Vector6d rate = -motion.start.velocity_body / motion.step_s;
  Forces forces;
  forces.craft = craft.terms(still, rate, water, motion.time_s);
  forces.actuators = motion.actuators_body;
  forces.applied = motion.applied.body + in_body_axes(motion.applied.world, still.world_from_body.orientation);
  part_wind(forces, motion);
  forces.tether = in_body_axes(motion.tether_world, still.world_from_body.orientation);
  forces.contact = craft.rigid_mass() * rate - forces.sum();
  return forces;
}

Forces that_move(const Craft& craft, const Motion& motion, const Vector6d& canopy_world, const WaterField& water) {
  Forces forces;
  forces.actuators = motion.actuators_body;
  const std::optional<std::array<Vector6d, 4>>& arm = motion.arm_body;
  const auto all = stages(craft, motion.start, motion.all, water, motion.time_s, motion.step_s, arm ? &*arm : nullptr);
  NearbyWater nearby;  // kept as in `stages`
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Stage& stage = all[k];
    const Eigen::Quaterniond& q = stage.state.world_from_body.orientation;
    add(forces, kStageShares[k],
        craft.terms(stage.state, stage.rate.velocity, water, stage.time_s, arm ? nullptr : &nearby));
    if (arm) forces.arm += kStageShares[k] * (*arm)[k];
    forces.applied += kStageShares[k] * (motion.applied.body + in_body_axes(motion.applied.world, q));
    forces.tether += kStageShares[k] * in_body_axes(motion.tether_world, q);
    Vector6d contact = motion.all.world - motion.applied.world - motion.tether_world;
    if (!canopy_world.isZero(0)) {
      contact -= canopy_world;
      forces.craft.drag += kStageShares[k] * in_body_axes(canopy_world, q);
    }
    forces.contact += kStageShares[k] * in_body_axes(contact, q);
  }
  part_wind(forces, motion);
  return forces;
}

}  // namespace

Vector6d Forces::sum() const {
  Vector6d sum = actuators + applied + tether + contact + dock;
  for (const Vector6d* part : {&arm, &wind}) {
    if (!part->isZero(0)) sum += *part;
  }
  for (const auto term : kTerms) sum += craft.*term;
  return sum;
}

Forces forces_on(const MovedBody& body, const Vector6d& canopy_world, const WaterField& water, double time_s,
                 double step_s) {
  if (body.held || body.motions.empty()) return at_instant(body, canopy_world, water, time_s, step_s);
  const Craft& craft = *body.spec.craft;
  Forces mean;
  for (const Motion& motion : body.motions) {
    const Forces part = motion.stops ? that_stop(craft, motion, water) : that_move(craft, motion, canopy_world, water);
    const double share = motion.step_s / step_s;
    add(mean, share, part.craft);
    mean.actuators += share * part.actuators;
    mean.applied += share * part.applied;
    mean.wind += share * part.wind;
    mean.tether += share * part.tether;
    mean.arm += share * part.arm;
    mean.contact += share * part.contact;
  }
  return mean;
}

}  // namespace uwsim
