/// A packet network whose nodes are at equal distances, and the modems of its tests.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/acoustics/modem/packet_network.h"

namespace uwsim {

inline constexpr std::uint64_t kStep_ns = 5000000;

/// Nodes at equal distances: every packet arrives with the same level.
class Ring final : public LinkMedium {
 public:
  double delay_s = 0.1, signal_db = 130, noise_db = 76, closing_m_s = 0;
  Reception receive(std::size_t, std::size_t) const override {
    return {true, delay_s, signal_db, noise_db, closing_m_s, 0, 0};
  }
  std::array<double, 2> interference(std::size_t, std::size_t) const override { return {delay_s, signal_db}; }
};

inline ModemSpec aloha() {
  ModemSpec modem;
  modem.access = MediumAccess::kAloha;
  modem.bit_rate_bit_s = 1000;
  modem.packet_bytes = 60;
  modem.header_bytes = 4;  // 0.512 s per packet
  modem.queue_bytes = 1000000;
  return modem;
}

inline ModemSpec tdma() {
  ModemSpec modem = aloha();
  modem.access = MediumAccess::kTdma;
  modem.slot_s = 0.6;
  modem.guard_s = 0.15;
  return modem;
}

inline LinkMessage message(std::uint64_t to, std::uint64_t topic, const std::string& payload) {
  LinkMessage made;
  made.to = to;
  made.topic = topic;
  made.payload = payload;
  return made;
}

struct Network {
  PacketNetwork network;
  Ring medium;
  std::uint64_t now_ns = 0;

  explicit Network(const ModemSpec& modem, std::size_t nodes = 2, std::vector<LinkFault> faults = {},
                   std::vector<std::uint64_t> relays = {})
      : network(modem, nodes, std::move(faults), 7, kStep_ns, std::move(relays)) {}

  void step() {
    network.transmit(now_ns, medium);
    now_ns += kStep_ns;
    network.receive(now_ns);
  }
  void run(double seconds) {
    for (auto k = std::llround(seconds * 1e9 / kStep_ns); k > 0; --k) step();
  }
  TopicCounts sum(std::uint64_t topic) const {
    TopicCounts all;
    for (std::size_t node = 0; node < network.nodes(); ++node) {
      const TopicCounts& one = network.counts(topic, node);
      all.given += one.given;
      all.sent += one.sent;
      all.delivered += one.delivered;
      for (std::size_t k = 0; k < kLossKinds; ++k) all.lost[k] += one.lost[k];
    }
    return all;
  }
};

}  // namespace uwsim
