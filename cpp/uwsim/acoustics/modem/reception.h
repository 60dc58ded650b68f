#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/modem/ambient_noise.h"
#include "uwsim/acoustics/modem/boundary_loss.h"
#include "uwsim/acoustics/modem/eigenrays.h"
#include "uwsim/acoustics/modem/modem_spec.h"
#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// The acoustic properties of the water around a modem.
struct ModemWater {
  SoundSpeedProfile profile;
  AbsorptionColumn absorption;  ///< at the modem's frequency
  FluidBottom bottom;
  double surface_rms_m = 0;  ///< rms height of the waves
  double noise_db_hz = 40;   ///< ambient noise
};

/// A ray that reaches the receiver.
struct HeardPath {
  Eigenray ray;
  double level_db;  ///< re 1 uPa
};

/// How a packet reaches a receiver.
struct Reception {
  bool reached = false;     ///< whether any sound arrives
  double delay_s = 0;       ///< until the first arrival
  double signal_db = -300;  ///< re 1 uPa, arrivals within the modem's window
  double noise_db = -300;   ///< within the band, including later echoes
  double closing_m_s = 0;   ///< closing speed of the ends along the first arrival
  double spread_s = 0;      ///< from the first to the last arrival within 20 dB of the strongest

  double snr_db() const { return signal_db - noise_db; }
};

/// Transmission loss along a ray [dB]: spherical spreading by its length, absorption, and the loss at each reflection.
/// One-way sonar equation (Urick 1983, ch. 2): level = SL - TL.
double path_loss_db(const ModemSpec& modem, const ModemWater& water, const Eigenray& ray, double from_depth_m,
                    double to_depth_m);

/// Adds arrivals incoherently: those within the window after the first are signal, later ones are noise.
Reception reception(const ModemSpec& modem, const ModemWater& water, std::span<const HeardPath> paths);

/// The probability that a packet received in this way is lost. `interference_db` is the level of other packets within
/// the band.
double packet_loss(const ModemSpec& modem, const Reception& heard, double interference_db, std::uint64_t bytes);

}  // namespace uwsim
