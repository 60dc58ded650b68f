#include "uwsim/acoustics/seabed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

using std::numbers::pi;

constexpr double kDegree = pi / 180;
constexpr double kLowest_rad = 0.001 * kDegree;  // the report's value for smaller grazing angles
constexpr double kKirchhoffFrom_rad = 40 * kDegree;

constexpr std::array kSeabeds = {
    Seabed{"rough_rock", 2.5, 2.5, 0.01374, 0.002, 0.20693},
    Seabed{"rock", 2.5, 2.5, 0.01374, 0.002, 0.01862},
    Seabed{"cobble", 2.5, 1.8, 0.01374, 0.002, 0.01600},
    Seabed{"sandy_gravel", 2.492, 1.3370, 0.01705, 0.002, 0.012937},
    Seabed{"very_coarse_sand", 2.401, 1.3067, 0.01667, 0.002, 0.010573},
    Seabed{"muddy_sandy_gravel", 2.314, 1.2778, 0.01630, 0.002, 0.008602},
    Seabed{"coarse_sand", 2.231, 1.2503, 0.01638, 0.002, 0.006957},
    Seabed{"gravelly_muddy_sand", 2.151, 1.2241, 0.01645, 0.002, 0.005587},
    Seabed{"medium_sand", 1.845, 1.1782, 0.01624, 0.002, 0.004446},
    Seabed{"muddy_gravel", 1.615, 1.1396, 0.01610, 0.002, 0.003498},
    Seabed{"fine_sand", 1.451, 1.1073, 0.01602, 0.002, 0.002715},
    Seabed{"muddy_sand", 1.339, 1.0800, 0.01728, 0.002, 0.002070},
    Seabed{"very_fine_sand", 1.268, 1.0568, 0.01875, 0.002, 0.001544},
    Seabed{"clayey_sand", 1.224, 1.0364, 0.02019, 0.002, 0.001119},
    Seabed{"coarse_silt", 1.195, 1.0179, 0.02158, 0.002, 0.000781},
    Seabed{"sandy_silt", 1.169, 0.9999, 0.01261, 0.002, 0.000518},
    Seabed{"medium_silt", 1.149, 0.9885, 0.00676, 0.001, 0.000518},
    Seabed{"sandy_mud", 1.149, 0.9873, 0.00386, 0.001, 0.000518},
    Seabed{"fine_silt", 1.148, 0.9861, 0.00306, 0.001, 0.000518},
    Seabed{"sandy_clay", 1.147, 0.9849, 0.00242, 0.001, 0.000518},
    Seabed{"very_fine_silt", 1.147, 0.9837, 0.00194, 0.001, 0.000518},
    Seabed{"silty_clay", 1.146, 0.9824, 0.00163, 0.001, 0.000518},
    Seabed{"clay", 1.145, 0.9800, 0.00148, 0.001, 0.000518},
};

double square(double x) { return x * x; }

/// A step from 1 to 0 as x rises through 0.
double logistic(double x) { return 1 / (1 + std::exp(std::clamp(x, -40.0, 40.0))); }

std::complex<double> wave_number_ratio(const Seabed& seabed) {
  return std::complex<double>(1, seabed.loss) / seabed.speed_ratio;
}

/// The vertical wave number in the sediment, relative to the wave number in water.
std::complex<double> vertical(const Seabed& seabed, double grazing_rad) {
  return std::sqrt(std::pow(wave_number_ratio(seabed), 2) - square(std::cos(grazing_rad)));
}

std::complex<double> reflection(const Seabed& seabed, double grazing_rad) {
  const std::complex<double> y = seabed.density_ratio * std::sin(grazing_rad) / vertical(seabed, grazing_rad);
  return (y - 1.0) / (y + 1.0);
}

/// Averages a cross-section over the large-scale slopes: Gauss-Hermite quadrature with three nodes. Beyond 0 and 90
/// degrees, the value there applies.
template <typename CrossSection>
double over_slopes(double grazing_rad, double slope_rad, const CrossSection& cross_section) {
  constexpr double kAside = 0.295410, kMiddle = 1.181636, kNode = 1.224745;
  const auto at = [&](double angle_rad) { return cross_section(std::clamp(angle_rad, 0.0, pi / 2)); };
  const double aside = at(grazing_rad - kNode * slope_rad) + at(grazing_rad + kNode * slope_rad);
  return (kMiddle * at(grazing_rad) + kAside * aside) / std::sqrt(pi);
}

}  // namespace

double Seabed::attenuation_db_wavelength() const { return 40 * pi * std::numbers::log10e * loss; }

std::span<const Seabed> seabeds() { return kSeabeds; }

const Seabed& seabed(std::string_view name) {
  const auto found = std::find_if(kSeabeds.begin(), kSeabeds.end(), [&](const Seabed& s) { return s.name == name; });
  if (found == kSeabeds.end()) {
    std::string names;
    for (const Seabed& known : kSeabeds) names += (names.empty() ? "" : ", ") + std::string(known.name);
    throw InvalidValue("seabed = '" + std::string(name) + "': must be one of " + names);
  }
  return *found;
}

SeabedBackscatter::SeabedBackscatter(const Seabed& seabed, double frequency_hz, double sound_speed_m_s)
    : seabed_(seabed) {
  require(frequency_hz >= kSeabedLowest_hz && frequency_hz <= kSeabedHighest_hz, "frequency_hz",
          with_unit(frequency_hz, "Hz"), "must be in [10000, 100000] Hz, for which the model is valid");
  require(sound_speed_m_s >= 1400 && sound_speed_m_s <= 1600, "sound_speed_m_s", with_unit(sound_speed_m_s, "m/s"),
          "must be in [1400, 1600] m/s, for which the model is valid");
  wave_number_1_cm_ = 2 * pi * frequency_hz / (100 * sound_speed_m_s);
  vertical_reflection_ = std::norm(reflection(seabed_, pi / 2));
  const double k = wave_number_1_cm_, w = seabed_.strength_cm4;
  alpha_ = seabed_.exponent / 2 - 1;
  const double structure = 2 * pi * w * std::tgamma(2 - alpha_) * std::pow(2, -2 * alpha_) /
                           (alpha_ * (1 - alpha_) * std::tgamma(1 + alpha_));
  q_ = structure * std::pow(2, 1 - 2 * alpha_) * std::pow(k, 2 * (1 - alpha_));
  a_ = std::pow(8 * square(alpha_) * std::tgamma(0.5 / alpha_ + 0.5) /
                    (std::tgamma(0.5) * std::tgamma(1 / alpha_) * std::tgamma(0.5 / alpha_)),
                2 * alpha_);
  b_ = std::pow(a_, 0.5 + 0.5 / alpha_) * std::tgamma(1 / alpha_) / (2 * alpha_);
  slope_ = std::sqrt(std::pow(2 * pi * w, 1 / alpha_) / (2 * (1 - alpha_)) *
                     std::pow(square(k) / alpha_, (1 - alpha_) / alpha_));
  const double fourth = std::pow(1000, 1 / (1 + alpha_)) * std::pow(a_ * square(q_), 1 / alpha_);
  kirchhoff_cosine_ = std::pow(1 / fourth + 4, -0.25);
}

double SeabedBackscatter::operator()(double grazing_rad) const {
  const double grazing = std::clamp(grazing_rad, kLowest_rad, pi / 2);
  const double shadow = shadowing(grazing);
  const auto averaged = [&](auto cross_section) {
    return shadow * over_slopes(grazing, slope_, [&](double angle) { return (this->*cross_section)(angle); });
  };
  const double near_vertical = logistic((std::cos(grazing) - kirchhoff_cosine_) / 0.0125);
  const double moderate =
      near_vertical * kirchhoff(grazing) + (1 - near_vertical) * averaged(&SeabedBackscatter::perturbation);
  const double smooth = logistic((std::atan(slope_) / kDegree - 7) / 0.5);
  const double interface = smooth * moderate + (1 - smooth) * large_roughness(grazing);
  return interface + averaged(&SeabedBackscatter::volume);
}

double SeabedBackscatter::kirchhoff(double grazing_rad) const {
  if (grazing_rad < kKirchhoffFrom_rad) return 0;
  const double wide = std::pow(std::cos(grazing_rad), 4 * alpha_) + a_ * square(q_ * square(std::sin(grazing_rad)));
  return b_ * q_ * vertical_reflection_ / (8 * pi * std::pow(wide, 0.5 + 0.5 / alpha_));
}

double SeabedBackscatter::perturbation(double grazing_rad) const {
  const double sine = std::sin(grazing_rad), cosine = std::cos(grazing_rad), rho = seabed_.density_ratio;
  const std::complex<double> kappa = wave_number_ratio(seabed_), p = vertical(seabed_, grazing_rad);
  const std::complex<double> below = rho * sine + p;
  const std::complex<double> y = (square((rho - 1) * cosine) + square(rho) - kappa * kappa) / (below * below);
  const double bragg = wave_number_1_cm_ * std::sqrt(4 * square(cosine) + 0.01);
  const double spectrum = seabed_.strength_cm4 * std::pow(bragg, -seabed_.exponent);
  return 4 * square(square(wave_number_1_cm_ * sine)) * std::norm(y) * spectrum;
}

double SeabedBackscatter::volume(double grazing_rad) const {
  const std::complex<double> p = vertical(seabed_, grazing_rad), r = reflection(seabed_, grazing_rad);
  if (!(std::abs(p.imag()) > 0)) return 0;
  return 5 * seabed_.loss * seabed_.volume * std::norm(1.0 - r * r) * square(std::sin(grazing_rad)) /
         (seabed_.speed_ratio * std::numbers::ln10 * std::norm(p) * p.imag());
}

double SeabedBackscatter::large_roughness(double grazing_rad) const {
  const double nu = seabed_.speed_ratio, degrees = grazing_rad / kDegree, slope_deg = slope_ / kDegree;
  const double critical_deg = nu >= 1.001 ? std::acos(1 / nu) / kDegree : 2.5613;
  const double beyond = 1 + 0.81 * square(critical_deg / degrees);
  const double facets = 0.04682 * std::pow(slope_, 1.25) * std::pow(nu, 3.25) *
                        square((1 - 2 / seabed_.density_ratio) / square(nu) + 1) /
                        (1 + 3.54 * slope_deg / critical_deg);
  const double upright = 1 + square(degrees - 90) / (2.6 * square(slope_deg));
  return facets * std::pow(std::sin(pi / beyond), 0.7263 / std::cbrt(slope_)) +
         0.0260 * vertical_reflection_ / (square(slope_) * std::pow(upright, 1.9) * beyond);
}

double SeabedBackscatter::shadowing(double grazing_rad) const {
  const double t = std::tan(grazing_rad) / slope_;
  if (t > 2) return 1;
  const double q = (std::exp(-t * t) / std::sqrt(pi) - t * std::erfc(t)) / (4 * t);
  return -std::expm1(-2 * q) / (2 * q);
}

}  // namespace uwsim
