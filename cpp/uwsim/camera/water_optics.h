#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/camera/refraction.h"

namespace uwsim {

/// A value for each of the camera's three bands: red, green and blue, at 600, 550 and 450 nm. These wavelengths are
/// assumed: they are near the peaks of common sensors' colour filters, and the tables below have columns for them. Each
/// band is treated as a single wavelength, so its attenuation does not change with distance (Akkaynak and Treibitz 2018
/// discuss the limits).
using Bands = Eigen::Array3d;

/// The optical properties of water [1/m].
struct WaterOptics {
  Bands diffuse_attenuation;  ///< Kd, of downwelling irradiance with depth
  Bands absorption;           ///< a
  Bands scattering;           ///< b
  double refractive_index = kWaterIndex;

  /// c = a + b, the attenuation of light between scene and camera.
  Bands beam_attenuation() const { return absorption + scattering; }
  /// Throws InvalidValue naming the field.
  void check() const;
};

/// The water of a Jerlov type: I, IA, IB, II, III, 1C, 3C, 5C, 7C or 9C. Throws InvalidValue. Kd: Jerlov 1976, "Marine
/// Optics", table XXVII. a and b: types II to 5C as measured, Williamson and Hollins 2022, "Measured IOPs of Jerlov
/// water types", Appl. Opt. 61:9951; types I, IA, 7C and 9C, which that paper omits, by inversion of Kd, Solonenko and
/// Mobley 2015, "Inherent optical properties of Jerlov water types", Appl. Opt. 54:5392. IB also uses the inversion:
/// its measured absorption of blue, 0.0407 1/m, exceeds Jerlov's Kd, 0.036, and Kd is never less than a (light that
/// descends by a metre has travelled at least a metre). All 90 values are those of the tables in the Python package
/// jerlov 0.22 (Ishibashi), which documents its checks; the papers themselves were not consulted. Kd of I to III is
/// within 8 % of Austin and Petzold 1986 (Opt. Eng. 25:471, in the same package); for 1C, 15 % less at 550 nm and 22 %
/// more at 450 nm. Valid for the open sea and coasts, which Jerlov classified; for a lake, choose the most similar
/// type.
WaterOptics jerlov_water(std::string_view type);
const std::vector<std::string>& jerlov_types();

/// Irradiance reflectance of deep water, R = 0.33 bb / a (Morel and Prieur 1977, "Analysis of variations in ocean
/// color", Limnol. Oceanogr. 22:709), limited to 0.3; the atmospheric code 6S has the same 0.33 (subroutine
/// morcasiwat), and Sathyendranath and Platt 1997 (Appl. Opt. 36:2620) give about 0.33, which varies with the sun's
/// height. bb is 0.5 of molecular scattering, which is symmetric, and 0.018 of particle scattering. Petzold's 1972
/// measurements (SIO Ref. 72-78, in the package jerlov 0.22) give 0.017 to 0.019 for the particles of a harbour, but
/// 0.008 to 0.016 on coasts and in the ocean, where this is too bright. The molecular part is the b of type I, since
/// that water is nearly pure (assumed).
Bands upwelling_share(const WaterOptics& water);
Bands molecular_scattering();

}  // namespace uwsim
