#include "uwsim/dynamics/moved_body.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "uwsim/core/check.h"
#include "uwsim/core/symmetric.h"

namespace uwsim {

void BodySpec::check() const {
  require(craft != nullptr, "vehicle '" + name + "' craft", "none", "must be set");
  require(arm.empty() || !path || path->stands(), "object '" + name + "' links", arm.size(),
          "must be left out for a body that moves along a path");
  if (round) round->check();
  require(!round || shape == CollisionShape::kHull, "round", "given", "must be left out for boxes and pieces");
  require(friction >= 0 && friction <= 10, "vehicle.friction", friction, "must be in [0, 10]");
  require(restitution >= 0 && restitution <= 1, "vehicle.restitution", restitution, "must be in [0, 1]");
}

double pair_friction(const BodySpec& a, const BodySpec& b) { return std::sqrt(a.friction * b.friction); }

double pair_friction(const BodySpec& a, const ArmLink* link_a, const BodySpec& b, const ArmLink* link_b) {
  const auto of = [](const BodySpec& body, const ArmLink* link) {
    return link != nullptr && link->friction ? *link->friction : body.friction;
  };
  return std::sqrt(of(a, link_a) * of(b, link_b));
}

double pair_restitution(const BodySpec& a, const BodySpec& b) { return std::max(a.restitution, b.restitution); }

/// Skips applied loads of zero, so that zeros keep their signs.
Loads MovedBody::loads(const Vector6d& impulse_world, double step_s) const {
  Loads all{.body = tau_body, .world = impulse_world / step_s};
  if (!applied.body.isZero(0)) all.body += applied.body;
  if (!applied.world.isZero(0)) all.world += applied.world;
  if (!tether_world.isZero(0)) all.world += tether_world;
  if (!canopy_world.isZero(0)) all.world += canopy_world;
  return all;
}

BodyState MovedBody::advanced(const BodyState& from, const Loads& all, const WaterField& water, double time_s,
                              double step_s) {
  if (!arm) return advance(*spec.craft, from, all, water, time_s, step_s);
  return arm->advance(CraftBase(*spec.craft, all, water), from, water, time_s, step_s);
}

Matrix6d MovedBody::inverse_mass(const Pose& world_from_body, const WaterField& water, double time_s) const {
  const Craft& hull = *spec.craft;
  if (!arm) return hull.inverse_mass(world_from_body, water, time_s);
  return inverse_of_positive(base_mass(world_from_body, water, time_s) + arm->folded_inertia());
}

Matrix6d MovedBody::base_mass(const Pose& world_from_body, const WaterField& water, double time_s) const {
  const Craft& hull = *spec.craft;
  return hull.rigid_mass() + hull.submerged_fraction(world_from_body, water, time_s) * hull.parameters().added_mass;
}

void MovedBody::record_stages() {
  if (arm) motions.back().arm_body = arm->stage_wrenches();
}

void MovedBody::forget_step() {
  motions.clear();
  touches.clear();
}

void MovedBody::require_plausible(const BodyState& next, double time_s, double step_s) const {
  const bool plausible = next.velocity_body.cwiseAbs().maxCoeff() < kDiverged &&
                         next.world_from_body.position_m.cwiseAbs().maxCoeff() < kDiverged &&
                         next.world_from_body.orientation.coeffs().allFinite();  // false for NaN as well
  if (!plausible) {
    std::ostringstream last;
    last << "[" << state.world_from_body.position_m.transpose() << " m; " << state.velocity_body.transpose()
         << " m/s, rad/s]";
    std::ostringstream path;
    path << "vehicle '" << spec.name << "', step " << std::llround(time_s / step_s) << ": last finite state";
    require(false, path.str(), last.str(),
            "the motion diverged: use a smaller step_s or check the vehicle's coefficients");
  }
  if (arm) arm->require_plausible("vehicle", spec.name);
}

}  // namespace uwsim
