#include "uwsim/sonar/multibeam.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "uwsim/acoustics/sea_water.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kBottomStrength_db = -30;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

double echo_level_db(double range_m, double cos_incidence, double absorption_db_m) {
  const double spreading = 40 * std::log10(std::max(range_m, 0.01));
  return -spreading - 2 * absorption_db_m * range_m + kBottomStrength_db +
         20 * std::log10(std::max(cos_incidence, 1e-6));
}

}  // namespace

Multibeam::Multibeam(const MultibeamModel& model, const Pose& body_from_mount)
    : model_(model), body_from_mount_(body_from_mount) {
  for (int beam = 0; beam < model_.beams; ++beam) {
    directions_sonar_.emplace_back(std::cos(model_.angle_rad(beam)), std::sin(model_.angle_rad(beam)), 0);
  }
}

void Multibeam::aim(double elevation_rad) {
  require(std::abs(elevation_rad) <= std::numbers::pi / 2, "sonar.elevation_rad", elevation_rad,
          "must be in [-pi/2, pi/2] rad");
  elevation_rad_ = elevation_rad;
}

void Multibeam::exchange_state(StateArchive& archive) {
  double elevation_rad = elevation_rad_;
  archive(elevation_rad);
  aim(elevation_rad);
}

Pose Multibeam::body_from_sonar() const {
  // A turn about +y is nose down, so positive elevation turns the other way.
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-elevation_rad_, Eigen::Vector3d::UnitY()));
  return body_from_mount_ * Pose{Eigen::Vector3d::Zero(), tilt};
}

MultibeamPing Multibeam::ping(const RayScene& scene, const Water& water, const Pose& world_from_body) const {
  const Pose world_from_sonar = world_from_body * body_from_sonar();
  const Eigen::Matrix3d rotation = world_from_sonar.rotation();
  const std::size_t n = directions_sonar_.size();
  std::vector<Ray> rays(n);
  std::vector<RayHit> hits(n);
  for (std::size_t k = 0; k < n; ++k) rays[k] = {world_from_sonar.position_m, rotation * directions_sonar_[k]};
  scene.cast(rays, model_.range_max_m, hits);

  const double z = world_from_sonar.position_m.z();
  const double absorption_db_m = absorption_db_km(model_.frequency_hz, water.temperature_deg_c(z), water.salinity_psu,
                                                  std::max(0.0, Water::depth_m(z))) /
                                 1000;
  MultibeamPing ping{std::vector<float>(n, kInfinity), std::vector<float>(3 * n, kNone),
                     std::vector<float>(n, kNone),     std::vector<float>(n, -kInfinity),
                     std::vector<Label>(n, kNothing),  std::vector<std::uint8_t>(n, 0)};
  for (std::size_t k = 0; k < n; ++k) {
    const RayHit& hit = hits[k];
    const double hit_z = rays[k].origin_world_m.z() + hit.distance_m * rays[k].direction_world.z();
    const bool under_water = z <= 0 && hit_z <= 0;
    if (!under_water || !(hit.distance_m < model_.range_max_m)) continue;
    const double cosine = std::min(1.0, std::abs(hit.normal_world.cast<double>().dot(rays[k].direction_world)));
    ping.ranges_m[k] = static_cast<float>(hit.distance_m);
    for (int axis = 0; axis < 3; ++axis) {
      ping.points_sonar_m[3 * k + static_cast<std::size_t>(axis)] =
          static_cast<float>(hit.distance_m * directions_sonar_[k](axis));
    }
    ping.incidence_rad[k] = static_cast<float>(std::acos(cosine));
    ping.intensity_db[k] = static_cast<float>(echo_level_db(hit.distance_m, cosine, absorption_db_m));
    ping.labels[k] = hit.label;
    ping.valid[k] = 1;
  }
  return ping;
}

}  // namespace uwsim
