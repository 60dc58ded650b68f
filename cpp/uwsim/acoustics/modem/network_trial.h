#pragma once

#include <cstdint>

#include "uwsim/acoustics/modem/packet_network.h"

namespace uwsim {

/// A network under random load, for its laws: all nodes but node 0 have messages for node 0, a Poisson process each, of
/// one packet. All packets are heard alike.
struct NetworkTrial {
  ModemSpec modem;
  std::size_t nodes = 2;
  double rate_1_s = 1;  ///< of each node's messages
  double seconds = 1000;
  std::uint64_t bytes = 64;  ///< of a message, at most a packet
  Reception heard{true, 0.1, 130, 76, 0, 0};
  std::uint64_t seed = 0;
  double step_s = 0.005;
};

/// The sum of all nodes' counts. Time goes by step_s, in which a node gets one message at most: valid for rates well
/// below 1 / step_s. Throws InvalidValue.
TopicCounts run_trial(const NetworkTrial& trial);

}  // namespace uwsim
