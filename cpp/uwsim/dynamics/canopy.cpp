#include "uwsim/dynamics/canopy.h"
#include "uwsim/core/symmetric.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace uwsim {
namespace {

constexpr double kMostStopped = 0.5;  // the share of a part's motion that a step may take

}  // namespace

Canopy::Canopy(const World& world, const CoverPlan& plan, const BroadPhase& broad_phase)
    : terrain_(world.terrain()), layers_(world.cover()), plan_(plan), broad_phase_(broad_phase) {
  for (std::size_t k = 0; k < layers_.size(); ++k) tallest_m_ = std::max(tallest_m_, plan.tallest_m(k));
}

bool Canopy::grows_in(const World& world) {
  return std::ranges::any_of(world.cover(), [](const auto& layer) { return layer->drag_coefficient > 0; });
}

/// C_d a V of a part of the hull, whose volume is spread evenly over its height.
double Canopy::area_m2(const Eigen::Vector3d& middle_m, double half_height_m, double volume_m3) const {
  const double over_bed_m = middle_m.z() - terrain_->height_at(middle_m.x(), middle_m.y());
  if (!(over_bed_m - half_height_m < tallest_m_)) return 0;  // not either beside the terrain, where this is NaN
  double area_m2 = 0;
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    if (over_bed_m - half_height_m >= plan_.tallest_m(k)) continue;
    const double frontal_m2 = plan_.frontal_area_below(k, over_bed_m + half_height_m) -
                              plan_.frontal_area_below(k, over_bed_m - half_height_m);
    if (frontal_m2 <= 0) continue;
    area_m2 += layers_[k]->drag_coefficient * plan_.density_at(k, middle_m.head<2>()) * frontal_m2 /
               (2 * half_height_m) * volume_m3;
  }
  return area_m2;
}

Vector6d Canopy::drag_world(const Craft& craft, const BodyState& state, const WaterField& water, double time_s,
                            double step_s) const {
  Vector6d drag = Vector6d::Zero();
  const SolidProperties& solid = craft.hull().solid();
  const Eigen::Matrix3d& inertia = solid.inertia_per_density_m5;
  const Eigen::Vector3d middle = state.world_from_body.point(solid.centroid_m);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(std::sqrt(1.5 * inertia.trace() / solid.volume_m3));
  const Eigen::Vector3d down(0, 0, tallest_m_);
  if (!middle.allFinite() || !broad_phase_.may_touch(middle - reach - down, middle + reach)) return drag;

  const Eigen::Matrix3d second = 0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia;
  const Modes<3> axes = principal_axes(second / solid.volume_m3);
  const Eigen::Matrix3d rotation = state.world_from_body.rotation();
  const Eigen::Matrix3d half_m = rotation * axes.vectors * (3 * axes.values).cwiseMax(0).cwiseSqrt().asDiagonal();
  // A part is half as large: its half height has the variance of the part's.
  const double half_height_m = std::max(0.5 * half_m.row(2).norm(), 1e-6);

  struct Part {
    Eigen::Vector3d arm_m, force_n;  // from the body's origin
    double rate = 0;                 // force per speed [N s/m]
  };
  std::array<Part, 8> parts;
  const Eigen::Vector3d spin = rotation * state.angular_body_rad_s(), origin = state.world_from_body.position_m;
  const Eigen::Vector3d velocity = rotation * state.linear_body_m_s();
  const CraftParameters& p = craft.parameters();
  const Eigen::Vector3d centre = rotation * p.centre_of_mass_body_m;
  const double least_inertia = eigenvalues(p.inertia_kg_m2)(0);
  double stops_1_s = 0;
  for (unsigned k = 0; k < parts.size(); ++k) {
    const Eigen::Vector3d side(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5);
    const Eigen::Vector3d at = middle + half_m * side;
    const double area = area_m2(at, half_height_m, solid.volume_m3 / static_cast<double>(parts.size()));
    if (area == 0) continue;
    Part& part = parts[k];
    part.arm_m = at - origin;
    const Eigen::Vector3d relative = velocity + spin.cross(part.arm_m) - water.flow_at(at, time_s).velocity_m_s;
    part.rate = 0.5 * water.density_at(at.z()) * area * relative.norm();
    part.force_n = -part.rate * relative;
    stops_1_s += part.rate * (1 / p.mass_kg + (part.arm_m - centre).squaredNorm() / least_inertia);
  }
  if (stops_1_s == 0) return drag;
  const double share = std::min(1.0, kMostStopped / (stops_1_s * step_s));
  for (const Part& part : parts) {
    if (part.rate == 0) continue;
    drag.head<3>() += share * part.force_n;
    drag.tail<3>() += part.arm_m.cross(share * part.force_n);
  }
  return drag;
}

}  // namespace uwsim
