#pragma once

#include <cstdint>

#include "uwsim/acoustics/modem/packet_error.h"

namespace uwsim {

/// A cable has only a fixed latency, and an ideal link has only the sound's travel time. For a modem, all effects are
/// modelled.
enum class LinkKind { kCable, kIdeal, kModem };

/// Medium access. ALOHA: a node sends when it has a packet, after a random wait. TDMA: each node sends in its own slot.
enum class MediumAccess { kAloha, kTdma };

/// The parameters of a modem. Levels in dB re 1 uPa (at 1 m).
struct ModemSpec {
  LinkKind kind = LinkKind::kModem;
  double bit_rate_bit_s = 1000;     ///< for all bits of a packet, including the header; 0: packets take no time
  double preamble_s = 0;            ///< precedes the bits of each packet
  std::uint64_t packet_bytes = 64;  ///< largest payload of a packet
  std::uint64_t header_bytes = 4;   ///< header of each packet
  double latency_s = 0;             ///< latency of a cable

  double frequency_hz = 25e3;  ///< centre of the band
  double bandwidth_hz = 4e3;
  double source_level_db = 185;
  double receiver_noise_db_hz = 0;  ///< spectral density of self-noise and electronic noise
  Modulation modulation = Modulation::kFsk;
  bool fading = false;
  double coding_gain_db = 0;
  /// The guard time: echoes that follow the first arrival within this time add to the signal. Later echoes interfere
  /// increasingly with the next symbol; after another symbol_s, they are only noise (reception.h).
  double multipath_window_s = 0.01;
  double symbol_s = 0;
  double speed_max_m_s = 5;  ///< largest closing speed at which the receiver can track the Doppler shift

  MediumAccess access = MediumAccess::kTdma;
  double slot_s = 1;  ///< TDMA: time to send in a slot; a guard time follows
  /// Travel time over the largest range for which the network is designed. It follows each TDMA slot; twice this time
  /// is allowed for an acknowledgement's round trip.
  double guard_s = 1;
  double backoff_s = 0;  ///< ALOHA: maximum of the uniformly distributed wait before a packet

  std::uint64_t queue_bytes = 4096;  ///< largest total payload that may be queued at a node

  /// Number of times that a message is sent again while it is not acknowledged; 0: no acknowledgements are sent.
  std::uint64_t retransmissions = 0;
  std::uint64_t acknowledgement_bytes = 0;  ///< payload of an acknowledgement

  bool takes_turns() const { return kind == LinkKind::kModem && access == MediumAccess::kTdma; }
  /// Duration of a packet with this many bytes of payload [s].
  double packet_s(std::uint64_t bytes) const {
    return preamble_s + (bit_rate_bit_s > 0 ? 8 * static_cast<double>(bytes + header_bytes) / bit_rate_bit_s : 0);
  }
  /// Throws InvalidValue naming modem.<field>.
  void check() const;
};

}  // namespace uwsim
