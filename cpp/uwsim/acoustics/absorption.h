#pragma once

namespace uwsim {

/// Absorption [dB/km] (Francois and Garrison 1982, J. Acoust. Soc. Am. 72:1879) by boric acid, magnesium sulphate and
/// pure water. Valid for 0.2..1000 kHz, -2..22 deg C, 30..35 psu (and fresh water, where only the last term remains).
/// Throws InvalidValue unless the frequency is in (0, 1e7] Hz, the temperature in [-2, 40] deg C, the salinity in [0,
/// 45] psu, the depth in [0, 12000] m and the pH in [6, 9].
double absorption_db_km(double frequency_hz, double temperature_deg_c, double salinity_psu, double depth_m,
                        double acidity_ph = 8.0);

}  // namespace uwsim
