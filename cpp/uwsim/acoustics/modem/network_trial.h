#pragma once

#include <cstdint>
#include <vector>

#include "uwsim/acoustics/modem/packet_network.h"

namespace uwsim {

/// A network under random load, for comparing its throughput with theory. Every node except node 0 sends single-packet
/// messages to node 0 as a Poisson process. All packets are received at the same level, and some are lost at random.
struct NetworkTrial {
  ModemSpec modem;
  std::size_t nodes = 2;
  double rate_1_s = 1;  ///< rate of each node's messages
  double seconds = 1000;
  std::uint64_t bytes = 64;  ///< size of a message, at most one packet
  Reception heard{true, 0.1, 130, 76, 0, 0};
  std::uint64_t seed = 0;
  double step_s = 0.005;
  double loss = 0;                    ///< probability that a packet is lost regardless of the others
  std::vector<std::uint64_t> relays;  ///< by node, as for PacketNetwork
};

/// Runs the trial and returns the sum of all nodes' counts. Time advances in steps of step_s, and a node submits at
/// most one message per step, so the trial is valid only for rates well below 1 / step_s. Throws InvalidValue.
TopicCounts run_trial(const NetworkTrial& trial);

}  // namespace uwsim
