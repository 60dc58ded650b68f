#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "uwsim/world/waves.h"

// The part of Waves that integrates over volumes.
namespace uwsim {
namespace {

// Depth, in units of 1 / k, below which less than 1e-3 of a wave's motion remains.
constexpr double kDepthOfEffect = 7;
constexpr double kSliceTurn_rad = 2;  // change of phase over a slice

}  // namespace

std::size_t Waves::division_of(const VolumeParts& parts, double centre_z_m) const {
  const double cover_m = std::max(-centre_z_m - parts.length_m / 2, kDepthOfEffect / resolved_rad_m_);
  double turn = kDepthOfEffect / cover_m * parts.length_m;
  std::size_t division = 0;
  for (; turn > kSliceTurn_rad && division + 1 < parts.slices.size(); turn /= 2) ++division;
  return division;
}

/// Each wave is eta exp(kappa . r) with kappa = (i k_x, i k_y, +-k). The integral of its gradient over a slice is kappa
/// V (1 + x + x^2 / 3), and that of the gradient's moment about the centroid (C kappa) x kappa (1 + 0.65 x), where C is
/// the slice's second moment and x = kappa^T C kappa / (2 V). The terms of lowest order hold for any symmetric shape;
/// the next ones have factors of 0.3 and 0.6 for a box along the wave, 5/14 and 5/7 for an ellipsoid. The convective
/// part is assumed uniform over the volume.
void Waves::add_flow_over(const PlacedVolume& volume, double time_s, VolumeFlow& flow) const {
  const Eigen::Vector3d& middle = volume.centroid_world_m;
  const Eigen::Matrix3d& rotation = volume.world_from_body;
  const VolumeParts& parts = volume.parts;
  const std::size_t division = division_of(parts, middle.z());
  Crests crests;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), turning = velocity, rate = velocity, turning_rate = velocity;
  WaveMotionSums motion{};  // at the middle
  Stretched middle_at{};
  for (const VolumePart& part : parts.slices[division]) {
    const Eigen::Vector3d arm = rotation * (part.centroid_m - parts.whole().centroid_m), at = middle + arm;
    const std::size_t count = count_reaching(at.z());
    if (count == 0) continue;
    const double height = crests_at(at.x(), at.y(), time_s, count, crests);
    const Stretched level = stretched(at.z(), height);
    WavesOnVolume on{level.z_m, 1, part.volume_m3, {}};
    Eigen::Map<Eigen::Matrix3d>(&on.second_m5[0][0]) = rotation * part.second_moment_m5 * rotation.transpose();
    WaveIntegrals sums;
    if (division == 0) {
      wave_sum_kernels().over_with_motion(blocks_.data(), count, crests.data(), on, sums, motion);
      middle_at = level;
    } else {
      wave_sum_kernels().over(blocks_.data(), count, crests.data(), on, sums);
    }
    const Eigen::Map<const Eigen::Vector3d> part_velocity(sums.velocity), part_rate(sums.rate);
    velocity += part_velocity;
    rate += part_rate;
    turning += Eigen::Map<const Eigen::Vector3d>(sums.turning) + arm.cross(part_velocity);
    turning_rate += Eigen::Map<const Eigen::Vector3d>(sums.turning_rate) + arm.cross(part_rate);
  }
  if (const std::size_t count = count_reaching(middle.z()); division > 0 && count > 0) {
    middle_at = stretched(middle.z(), crests_at(middle.x(), middle.y(), time_s, count, crests));
    wave_sum_kernels().motion(blocks_.data(), count, crests.data(), middle_at.z_m, motion);
  }
  const double by_volume = gravity_m_s2_ / parts.whole().volume_m3;
  const auto turned = [&](const Eigen::Vector3d& momentum) -> Eigen::Vector3d {
    return gravity_m_s2_ * (rotation * (parts.inverse_inertia_1_m5 * (rotation.transpose() * momentum)));
  };
  const Eigen::Vector3d convective_m_s2 = convective(motion, middle_at, flow.velocity_m_s);
  flow.velocity_m_s += by_volume * velocity;
  flow.angular_velocity_rad_s += turned(turning);
  flow.wave_acceleration_m_s2 += by_volume * rate + convective_m_s2;
  flow.wave_angular_acceleration_rad_s2 += turned(turning_rate);
}

/// Stretching makes grad h depend on the surface: where it slopes, so do the levels at which linear theory is
/// evaluated; where it is high, these levels are farther apart.
VolumeLoad Waves::load_on(const VolumePart& wet, const WaterSurface& surface, double time_s) const {
  const Eigen::Vector3d& at = wet.centroid_m;
  // Half the height of a box with the same second moment.
  const double half_m = std::sqrt(std::max(0.0, 3 * wet.second_moment_m5(2, 2) / wet.volume_m3));
  const std::size_t count = count_reaching(at.z() + half_m);
  if (count == 0) return {};
  Crests crests;
  const double height = crests_at(at.x(), at.y(), time_s, count, crests);
  const double top_m = std::min(at.z() + half_m, height), bottom_m = std::min(at.z() - half_m, height);
  const Stretched top = stretched(top_m, height), bottom = stretched(bottom_m, height);
  const double stretch = top_m > bottom_m ? (top.z_m - bottom.z_m) / (top_m - bottom_m) : bottom.by_point;
  WavesOnVolume on{std::min(0.0, bottom.z_m + stretch * half_m), stretch, wet.volume_m3, {}};
  Eigen::Map<Eigen::Matrix3d>(&on.second_m5[0][0]) = wet.second_moment_m5;
  WaveIntegrals sums;
  wave_sum_kernels().load(blocks_.data(), count, crests.data(), on, sums);
  const Eigen::Map<const Eigen::Vector3d> rate(sums.rate), turning_rate(sums.turning_rate);
  VolumeLoad load{gravity_m_s2_ * rate, gravity_m_s2_ * turning_rate};
  if (!(top.z_m > bottom.z_m)) return load;
  const Eigen::Vector2d slope(surface.slope_x, surface.slope_y);
  load.force_m4_s2.head<2>() += 0.5 * (top.by_surface + bottom.by_surface) / stretch * load.force_m4_s2.z() * slope;
  const Eigen::Vector2d rises = wet.second_moment_m5.topLeftCorner<2, 2>() * slope / wet.volume_m3;
  const double spreads = gravity_m_s2_ * (top.by_surface - bottom.by_surface) / (top.z_m - bottom.z_m);
  load.force_m4_s2.z() += spreads * rises.dot(Eigen::Map<const Eigen::Vector2d>(sums.rise_gradient));
  load.moment_m5_s2.x() += spreads * rate.z() * rises.y();
  load.moment_m5_s2.y() -= spreads * rate.z() * rises.x();
  return load;
}

}  // namespace uwsim
