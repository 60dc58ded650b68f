#include "uwsim/vehicle/radiation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/symmetric.h"

namespace uwsim {
namespace {

constexpr double kUpright = 0.86602540378443864676, kCapsized = 0.5;  // cosines of 30 and 60 degrees
constexpr int kChecked = 300;                                         // frequencies at which passivity is checked
constexpr double kBeyond = 30;                                        // so many times beyond the resonators'
constexpr double kDry = 0.5;                                          // of the floating volume

double eased(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

void Radiation::check() const {
  require(added_mass.allFinite() && added_mass.isApprox(added_mass.transpose(), 1e-9), "vehicle.radiation.added_mass",
          "asymmetric", "must be finite and symmetric");
  const double low = eigenvalues(added_mass)(0);
  require(low >= -1e-9 * added_mass.cwiseAbs().maxCoeff(), "vehicle.radiation.added_mass", low,
          "must be positive semi-definite (smallest eigenvalue shown)");
  check_sections();
  require(least_rad_s > 0 && most_rad_s > least_rad_s, "vehicle.radiation.most_rad_s", most_rad_s,
          "must be above the lowest frequency, which must be positive");
  require(frequencies >= 2 && headings >= 4 && diffraction.size() == kDivisions * frequencies * headings,
          "vehicle.radiation.diffraction", diffraction.size(),
          "must have a value for each division, frequency and heading");
  require(std::ranges::all_of(diffraction, [](const Force& force) { return force.allFinite(); }),
          "vehicle.radiation.diffraction", "non-finite", "must be finite");
  require(drift.empty() || drift.size() == diffraction.size(), "vehicle.radiation.drift", drift.size(),
          "must have a value for each one of diffraction, or none");
  require(std::ranges::all_of(drift, [](const Drift& force) { return force.allFinite(); }), "vehicle.radiation.drift",
          "non-finite", "must be finite");
  require(wet_volume_m3 > 0, "vehicle.radiation.wet_volume_m3", wet_volume_m3, "must be positive");
}

void Radiation::check_sections() const {
  Matrix6d steady = Matrix6d::Zero();
  double least = 1e9, most = 0, size = 0;
  for (const Section& section : sections) {
    require(section.by_speed.allFinite() && section.by_place.allFinite(), "vehicle.radiation.sections", "non-finite",
            "must be finite");
    require(section.omega_rad_s > 0 && section.omega_rad_s < 1000, "vehicle.radiation.sections.omega_rad_s",
            section.omega_rad_s, "must be in (0, 1000) rad/s");
    require(section.damping_ratio > 0 && section.damping_ratio <= 10, "vehicle.radiation.sections.damping_ratio",
            section.damping_ratio, "must be in (0, 10]: otherwise it is unstable");
    const double stiffness = section.omega_rad_s * section.omega_rad_s;
    steady += section.by_place / stiffness;
    size = std::max(size, section.by_place.cwiseAbs().maxCoeff() / stiffness);
    least = std::min(least, section.omega_rad_s);
    most = std::max(most, section.omega_rad_s);
  }
  require(steady.cwiseAbs().maxCoeff() <= 1e-6 * size, "vehicle.radiation.sections", steady.cwiseAbs().maxCoeff(),
          "must have no force of a steady velocity");
  double damping = 0, low = 0;
  for (int k = 0; k <= kChecked && !sections.empty(); ++k) {
    const double omega =
        least / kBeyond * std::pow(kBeyond * kBeyond * most / least, static_cast<double>(k) / kChecked);
    const Vector6d values = eigenvalues(Matrix6d(impedance({0, omega}).real()));
    low = std::min(low, values(0));
    damping = std::max(damping, values(5));
  }
  require(low >= -1e-9 * damping, "vehicle.radiation.sections", low, "must be passive: damping must only take energy");
}

Eigen::Matrix<std::complex<double>, 6, 6> Radiation::impedance(std::complex<double> s) const {
  Eigen::Matrix<std::complex<double>, 6, 6> sum = Eigen::Matrix<std::complex<double>, 6, 6>::Zero();
  for (const auto& [by_speed, by_place, omega, damping] : sections) {
    const std::complex<double> gain = 1.0 / (s * s + 2 * damping * omega * s + omega * omega);
    sum += (gain * s) * by_speed.cast<std::complex<double>>() + gain * by_place.cast<std::complex<double>>();
  }
  return sum;
}

template <class Value>
Value Radiation::between(const std::vector<Value>& values, std::size_t division, double omega_rad_s,
                         double heading_rad) const {
  const double omega = std::clamp(omega_rad_s, least_rad_s, most_rad_s);
  const double beyond = omega_rad_s < omega ? omega_rad_s / omega : omega / omega_rad_s;
  const double row = (omega - least_rad_s) / (most_rad_s - least_rad_s) * static_cast<double>(frequencies - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(row), frequencies - 2);
  const double turns = heading_rad / (2 * std::numbers::pi);
  const double column = (turns - std::floor(turns)) * static_cast<double>(headings);
  const std::size_t left = static_cast<std::size_t>(column) % headings, right = (left + 1) % headings;
  const double up = row - static_cast<double>(low), across = column - std::floor(column);
  const Value* const at = values.data() + (division * frequencies + low) * headings;
  const Value below = (1 - across) * at[left] + across * at[right];
  const Value above = (1 - across) * at[headings + left] + across * at[headings + right];
  return beyond * beyond * ((1 - up) * below + up * above);
}

Radiation::Force Radiation::diffraction_at(std::size_t division, double omega_rad_s, double heading_rad) const {
  return between(diffraction, division, omega_rad_s, heading_rad);
}

Radiation::Drift Radiation::drift_at(std::size_t division, double omega_rad_s, double heading_rad) const {
  return between(drift, division, omega_rad_s, heading_rad);
}

double Radiation::share(double submerged_volume_m3, double up, double cover) const {
  const double wet = std::clamp(submerged_volume_m3 / (kDry * wet_volume_m3), 0.0, 1.0);
  return wet * eased((up - kCapsized) / (kUpright - kCapsized)) * (1 - eased(cover / 0.5));
}

}  // namespace uwsim
