#pragma once

namespace uwsim {

/// Density of sea water at atmospheric pressure [kg/m^3]: the one-atmosphere equation of state of sea water EOS-80
/// (Millero and Poisson 1981; Fofonoff and Millard 1983, UNESCO technical papers in marine science 44). Valid for
/// -2..40 deg C and 0..42 psu, within 0.004 kg/m^3; used up to 45 psu. ITS-90 temperatures are used in place of the
/// equation's IPTS-68, from which they differ by 0.024 %. This and the functions below throw InvalidValue unless the
/// temperature is in [-2, 40] deg C, the salinity in [0, 45] psu and the pressure in [0, 2e8] Pa.
double sea_water_density_kg_m3(double temperature_deg_c, double salinity_psu);

/// Secant bulk modulus K of sea water [Pa] at a pressure above atmospheric (EOS-80: Millero, Chen, Bradshaw and
/// Schleicher 1980; UNESCO 44). Compression raises the density from rho_0 to rho_0 / (1 - p / K). Valid for 0..1000
/// bar.
double sea_water_bulk_modulus_pa(double temperature_deg_c, double salinity_psu, double gauge_pressure_pa);

/// Density at a pressure above atmospheric [kg/m^3]: rho_0 / (1 - p / K).
double sea_water_density_kg_m3(double temperature_deg_c, double salinity_psu, double gauge_pressure_pa);

/// Gauge pressure [Pa] at the foot of a column of water that is compressed by its own weight, computed from the
/// pressure without compression: the solution p of p - p^2 / (2 K) = p_0, with K taken at two thirds of p. If K is
/// linear in p, this is exact to first order in p / K. Temperature and salinity are taken at two thirds of the depth,
/// where the additional weight due to compression is centred.
double compressed_pressure_pa(double uncompressed_pa, double temperature_deg_c, double salinity_psu);

}  // namespace uwsim
