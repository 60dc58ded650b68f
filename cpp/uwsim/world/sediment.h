#pragma once

#include <Eigen/Core>
#include <vector>

namespace uwsim {

/// A bed's loose sediment: grains of one size that water can lift.
struct Sediment {
  double critical_pa = 0.1;    ///< shear stress above which the bed erodes
  double rate_kg_m2_s = 1e-4;  ///< eroded at twice that stress
  double grain_m = 10e-6;      ///< diameter
  double mixing_m2_s = 1e-3;   ///< diffusivity of the water above the bed
  double grain_kg_m3 = 2650;   ///< of quartz
  double water_kg_m3 = 1000;
  double viscosity_m2_s = 1e-6;  ///< kinematic, of fresh water at 20 C

  /// Throws InvalidValue naming ground.sediment.<field>.
  void check() const;

  /// Mass that leaves a bed in a second under this shear stress [kg/(m^2 s)]: rate (tau / critical - 1) (Partheniades
  /// 1965, "Erosion and deposition of cohesive soils", J. Hydraul. Div. 91:105, as cited; for muds).
  double erosion_kg_m2_s(double stress_pa) const;
  /// Speed at which a grain sinks (Soulsby 1997, "Dynamics of Marine Sands", eq. 102): nu / d (sqrt(10.36^2 + 1.049
  /// D*^3) - 10.36), D* = d (g (s - 1) / nu^2)^(1/3).
  double settling_m_s() const;
  /// Attenuation of light by 1 kg in the water: 3 / (rho d), the extinction of spheres much larger than the wavelength,
  /// twice their section (van de Hulst 1957, "Light Scattering by Small Particles", sec. 8.2) [m^2].
  double extinction_m2_kg() const { return 3 / (grain_kg_m3 * grain_m); }
  /// Backscattering section of 1 kg: 3 f^2 / (16 pi rho a), with the form function f of sand by Thorne and Meral 2008,
  /// "Formulations for the scattering properties of suspended sandy sediments", Cont. Shelf Res. 28:309, eq. 6a, for k
  /// a from 0.01 to 100, of grains of one size [m^2/kg].
  double backscatter_m2_kg(double wave_number_rad_m) const;
};

/// Sediment in the water: a Gaussian cloud over the bed, as wide along x as along y, whose lower half is mirrored by
/// the bed, in which its middle lies.
struct SedimentCloud {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  double across_m = 0, up_m = 0;  ///< standard deviations
  double mass_kg = 0;

  /// Advances it: it spreads with sigma^2 growing by 2 K t and settles at its concentration at the bed times the
  /// grains' speed, which leaves exp(-w sqrt(2 / pi) (sigma(t) - sigma(0)) / K) of it. Drift is the caller's.
  void advance(const Sediment& sediment, double time_s);
  /// Adds another cloud: mass, centre and second moments across are those of both.
  void add(const SedimentCloud& other);
  /// Sediment along a ray up to `length_m`, in closed form [kg/m^2]. `direction`: unit.
  double column_kg_m2(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double length_m) const;
  /// Where along a ray it is densest, not behind the origin, and its standard deviation along the ray [m].
  struct Passage {
    double densest_m, deviation_m;
  };
  Passage passage(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const;
};

/// The clouds at one time.
struct SedimentClouds {
  Sediment sediment;
  std::vector<SedimentCloud> all;
};

/// The shear stress that a jet straight at a bed exerts (Beltaos and Rajaratnam 1974, "Impinging circular turbulent
/// jets", J. Hydraul. Div. 100:1313, as in ASTM D5852): at most 0.16 rho U^2 (d / H)^2, which is 0.204 T / H^2 for the
/// thrust T = rho U^2 pi d^2 / 4; at a distance r = lambda H from its middle
///
///   tau / max = 0.18 (1 - exp(-114 lambda^2)) / lambda - 9.43 lambda exp(-114 lambda^2)   to lambda = 0.22,
///
/// and falling with r^-2 beyond (assumed). Valid for H > 8.3 d.
struct ImpingingJet {
  double thrust_n = 0;
  double distance_m = 1;  ///< H, of the nozzle from the bed along the jet

  double largest_pa() const { return 0.16 * 4 / 3.14159265358979324 * thrust_n / (distance_m * distance_m); }
  double stress_pa(double radius_m) const;
  /// The radius within which the stress is above this one; 0 if it is nowhere.
  double radius_m(double stress_pa) const;
  /// Mass that it lifts in a second [kg/s].
  double erosion_kg_s(const Sediment& sediment) const;
};

}  // namespace uwsim
