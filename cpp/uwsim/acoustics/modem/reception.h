#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/modem/ambient_noise.h"
#include "uwsim/acoustics/modem/boundary_loss.h"
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

/// Sound that arrives at the receiver along one ray.
struct HeardPath {
  double time_s;
  double level_db;     ///< re 1 uPa
  double closing_m_s;  ///< closing speed of the ends along the ray, which sets its Doppler shift
};

/// A bed that departs from a flat bottom by more than this fraction of its depth is uneven.
inline constexpr double kUnevenBed = 0.05;

/// How a packet reaches a receiver.
struct Reception {
  bool reached = false;     ///< whether any sound arrives
  double delay_s = 0;       ///< until the first arrival within 20 dB of the strongest
  double signal_db = -300;  ///< re 1 uPa, all arrivals, as far as they help to detect a symbol
  double noise_db = -300;   ///< within the band, including interference between symbols
  double closing_m_s = 0;   ///< closing speed of the ends along the strongest arrival
  double spread_s = 0;      ///< from the first to the last arrival within 20 dB of the strongest
  /// The departure of the bed between the ends from the flat bottom that was assumed, as a fraction of its depth; 0 if
  /// no significant arrival has bounced off the bottom.
  double bed_departure = 0;

  double snr_db() const { return signal_db - noise_db; }
};

/// Transmission loss along a straight path at one depth [dB]: spherical spreading and absorption (Urick 1983, ch. 2).
double spherical_loss_db(const ModemWater& water, double length_m, double depth_m);

/// The share of an arrival's power that helps to detect a symbol, at a delay after the first arrival: 1 within the
/// guard time, then ((guard + symbol - delay) / symbol)^2, the squared overlap of the delayed symbol with the
/// receiver's integration over one symbol, and 0 after one more symbol. The rest interferes with the next symbols
/// (planning of broadcast networks: Brugger and Hemingway 2003, "OFDM receivers - impact on coverage of inter-symbol
/// interference and FFT window positioning", EBU Technical Review 295, not consulted; the shares of random OFDM symbols
/// of 1,024 carriers, simulated with numpy, are within 0.002 of it). It holds for receivers that integrate over a
/// symbol after a guard time: OFDM with a guard interval, and tones or chirps whose frequencies are reused only after
/// the guard time. An equaliser is modelled as a longer guard time.
double symbol_share(const ModemSpec& modem, double delay_s);

/// Adds arrivals incoherently, for a receiver that synchronises with the first arrival within 20 dB of the strongest.
/// Weaker arrivals are ignored. Those whose own closing speed exceeds speed_max_m_s are noise.
Reception reception(const ModemSpec& modem, const ModemWater& water, std::span<const HeardPath> paths);

/// The probability that a packet received in this way is lost. `interference_db` is the level of other packets within
/// the band.
double packet_loss(const ModemSpec& modem, const Reception& heard, double interference_db, std::uint64_t bytes);

}  // namespace uwsim
