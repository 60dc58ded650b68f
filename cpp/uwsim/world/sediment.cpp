#include "uwsim/world/sediment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kGravity_m_s2 = 9.80665;
constexpr double kWall = 0.22;     // lambda to which the measured distribution reaches
constexpr double kFarthest = 4.5;  // standard deviations from a cloud's middle, beyond which nothing of it is left

double measured_share(double lambda) {
  const double inner = std::exp(-114 * lambda * lambda);
  return lambda > 1e-6 ? 0.18 * (1 - inner) / lambda - 9.43 * lambda * inner : 0;
}

/// The share of the largest stress at r = lambda H.
double share_at(double lambda) {
  if (lambda <= kWall) return std::clamp(measured_share(lambda), 0.0, 1.0);
  return measured_share(kWall) * (kWall / lambda) * (kWall / lambda);
}

/// The concentration along a ray, as exp(-(a s^2 + 2 b s + c) / 2) of that in the middle.
struct Along {
  double a, b, c;
};
Along along(const SedimentCloud& cloud, const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) {
  const Eigen::Array3d sigma(cloud.across_m, cloud.across_m, cloud.up_m);
  const Eigen::Vector3d from = ((origin_m - cloud.middle_m).array() / sigma).matrix();
  const Eigen::Vector3d to = (direction.array() / sigma).matrix();
  return {to.squaredNorm(), from.dot(to), from.squaredNorm()};
}

}  // namespace

void Sediment::check() const {
  const std::string path = "ground.sediment.";
  require(critical_pa >= 1e-3 && critical_pa <= 100, path + "critical_pa", critical_pa, "must be in [0.001, 100] Pa");
  require(rate_kg_m2_s > 0 && rate_kg_m2_s <= 1, path + "rate_kg_m2_s", rate_kg_m2_s, "must be in (0, 1] kg/(m2 s)");
  require(grain_m >= 1e-6 && grain_m <= 2e-3, path + "grain_m", grain_m, "must be in [0.000001, 0.002] m");
  require(mixing_m2_s >= 1e-6 && mixing_m2_s <= 1, path + "mixing_m2_s", mixing_m2_s, "must be in [0.000001, 1] m2/s");
  require(grain_kg_m3 > water_kg_m3 && water_kg_m3 > 0, path + "grain_kg_m3", grain_kg_m3, "must exceed the water's");
  require(viscosity_m2_s > 0, path + "viscosity_m2_s", viscosity_m2_s, "must be positive");
}

double Sediment::erosion_kg_m2_s(double stress_pa) const {
  return rate_kg_m2_s * std::max(0.0, stress_pa / critical_pa - 1);
}

double Sediment::settling_m_s() const {
  const double cubed =
      std::pow(grain_m, 3) * kGravity_m_s2 * (grain_kg_m3 / water_kg_m3 - 1) / (viscosity_m2_s * viscosity_m2_s);
  return viscosity_m2_s / grain_m * (std::sqrt(10.36 * 10.36 + 1.049 * cubed) - 10.36);
}

double Sediment::backscatter_m2_kg(double wave_number_rad_m) const {
  const double radius_m = grain_m / 2, x = wave_number_rad_m * radius_m;
  const auto hump = [x](double at, double width) { return std::exp(-std::pow((x - at) / width, 2)); };
  const double form = x * x * (1 - 0.35 * hump(1.5, 0.7)) * (1 + 0.5 * hump(1.8, 2.2)) / (1 + 0.9 * x * x);
  return 3 * form * form / (16 * std::numbers::pi * grain_kg_m3 * radius_m);
}

void SedimentCloud::advance(const Sediment& sediment, double time_s) {
  const double spread = 2 * sediment.mixing_m2_s * time_s, before_m = up_m;
  across_m = std::sqrt(across_m * across_m + spread);
  up_m = std::sqrt(up_m * up_m + spread);
  mass_kg *=
      std::exp(-sediment.settling_m_s() * std::sqrt(2 / std::numbers::pi) * (up_m - before_m) / sediment.mixing_m2_s);
}

void SedimentCloud::add(const SedimentCloud& other) {
  const double mass = mass_kg + other.mass_kg;
  const double share = mass > 0 ? other.mass_kg / mass : 0.5;
  const Eigen::Vector3d apart_m = other.middle_m - middle_m;
  const double between = share * (1 - share) * apart_m.head<2>().squaredNorm() / 2;  // along each of two axes
  middle_m += share * apart_m;
  across_m = std::sqrt((1 - share) * across_m * across_m + share * other.across_m * other.across_m + between);
  up_m = std::sqrt((1 - share) * up_m * up_m + share * other.up_m * other.up_m);
  mass_kg = mass;
}

double SedimentCloud::column_kg_m2(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                   double length_m) const {
  const auto [a, b, c] = along(*this, origin_m, direction);
  const double nearest = c - b * b / a;
  if (nearest > kFarthest * kFarthest) return 0;
  const double root = std::sqrt(a / 2);
  const double share = std::erf(root * (length_m + b / a)) - std::erf(root * (b / a));
  const double densest = 2 * mass_kg / (std::pow(2 * std::numbers::pi, 1.5) * across_m * across_m * up_m);
  return densest * std::exp(-nearest / 2) * std::sqrt(std::numbers::pi / (2 * a)) * share;
}

SedimentCloud::Passage SedimentCloud::passage(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const {
  const auto [a, b, c] = along(*this, origin_m, direction);
  return {std::max(0.0, -b / a), 1 / std::sqrt(a)};
}

double ImpingingJet::stress_pa(double radius_m) const { return largest_pa() * share_at(radius_m / distance_m); }

double ImpingingJet::radius_m(double stress_pa) const {
  const double share = stress_pa / largest_pa();
  if (share >= 1) return 0;
  const double wall = share_at(kWall);
  if (share <= wall) return distance_m * kWall * std::sqrt(wall / share);
  double inner = 0.14, outer = kWall;  // the stress falls between them
  for (int k = 0; k < 40; ++k) {
    const double middle = (inner + outer) / 2;
    (share_at(middle) > share ? inner : outer) = middle;
  }
  return distance_m * inner;
}

double ImpingingJet::erosion_kg_s(const Sediment& sediment) const {
  const double radius = radius_m(sediment.critical_pa);
  constexpr int kRings = 64;
  const double width = radius / kRings;
  double sum = 0;
  for (int k = 0; k < kRings; ++k) {
    const double r = (k + 0.5) * width;
    sum += sediment.erosion_kg_m2_s(stress_pa(r)) * r;
  }
  return 2 * std::numbers::pi * width * sum;
}

}  // namespace uwsim
