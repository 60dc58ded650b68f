#include "uwsim/camera/particle_scattering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace uwsim {
namespace {

constexpr double kIndex = 1.1, kSlope = 3.5835;  // of the particles
constexpr double kPower = 0.5 * (3 - kSlope), kScale = 4 / (3 * (kIndex - 1) * (kIndex - 1));

/// The mean of Bessel's J0 from 0 to z, and 1 / z beyond the table, where it oscillates about that.
class MeanBessel {
 public:
  MeanBessel() {
    double before = 1;
    for (std::size_t k = 1; k < sums_.size(); ++k) {
      const double now = std::cyl_bessel_j(0.0, kStep * static_cast<double>(k));
      sums_[k] = sums_[k - 1] + 0.5 * kStep * (before + now);
      before = now;
    }
  }
  double operator()(double z) const {
    const double at = z / kStep;
    const auto below = static_cast<std::size_t>(std::min(at, 1e9));
    if (below + 1 >= sums_.size()) return 1 / z;
    if (z < kStep) return 1 - z * z / 12;
    return std::lerp(sums_[below], sums_[below + 1], at - static_cast<double>(below)) / z;
  }

 private:
  static constexpr double kStep = 0.05;
  std::array<double, 2001> sums_{};
};

/// kept_when_scattered at the nodes of a logarithmic scale.
class KeptTable {
 public:
  static constexpr double kFirst = 1e-3, kPerE = 6;
  static constexpr int kNodes = 111;  // to 9e4

  KeptTable() {
    const MeanBessel mean_bessel;
    constexpr double kPerAngle = 16, kLeast_rad = 1e-8;
    for (int node = 0; node < kNodes; ++node) {
      const double x = kFirst * std::exp(node / kPerE);
      double within = 0;
      for (int k = 0; within < 1; ++k) {  // rings of angle
        const double outer = std::min(kLeast_rad * std::exp(k / kPerAngle), std::numbers::pi);
        const double now = outer < std::numbers::pi ? scattered_within(outer) : 1;
        kept_[static_cast<std::size_t>(node)] += (now - within) * mean_bessel(x * outer * std::exp(-0.5 / kPerAngle));
        within = now;
      }
    }
  }
  double at(double x) const {
    const double place = std::clamp(kPerE * std::log(std::max(x, kFirst) / kFirst), 0.0, kNodes - 1.001);
    const auto below = static_cast<std::size_t>(place);
    return std::lerp(kept_[below], kept_[below + 1], place - static_cast<double>(below));
  }

 private:
  std::array<double, kNodes> kept_{};
};

}  // namespace

double scattered_within(double angle_rad) {
  const double half = std::sin(0.5 * angle_rad), u = half * half, d = kScale * u;
  if (d == 0) return 0;
  const double raised = std::pow(d, kPower), back = std::pow(kScale, kPower);
  const double sine = std::sin(angle_rad);
  const double forward = ((1 - d * raised) - u * (1 - raised)) / ((1 - d) * raised);
  return forward + (1 - back) / (8 * (kScale - 1) * back) * std::cos(angle_rad) * sine * sine;
}

double kept_when_scattered(double x) {
  static const KeptTable table;
  return table.at(x);
}

}  // namespace uwsim
