#include "uwsim/sonar/beam_footprint.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

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
    : rays_(rays), directions_(3, fan.beams * rays), axes_(3, fan.beams) {
  const std::vector<Eigen::Vector2d> spread = offsets(rays);
  const double mean_square = 0.5 * (width_across_rad * width_across_rad + width_along_rad * width_along_rad);
  spacing_rad_ = kDeviation * std::sqrt(2 * std::numbers::pi * mean_square / rays);
  for (int beam = 0; beam < fan.beams; ++beam) {
    axes_.col(beam) = direction(fan.angles().at(beam), 0);
    for (int k = 0; k < rays; ++k) {
      const Eigen::Vector2d& offset = spread[static_cast<std::size_t>(k)];
      directions_.col(beam * rays + k) = direction(fan.angles().at(beam) + kDeviation * width_across_rad * offset.x(),
                                                   kDeviation * width_along_rad * offset.y());
    }
  }
}

}  // namespace uwsim
