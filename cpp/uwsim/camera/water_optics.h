#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace uwsim {

/// A value for each of the camera's three bands: red, green, blue, at 600, 550 and 450 nm. Assumed: where the colour
/// filters of common sensors are near their peaks, and a column of the tables below. A band is taken as one wavelength,
/// so that within a band attenuation does not change with distance (Akkaynak and Treibitz 2018 say how far that holds).
using Bands = Eigen::Array3d;

/// How a water treats light, all [1/m].
struct WaterOptics {
  Bands diffuse_attenuation;  ///< Kd, of downwelling irradiance with depth
  Bands absorption;           ///< a
  Bands scattering;           ///< b
  double refractive_index = 1.333;

  /// c = a + b: what a beam loses, and so what the camera's path loses.
  Bands beam_attenuation() const { return absorption + scattering; }
  /// Throws InvalidValue that names the field.
  void check() const;
};

/// The water of a Jerlov type: I, IA, IB, II, III, 1C, 3C, 5C, 7C or 9C. Throws InvalidValue.
/// Kd: Jerlov 1976, "Marine Optics", table XXVII. a and b: types IB to 5C as measured, Williamson and Hollins 2022,
/// "Measured IOPs of Jerlov water types", Appl. Opt. 61:9951; types I, IA, 7C and 9C, which they leave out, by
/// inversion of Kd, Solonenko and Mobley 2015, "Inherent optical properties of Jerlov water types", Appl. Opt. 54:5392.
/// All read from the tables of the Python package jerlov 0.22 (Ishibashi), which says how it checked them; the papers
/// themselves were not read. Valid for what Jerlov classed: the open sea and coasts; a lake takes the type that is
/// alike.
WaterOptics jerlov_water(std::string_view type);
const std::vector<std::string>& jerlov_types();

/// Irradiance reflectance of deep water, R = 0.33 bb / a (Morel and Prieur 1977, "Analysis of variations in ocean
/// color", Limnol. Oceanogr. 22:709), at most 0.3; bb is 0.5 of molecular and 0.018 of particle scattering (the mean of
/// Petzold's 1972 measurements as commonly quoted). Type I's b is taken for the molecular part: its water is all but
/// pure. From memory of these papers: assumed.
Bands upwelling_share(const WaterOptics& water);
Bands molecular_scattering();

}  // namespace uwsim
