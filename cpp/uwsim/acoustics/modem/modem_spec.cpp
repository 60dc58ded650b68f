#include "uwsim/acoustics/modem/modem_spec.h"

#include <string>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {

void ModemSpec::check() const {
  const auto within = [](const char* name, double value, double low, double high, const char* unit) {
    require(value >= low && value <= high, std::string("modem.") + name, with_unit(value, unit),
            "must be in [" + std::to_string(low) + ", " + std::to_string(high) + "] " + unit);
  };
  within("bit_rate_bit_s", bit_rate_bit_s, kind == LinkKind::kModem ? 1 : 0, 1e10, "bit/s");
  within("preamble_s", preamble_s, 0, 60, "s");
  within("packet_bytes", static_cast<double>(packet_bytes), 1, 1e6, "bytes");
  within("header_bytes", static_cast<double>(header_bytes), 0, 1e4, "bytes");
  within("latency_s", latency_s, 0, 60, "s");
  within("queue_bytes", static_cast<double>(queue_bytes), 1, 1e9, "bytes");
  if (kind != LinkKind::kModem) {
    require(retransmissions == 0, "modem.retransmissions", retransmissions, "must be 0 unless the link has modems");
    return;
  }
  within("retransmissions", static_cast<double>(retransmissions), 0, 100, "");
  within("acknowledgement_bytes", static_cast<double>(acknowledgement_bytes), 0, static_cast<double>(packet_bytes),
         "bytes");
  within("guard_s", guard_s, 0, 600, "s");
  within("frequency_hz", frequency_hz, 100, 1e6, "Hz");
  within("bandwidth_hz", bandwidth_hz, 1, 2 * frequency_hz, "Hz");
  within("source_level_db", source_level_db, 50, 250, "dB");
  within("receiver_noise_db_hz", receiver_noise_db_hz, -100, 200, "dB");
  within("coding_gain_db", coding_gain_db, 0, 60, "dB");
  within("multipath_window_s", multipath_window_s, 0, 10, "s");
  within("symbol_s", symbol_s, 0, 10, "s");
  within("speed_max_m_s", speed_max_m_s, 0, 100, "m/s");
  within("backoff_s", backoff_s, 0, 600, "s");
  if (access != MediumAccess::kTdma) return;
  require(slot_s >= packet_s(packet_bytes), "modem.slot_s", with_unit(slot_s, "s"),
          "must hold a full packet, " + std::to_string(packet_s(packet_bytes)) + " s");
}

}  // namespace uwsim
