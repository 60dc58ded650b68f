#pragma once

#include <cstdint>

#include "uwsim/acoustics/modem/packet_error.h"

namespace uwsim {

/// A cable has a fixed latency; an ideal link only the sound's travel time; a modem everything.
enum class LinkKind { kCable, kIdeal, kModem };

/// Who may send when. ALOHA: whoever has a packet, after a random wait. TDMA: each node in its turn.
enum class MediumAccess { kAloha, kTdma };

/// The figures of a modem. Levels in dB re 1 uPa (at 1 m).
struct ModemSpec {
  LinkKind kind = LinkKind::kModem;
  double bit_rate_bit_s = 1000;     ///< of the packet's bits, header included; 0: no time at all
  double preamble_s = 0;            ///< before the bits of each packet
  std::uint64_t packet_bytes = 64;  ///< payload of a packet, at most
  std::uint64_t header_bytes = 4;   ///< of each packet
  double latency_s = 0;             ///< of a cable

  double frequency_hz = 25e3;  ///< the band's centre
  double bandwidth_hz = 4e3;
  double source_level_db = 185;
  double receiver_noise_db_hz = 0;  ///< the vehicle's and the electronics' own, density
  Modulation modulation = Modulation::kFsk;
  bool fading = false;
  double coding_gain_db = 0;
  double multipath_window_s =
      0.01;                  ///< echoes within it after the first arrival add to the signal, later ones to noise
  double speed_max_m_s = 5;  ///< of the ends towards each other: Doppler that the receiver still tracks

  MediumAccess access = MediumAccess::kTdma;
  double slot_s = 1;     ///< TDMA: time to send in a slot; a guard time follows
  double guard_s = 1;    ///< TDMA: travel time over the range that the slots are made for
  double backoff_s = 0;  ///< ALOHA: the longest wait before a packet, drawn evenly

  std::uint64_t queue_bytes = 4096;  ///< payload that may wait at a node

  bool takes_turns() const { return kind == LinkKind::kModem && access == MediumAccess::kTdma; }
  /// Duration of a packet of so many bytes of payload [s].
  double packet_s(std::uint64_t bytes) const {
    return preamble_s + (bit_rate_bit_s > 0 ? 8 * static_cast<double>(bytes + header_bytes) / bit_rate_bit_s : 0);
  }
  /// Throws InvalidValue that names modem.<field>.
  void check() const;
};

}  // namespace uwsim
