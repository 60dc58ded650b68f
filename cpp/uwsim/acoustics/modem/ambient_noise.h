#pragma once

namespace uwsim {

/// Sources of noise in the sea.
struct NoiseSources {
  double wind_m_s = 0;    ///< 0 to 40
  double shipping = 0.5;  ///< activity, 0 to 1
};

/// Ambient noise in the sea [dB re 1 uPa^2/Hz] due to turbulence, distant shipping, wind and thermal noise: Wenz's
/// (1962) curves as fitted by Coates (1990, "Underwater Acoustic Systems") and printed by Stojanovic (2007, ACM MC2R
/// 11:34). The coefficients are those of the network simulator ns-3 (uan-noise-model-default.cc). Valid from 10 Hz to
/// 1 MHz.
double ambient_noise_db_hz(double frequency_hz, const NoiseSources& sources);

}  // namespace uwsim
