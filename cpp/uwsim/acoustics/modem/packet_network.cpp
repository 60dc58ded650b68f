#include "uwsim/acoustics/modem/packet_network.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/stream_name.h"

namespace uwsim {
namespace {

std::uint64_t ns(double seconds) { return static_cast<std::uint64_t>(std::llround(1e9 * seconds)); }

}  // namespace

PacketNetwork::PacketNetwork(const ModemSpec& modem, std::size_t nodes, std::vector<LinkFault> faults,
                             std::uint64_t seed, std::uint64_t step_ns)
    : modem_((modem.check(), modem)),
      faults_(std::move(faults)),
      step_ns_(step_ns),
      losses_(seed, stream_name("link", "loss")),
      waits_(seed, stream_name("link", "wait")),
      nodes_(nodes),
      quality_(nodes * nodes) {
  if (modem_.retransmissions > 0) acknowledgements_ = topic("acknowledgement");
}

std::uint64_t PacketNetwork::topic(const std::string& name) {
  const auto found = std::find(topics_.begin(), topics_.end(), name);
  if (found == topics_.end()) {
    topics_.push_back(name);
    counts_.emplace_back(nodes_.size());
    return topics_.size() - 1;
  }
  return static_cast<std::uint64_t>(found - topics_.begin());
}

bool PacketNetwork::send(std::size_t from, LinkMessage message, std::uint64_t now_ns) {
  require(from < nodes_.size(), "link.from", from, "must be a node");
  require(message.to < nodes_.size() && message.to != from, "link.to", message.to, "must be another node");
  require(message.topic < topics_.size(), "link.topic", message.topic, "must be a topic");
  require(message.repeats <= kRepeatsMax, "link.repeats", message.repeats, "must be at most 1000");
  TopicCounts& counts = counts_[message.topic][from];
  message.number = next_message_++;
  message.from = from;
  message.given_ns = now_ns;
  message.packets_sent = message.held_until_ns = 0;
  message.retransmissions = message.signal ? 0 : modem_.retransmissions;
  ++counts.given;
  LinkMessage older;
  const auto added = nodes_[from].queue.add(std::move(message), modem_.queue_bytes, older);
  if (added == PacketQueue::Added::kQueued) ++waiting_;
  if (added == PacketQueue::Added::kReplaced) {
    if (older.again) {
      drop_repeat(older);
    } else {
      ++counts.replaced;
    }
  }
  if (added == PacketQueue::Added::kRefused) ++counts.refused;
  return added != PacketQueue::Added::kRefused;
}

void PacketNetwork::transmit(std::uint64_t now_ns, const LinkMedium& medium) {
  if (waiting_ == 0) return;
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    Node& node = nodes_[index];
    if (node.queue.empty()) continue;
    node.queue.expire(now_ns, [&](const LinkMessage& message) {
      if (message.again) {
        drop_repeat(message);
      } else {
        ++counts_[message.topic][index].late;
      }
      --waiting_;
    });
    if (node.waits && node.may_send_ns >= now_ns + step_ns_) continue;
    while (const LinkMessage* next = node.queue.next(now_ns)) {
      const std::uint64_t sent = next->packets_sent * modem_.packet_bytes;
      const std::uint64_t bytes = std::min<std::uint64_t>(next->payload.size() - sent, modem_.packet_bytes);
      const std::uint64_t length_ns = ns(modem_.packet_s(bytes));
      std::uint64_t start_ns = 0;
      if (!may_send(index, now_ns, length_ns, start_ns)) break;
      send_packet(index, now_ns, start_ns, length_ns, medium);
    }
  }
}

/// Whether, and when, the next packet may begin within this step.
bool PacketNetwork::may_send(std::size_t index, std::uint64_t now_ns, std::uint64_t length_ns,
                             std::uint64_t& start_ns) {
  Node& node = nodes_[index];
  start_ns = std::max(now_ns, node.sending_until_ns);
  if (modem_.takes_turns()) {
    const std::uint64_t slot_ns = ns(modem_.slot_s), period_ns = slot_ns + ns(modem_.guard_s);
    const std::uint64_t slot = start_ns / period_ns, within_ns = start_ns % period_ns;
    return start_ns < now_ns + step_ns_ && slot % nodes_.size() == index && within_ns + length_ns <= slot_ns;
  }
  if (modem_.kind == LinkKind::kModem && modem_.backoff_s > 0) {
    if (!node.waits) {
      node.waits = true;
      node.may_send_ns =
          start_ns + ns(modem_.backoff_s * waits_.uniform(next_packet_, static_cast<std::uint32_t>(index)));
    }
    start_ns = std::max(start_ns, node.may_send_ns);
  }
  return start_ns < now_ns + step_ns_;
}

void PacketNetwork::send_packet(std::size_t index, std::uint64_t now_ns, std::uint64_t start_ns,
                                std::uint64_t length_ns, const LinkMedium& medium) {
  Node& node = nodes_[index];
  LinkMessage& message = *node.queue.next(now_ns);
  TopicCounts& counts = counts_[message.topic][message.from];
  if (message.packets_sent == 0 && !message.again) ++counts.sent;
  if (message.packets_sent == 0 && message.held_until_ns > 0) ++counts.resent;
  Flight flight;
  flight.packet = next_packet_++;
  flight.from = index;
  flight.at = message.to;
  flight.heard = medium.receive(index, flight.at);
  flight.starts_ns = start_ns + ns(flight.heard.delay_s);
  flight.ends_ns = flight.starts_ns + length_ns;
  const std::uint64_t first = message.packets_sent * modem_.packet_bytes;
  flight.bytes = std::min<std::uint64_t>(message.payload.size() - first, modem_.packet_bytes);
  flight.is_last = first + flight.bytes == message.payload.size();
  counts.bytes_sent += flight.bytes;
  node.waits = false;
  node.sending_until_ns = start_ns + length_ns;
  if (node.sending_until_ns > busy_until_ns_) {
    sending_s_ += 1e-9 * static_cast<double>(node.sending_until_ns - std::max(busy_until_ns_, start_ns));
    busy_until_ns_ = node.sending_until_ns;
  }
  if (modem_.kind == LinkKind::kModem) {
    flight.deaf = nodes_[flight.at].sending_until_ns > flight.starts_ns;
    deafen(index, start_ns, node.sending_until_ns);
    add_interference(flight, start_ns, length_ns, medium);
    sounds_.push_back({flight.packet, flight.at, flight.starts_ns, flight.ends_ns, flight.heard.signal_db});
  }
  flight.is_copy = message.again || message.repeats + message.retransmissions > 0;
  if (flight.is_last && message.repeats + message.retransmissions > 0) {
    const bool again_at_once = message.repeats > 0;
    flight.message = node.queue.repeat_next(now_ns, again_at_once ? 0 : node.sending_until_ns + ns(timeout_s()));
  } else if (flight.is_last) {
    flight.message = node.queue.pop_next(now_ns);
    --waiting_;
  } else {
    ++message.packets_sent;
    flight.message.number = message.number;
    flight.message.topic = message.topic;
  }
  next_end_ns_ = std::min(next_end_ns_, flight.ends_ns);
  flights_.push_back(std::move(flight));
}

void PacketNetwork::add_interference(const Flight& flight, std::uint64_t start_ns, std::uint64_t length_ns,
                                     const LinkMedium& medium) {
  for (std::size_t at = 0; at < nodes_.size(); ++at) {
    if (at == flight.from || at == flight.at) continue;
    const auto [delay_s, level_db] = medium.interference(flight.from, at);
    const std::uint64_t starts_ns = start_ns + ns(delay_s);
    sounds_.push_back({flight.packet, at, starts_ns, starts_ns + length_ns, level_db});
  }
}

/// Marks a node as transmitting: it receives nothing in the meantime.
void PacketNetwork::deafen(std::size_t index, std::uint64_t from_ns, std::uint64_t until_ns) {
  for (Flight& flight : flights_) {
    if (flight.at == index && flight.starts_ns < until_ns && flight.ends_ns > from_ns) {
      flight.deaf = true;
    }
  }
}

double PacketNetwork::longest_wait_s() const {
  if (modem_.kind != LinkKind::kModem) return 0;
  return modem_.takes_turns() ? static_cast<double>(nodes_.size()) * (modem_.slot_s + modem_.guard_s)
                              : modem_.backoff_s + modem_.packet_s(modem_.packet_bytes);
}

double PacketNetwork::timeout_s() const {
  return longest_wait_s() + modem_.packet_s(modem_.acknowledgement_bytes) + 2 * modem_.guard_s +
         2e-9 * static_cast<double>(step_ns_);
}

std::uint64_t PacketNetwork::next_arrival_ns(std::uint64_t now_ns) const {
  return waiting_ > 0 ? now_ns : next_end_ns_;
}

}  // namespace uwsim
