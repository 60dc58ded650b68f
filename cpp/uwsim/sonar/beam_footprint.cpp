#include "uwsim/sonar/beam_footprint.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "uwsim/acoustics/sonar_equation.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

/// The standard deviation of a Gaussian as a fraction of its full width at half maximum.
const double kDeviation = 1 / (2 * std::sqrt(2 * std::numbers::ln2));

Eigen::Vector3f direction(double angle_rad, double up_rad) {
  return Eigen::Vector3d(std::cos(up_rad) * std::cos(angle_rad), std::cos(up_rad) * std::sin(angle_rad),
                         std::sin(up_rad))
      .cast<float>();
}

}  // namespace

std::vector<Eigen::Vector2d> BeamFootprint::offsets(int rays) {
  require(rays == 1 || (rays >= 4 && rays <= 64), "sonar.rays_per_beam", rays, "must be 1 or in [4, 64]");
  if (rays == 1) return {Eigen::Vector2d::Zero()};
  const double golden_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  Eigen::Matrix2Xd points(2, rays);
  for (int k = 0; k < rays; ++k) {
    const double radius = std::sqrt(-2 * std::log(1 - (k + 0.5) / rays));
    points.col(k) = radius * Eigen::Vector2d(std::cos(golden_rad * k), std::sin(golden_rad * k));
  }
  points.colwise() -= points.rowwise().mean().eval();
  const Eigen::Matrix2d covariance = points * points.transpose() / rays;
  points = covariance.llt().matrixL().solve(points).eval();
  std::vector<Eigen::Vector2d> out;
  for (int k = 0; k < rays; ++k) out.emplace_back(points.col(k));
  return out;
}

BeamFootprint::BeamFootprint(const MultibeamModel& fan, double width_across_rad, double width_along_rad, int rays)
    : rays_(rays), offsets_(offsets(rays)), directions_(3, fan.beams * rays), axes_(3, fan.beams) {
  for (int beam = 0; beam < fan.beams; ++beam) {
    const double angle_rad = fan.angles().at(beam), widening = steered_widening(fan.steering_rad(beam));
    const double across_rad = width_across_rad * widening;
    const double mean_square = 0.5 * (across_rad * across_rad + width_along_rad * width_along_rad);
    const double spacing_rad = kDeviation * std::sqrt(2 * std::numbers::pi * mean_square / rays);
    spacing_rad_.push_back(rays > 1 ? static_cast<float>(spacing_rad) : 0);
    widening_.push_back(static_cast<float>(widening));
    root_widening_.push_back(static_cast<float>(std::sqrt(widening)));
    axes_.col(beam) = direction(angle_rad, 0);
    for (int k = 0; k < rays; ++k) {
      const Eigen::Vector2d& offset = offsets_[static_cast<std::size_t>(k)];
      directions_.col(beam * rays + k) =
          direction(angle_rad + kDeviation * across_rad * offset.x(), kDeviation * width_along_rad * offset.y());
    }
  }
}

BeamRays BeamFootprint::beam(std::size_t beam) const {
  const auto column = static_cast<Eigen::Index>(beam), rays = static_cast<Eigen::Index>(rays_);
  return {offsets_, directions_.middleCols(column * rays, rays), axes_.col(column)};
}

}  // namespace uwsim
