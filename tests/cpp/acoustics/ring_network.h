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

/// The sum of all nodes' counts.
inline TopicCounts sum_of(const PacketNetwork& network, std::uint64_t topic) {
  TopicCounts all;
  for (std::size_t node = 0; node < network.nodes(); ++node) {
    const TopicCounts& one = network.counts(topic, node);
    all.given += one.given;
    all.sent += one.sent;
    all.delivered += one.delivered;
    all.resent += one.resent;
    for (std::size_t k = 0; k < kLossKinds; ++k) all.lost[k] += one.lost[k];
    all.delay_s += one.delay_s;
  }
  return all;
}

struct Network {
  PacketNetwork network;
  Ring medium;
  std::uint64_t now_ns = 0;

  explicit Network(const ModemSpec& modem, std::size_t nodes = 2, std::vector<LinkFault> faults = {})
      : network(modem, nodes, std::move(faults), 7, kStep_ns) {}

  void step() {
    network.transmit(now_ns, medium);
    now_ns += kStep_ns;
    network.receive(now_ns);
  }
  void run(double seconds) {
    for (auto k = std::llround(seconds * 1e9 / kStep_ns); k > 0; --k) step();
  }
  TopicCounts sum(std::uint64_t topic) const { return sum_of(network, topic); }
};

/// A network under random load: every node except node 0 sends messages of 60 bytes to node 0 as a Poisson process, at
/// most one in a step. All packets are received at the same level, and some are lost at random.
struct RandomLoad {
  ModemSpec modem;
  double loss = 0, delay_s = 0.1, step_s = 0.005;

  TopicCounts counts(std::size_t nodes, double rate_1_s, double seconds) const {
    const auto step_ns = static_cast<std::uint64_t>(std::llround(1e9 * step_s));
    PacketNetwork network(modem, nodes, {{0, 1e9, loss}}, 3, step_ns);
    Ring medium;
    medium.delay_s = delay_s;
    const RandomStream arrivals(3, "load/arrivals");
    const std::uint64_t topic = network.topic("load");
    std::uint64_t now_ns = 0;
    for (std::uint64_t tick = 0; now_ns < static_cast<std::uint64_t>(1e9 * seconds); ++tick) {
      for (std::size_t node = 1; node < nodes; ++node) {
        if (arrivals.uniform(tick, static_cast<std::uint32_t>(node)) >= rate_1_s * step_s) continue;
        network.send(node, message(0, topic, std::string(60, 'x')), now_ns);
      }
      network.transmit(now_ns, medium);
      now_ns += step_ns;
      network.receive(now_ns);
    }
    return sum_of(network, topic);
  }
};

}  // namespace uwsim
