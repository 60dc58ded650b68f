#pragma once

namespace uwsim {

/// Speed of sound [m/s] (Mackenzie 1981, J. Acoust. Soc. Am. 70:807). Valid for 2..30 deg C, 25..40 psu, 0..8000 m;
/// within about 1 m/s of Del Grosso there. It is also used below 25 psu, where its error grows to a few m/s.
double sound_speed_m_s(double temperature_deg_c, double salinity_psu, double depth_m);

/// Absorption [dB/km] (Francois and Garrison 1982, J. Acoust. Soc. Am. 72:1879): boric acid, magnesium sulphate, pure
/// water. Valid for 0.2..1000 kHz, -2..22 deg C, 30..35 psu (and fresh water, where only the last term remains).
double absorption_db_km(double frequency_hz, double temperature_deg_c, double salinity_psu, double depth_m,
                        double acidity_ph = 8.0);

}  // namespace uwsim
