#include "uwsim/sim/stirring.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kPeriod_s = 0.5;
constexpr std::size_t kMostClouds = 256;
constexpr double kSteepest = 0.5;     // cosine between a jet and the bed's normal
constexpr double kCore = 8.3;         // diameters from which a jet follows the law
constexpr double kWallJet = 0.087;    // half height of a wall jet per distance from its middle
constexpr double kThinnest_m = 0.02;  // of a cloud
constexpr double kInvisible = 1e-3;   // optical depth of a cloud from above
constexpr double kOverlap = 0.5;      // standard deviations within which a new cloud joins an old one

/// Optical depth in the middle, from above.
double thickness(const SedimentCloud& cloud, const Sediment& sediment) {
  return cloud.mass_kg * sediment.extinction_m2_kg() / (2 * std::numbers::pi * cloud.across_m * cloud.across_m);
}

}  // namespace

void Stirring::advance(std::span<const Vehicle> vehicles, const RigidBodyWorld& bodies, const World& world,
                       const RayScene& scene, std::uint64_t tick, double step_s) {
  const auto ticks = static_cast<std::uint64_t>(std::max(1.0, std::round(kPeriod_s / step_s)));
  if (tick % ticks != 0) return;
  const double period_s = static_cast<double>(ticks) * step_s, time_s = static_cast<double>(tick) * step_s;
  for (SedimentCloud& cloud : clouds_.all) {
    const Eigen::Vector3d above = cloud.middle_m + Eigen::Vector3d(0, 0, cloud.up_m);
    cloud.middle_m.head<2>() += period_s * world.water.flow_at(above, time_s).velocity_m_s.head<2>();
    if (const Heightfield* const terrain = scene.terrain()) {
      const double bed_m = terrain->height_at(cloud.middle_m.x(), cloud.middle_m.y());
      if (std::isfinite(bed_m)) cloud.middle_m.z() = bed_m;
    }
    cloud.advance(clouds_.sediment, period_s);
  }
  std::erase_if(clouds_.all, [&](const SedimentCloud& each) { return thickness(each, clouds_.sediment) < kInvisible; });
  for (const Vehicle& vehicle : vehicles) {
    if (!vehicle.released()) continue;
    const Pose& pose = bodies.state(vehicle.body).world_from_body;
    for (const Thruster& thruster : vehicle.actuators.thrusters()) lift(thruster, pose, scene, period_s);
  }
}

void Stirring::lift(const Thruster& thruster, const Pose& world_from_body, const RayScene& scene, double period_s) {
  const ThrusterParameters& parameters = thruster.parameters();
  const double thrust_n = thruster.thrust_n();
  if (parameters.is_vertical) return;
  const Sediment& sediment = clouds_.sediment;
  const ImpingingJet near{std::abs(thrust_n), 1};
  const double farthest_m = std::sqrt(near.largest_pa() / sediment.critical_pa);
  const double nearest_m = kCore * parameters.diameter_m;
  if (farthest_m <= nearest_m) return;
  const Eigen::Vector3d hub = world_from_body.point(parameters.position_body_m);
  if (hub.z() > 0) return;
  const Eigen::Vector3d jet = world_from_body.direction(parameters.axis_body) * (thrust_n > 0 ? -1 : 1);
  const RayHit bed = scene.cast(Ray{hub, jet}, farthest_m);
  if (!std::isfinite(bed.distance_m) || bed.label != kTerrain) return;
  const double straight = -jet.dot(bed.normal_world.cast<double>());
  if (straight < kSteepest) return;
  const ImpingingJet at_bed{std::abs(thrust_n) * straight, std::max(bed.distance_m, nearest_m)};
  SedimentCloud fresh;
  fresh.middle_m = hub + bed.distance_m * jet;
  fresh.mass_kg = period_s * at_bed.erosion_kg_s(sediment);
  const double radius_m = at_bed.radius_m(sediment.critical_pa);
  fresh.across_m = std::max(kThinnest_m, radius_m / 2);
  fresh.up_m = std::max(kThinnest_m, kWallJet * radius_m);
  if (fresh.mass_kg > 0) join(fresh);
}

void Stirring::join(const SedimentCloud& fresh) {
  for (SedimentCloud& cloud : clouds_.all) {
    const double apart_m = (cloud.middle_m - fresh.middle_m).head<2>().norm();
    if (apart_m < kOverlap * std::min(cloud.across_m, 2 * fresh.across_m)) return cloud.add(fresh);
  }
  if (clouds_.all.size() == kMostClouds) {
    clouds_.all.erase(std::min_element(clouds_.all.begin(), clouds_.all.end(), [&](const auto& a, const auto& b) {
      return thickness(a, clouds_.sediment) < thickness(b, clouds_.sediment);
    }));
  }
  clouds_.all.push_back(fresh);
}

void Stirring::exchange_state(StateArchive& archive) {
  archive.list(clouds_.all, [&](SedimentCloud& cloud) {
    for (double* const each : {&cloud.middle_m.x(), &cloud.middle_m.y(), &cloud.middle_m.z(), &cloud.across_m,
                               &cloud.up_m, &cloud.mass_kg}) {
      archive(*each);
    }
    require(cloud.across_m > 0 && cloud.up_m > 0 && cloud.mass_kg >= 0, "state.sediment", cloud.mass_kg,
            "must have a size and a mass");
  });
}

}  // namespace uwsim
