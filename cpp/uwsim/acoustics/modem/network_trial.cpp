#include "uwsim/acoustics/modem/network_trial.h"

#include <cmath>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

class EvenMedium final : public LinkMedium {
 public:
  explicit EvenMedium(const Reception& heard) : heard_(heard) {}
  Reception receive(std::size_t, std::size_t) const override { return heard_; }
  std::array<double, 2> interference(std::size_t, std::size_t) const override {
    return {heard_.delay_s, heard_.signal_db};
  }

 private:
  Reception heard_;
};

void check(const NetworkTrial& trial) {
  require(trial.nodes >= 2 && trial.nodes <= 1000, "nodes", trial.nodes, "must be in [2, 1000]");
  require(trial.step_s > 0 && trial.step_s <= 1, "step_s", with_unit(trial.step_s, "s"), "must be in (0, 1] s");
  require(trial.rate_1_s >= 0 && trial.rate_1_s * trial.step_s <= 0.5, "rate_1_s", with_unit(trial.rate_1_s, "1/s"),
          "must be below a half of 1 / step_s");
  require(trial.seconds > 0 && trial.seconds <= 1e7, "seconds", trial.seconds, "must be in (0, 1e7] s");
  require(trial.loss >= 0 && trial.loss <= 1, "loss", trial.loss, "must be in [0, 1]");
  require(trial.relays.size() <= trial.nodes, "relays", trial.relays.size(), "must be at most one for each node");
  require(trial.bytes <= trial.modem.packet_bytes, "bytes", trial.bytes, "must fit into a packet");
}

}  // namespace

TopicCounts run_trial(const NetworkTrial& trial) {
  check(trial);
  const auto step_ns = static_cast<std::uint64_t>(std::llround(1e9 * trial.step_s));
  std::vector<LinkFault> faults;
  if (trial.loss > 0) faults.push_back({0, 1e9, trial.loss});
  PacketNetwork network(trial.modem, trial.nodes, std::move(faults), trial.seed, step_ns, trial.relays);
  const EvenMedium medium(trial.heard);
  const RandomStream arrivals(trial.seed, "trial/arrivals");
  const std::uint64_t topic = network.topic("load");
  const double chance = trial.rate_1_s * trial.step_s;
  std::uint64_t now_ns = 0;
  for (std::uint64_t tick = 0; now_ns < static_cast<std::uint64_t>(1e9 * trial.seconds); ++tick) {
    for (std::size_t node = 1; node < trial.nodes; ++node) {
      if (arrivals.uniform(tick, static_cast<std::uint32_t>(node)) >= chance) continue;
      LinkMessage message;
      message.topic = topic;
      message.payload.assign(trial.bytes, 'x');
      network.send(node, std::move(message), now_ns);
    }
    network.transmit(now_ns, medium);
    now_ns += step_ns;
    network.receive(now_ns);
  }
  TopicCounts all;
  for (std::size_t node = 0; node < trial.nodes; ++node) all += network.counts(topic, node);
  return all;
}

}  // namespace uwsim
