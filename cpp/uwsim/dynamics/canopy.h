#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/core/water_field.h"
#include "uwsim/dynamics/broad_phase.h"
#include "uwsim/vehicle/hydrodynamics.h"
#include "uwsim/world/cover_plan.h"

namespace uwsim {

/// The plants of a world's cover, as a drag on hulls that move through them (Nepf 1999, Water Resour. Res. 35(2):479):
/// per volume
///
///   f = -1/2 rho C_d a |u_r| u_r
///
/// where u_r is the velocity relative to the water, in which the plants stand still, C_d the layer's drag coefficient
/// and a [1/m] the plants' frontal area per volume. a(z) follows from the layer: its density, where it grows, times the
/// part of a mean plant's frontal area per height, CoverPlan::frontal_area_below. The hull counts as the cuboid that
/// has its volume, centroid and second moments, in eight parts.
///
/// Valid for plants that are many and thin beside the hull. The paper's C_d falls as stands become denser; here, it is
/// the layer's. Plants neither bend, which would lower the drag, nor entangle, nor slow the current. The force is that
/// of the step's start, limited so that it stops no part of the hull by more than half within a step.
class Canopy {
 public:
  /// Keeps references to both, which are those of this world.
  Canopy(const World& world, const CoverPlan& plan, const BroadPhase& broad_phase);

  /// True if a layer of the world consists of plants.
  static bool grows_in(const World& world);
  /// The wrench on a hull about its body's origin, world axes [N, N m].
  Vector6d drag_world(const Craft& craft, const BodyState& state, const WaterField& water, double time_s,
                      double step_s) const;

 private:
  double area_m2(const Eigen::Vector3d& middle_m, double half_height_m, double volume_m3) const;

  std::shared_ptr<const Heightfield> terrain_;
  std::vector<std::shared_ptr<const CoverLayer>> layers_;
  const CoverPlan& plan_;
  const BroadPhase& broad_phase_;
  double tallest_m_ = 0;
};

}  // namespace uwsim
