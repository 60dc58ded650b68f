#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/acoustics/modem/packet_network.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kNever = ~std::uint64_t{0};
constexpr std::size_t kDeliveriesKept = 512;
constexpr std::uint32_t kByNoise = 0, kByFault = 1;  // indices of random draws

std::uint64_t nanoseconds(double seconds) { return static_cast<std::uint64_t>(std::llround(1e9 * seconds)); }

}  // namespace

std::size_t PacketNetwork::receive(std::uint64_t now_ns) {
  if (now_ns < next_end_ns_) return 0;
  const std::uint64_t before = delivered_;
  next_end_ns_ = kNever;
  std::vector<std::size_t>& order = arrived_;
  order.clear();
  for (std::size_t k = 0; k < flights_.size(); ++k) {
    if (flights_[k].ends_ns <= now_ns) {
      order.push_back(k);
    } else {
      next_end_ns_ = std::min(next_end_ns_, flights_[k].ends_ns);
    }
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(flights_[a].ends_ns, flights_[a].packet) < std::pair(flights_[b].ends_ns, flights_[b].packet);
  });
  for (const std::size_t k : order) arrive(flights_[k]);
  std::erase_if(flights_, [&](const Flight& flight) { return flight.ends_ns <= now_ns; });
  forget_sounds(now_ns);
  forget_outages(now_ns);
  return delivered_ - before;
}

void PacketNetwork::arrive(const Flight& flight) {
  const Loss loss = fate(flight);
  LinkQuality& quality = quality_[flight.from * nodes_.size() + flight.at];
  ++quality.packets;
  quality.packets_lost += loss != Loss::kNone;
  quality.delay_s = flight.heard.delay_s;
  quality.snr_db = flight.heard.snr_db();
  quality.closing_m_s = flight.heard.closing_m_s;
  quality.spread_s = flight.heard.spread_s;
  quality.packets_uneven += flight.heard.bed_departure > kUnevenBed;
  if (flight.is_last && !flight.is_copy) {
    const Partial known = partial(flight.message.number);
    forget(flight.message.number);
    finish(flight, known.fate ? static_cast<Loss>(known.fate) : loss);
    return;
  }
  Partial& known = partial(flight.message.number);
  if (known.fate == 0) known.fate = static_cast<std::uint64_t>(loss);
  if (flight.is_last) finish_copy(flight, known);
}

/// Handles one complete copy of a message. A message counts once: as delivered when its first copy arrives, or as lost
/// when no copy has arrived and none can still arrive.
void PacketNetwork::finish_copy(const Flight& flight, Partial& known) {
  const auto copy = static_cast<Loss>(known.fate);
  const bool is_first = copy == Loss::kNone && !known.delivered;
  known.delivered |= is_first;
  known.before = known.fate;
  known.fate = 0;
  const bool is_lost = !known.delivered && !more_to_come(flight);
  if (!more_to_come(flight)) forget(flight.message.number);
  if (copy == Loss::kNone && modem_.retransmissions > 0 && !flight.message.signal) acknowledge(flight);
  if (is_first || is_lost) finish(flight, copy);
}

/// Queues the acknowledgement of a message that has arrived.
void PacketNetwork::acknowledge(const Flight& flight) {
  LinkMessage message;
  message.to = flight.from;
  message.topic = acknowledgements_;
  message.acknowledges = flight.message.number;
  message.signal = true;
  message.payload.assign(modem_.acknowledgement_bytes, '\0');
  send(flight.at, std::move(message), flight.ends_ns);
}

/// Called when the acknowledgement of a message has arrived at its sender.
void PacketNetwork::acknowledged(std::size_t from, std::uint64_t number) {
  if (!nodes_[from].queue.finish(number)) return;
  --waiting_;
  const bool on_its_way = std::any_of(flights_.begin(), flights_.end(),
                                      [&](const Flight& flight) { return flight.message.number == number; });
  if (!on_its_way) forget(number);
}

/// Whether another copy of the flight's message is queued or in flight.
bool PacketNetwork::more_to_come(const Flight& flight) const {
  const std::uint64_t number = flight.message.number;
  return nodes_[flight.from].queue.holds(number) ||
         std::any_of(flights_.begin(), flights_.end(),
                     [&](const auto& other) { return other.message.number == number && other.packet > flight.packet; });
}

/// Called when the remaining repeats of a message are dropped: the message is lost if no copy of it is still in flight.
void PacketNetwork::drop_repeat(const LinkMessage& message) {
  const bool on_its_way = std::any_of(flights_.begin(), flights_.end(),
                                      [&](const Flight& flight) { return flight.message.number == message.number; });
  if (on_its_way) return;
  const Partial known = partial(message.number);
  if (!known.delivered) ++counts_[message.topic][message.from].lost[known.before];
  forget(message.number);
}

PacketNetwork::Partial& PacketNetwork::partial(std::uint64_t number) {
  const auto found =
      std::find_if(partials_.begin(), partials_.end(), [&](const Partial& known) { return known.number == number; });
  if (found != partials_.end()) return *found;
  partials_.push_back({number, 0, 0, false});
  return partials_.back();
}

void PacketNetwork::forget(std::uint64_t number) {
  std::erase_if(partials_, [&](const Partial& known) { return known.number == number; });
}

Loss PacketNetwork::fate(const Flight& flight) const {
  if (struck_by_fault(flight)) return Loss::kFault;
  if (!flight.heard.reached) return Loss::kUnheard;
  if (modem_.kind != LinkKind::kModem) return Loss::kNone;
  if (flight.deaf) return Loss::kDeaf;
  if (std::abs(flight.heard.closing_m_s) > modem_.speed_max_m_s) return Loss::kDoppler;
  const double draw = losses_.uniform(flight.packet, kByNoise);
  if (draw < packet_loss(modem_, flight.heard, -300, flight.bytes)) return Loss::kNoise;
  const double interference = interference_db(flight);
  if (interference > -300 && draw < packet_loss(modem_, flight.heard, interference, flight.bytes)) {
    return Loss::kCollision;
  }
  return Loss::kNone;
}

/// Whether part of the packet's reception overlaps a fault that destroys it.
bool PacketNetwork::struck_by_fault(const Flight& flight) const {
  const auto lies_in = [&](std::uint64_t from_ns, std::uint64_t until_ns) {
    return flight.starts_ns < until_ns && (flight.ends_ns > from_ns || flight.starts_ns >= from_ns);
  };
  for (const Outage& outage : outages_) {
    if ((outage.node == flight.from || outage.node == flight.at) && lies_in(outage.from_ns, outage.until_ns)) {
      return true;
    }
  }
  return std::any_of(faults_.begin(), faults_.end(), [&](const LinkFault& fault) {
    return lies_in(nanoseconds(fault.from_s), nanoseconds(fault.until_s)) &&
           losses_.uniform(flight.packet, kByFault) < fault.loss;
  });
}

void PacketNetwork::cut_off(std::size_t node, bool is_cut_off, std::uint64_t now_ns) {
  require(node < nodes_.size(), "link.node", node, "must be a node");
  for (Outage& outage : outages_) {
    if (outage.node == node && outage.until_ns == kNever) {
      if (!is_cut_off) outage.until_ns = now_ns;
      return;
    }
  }
  if (is_cut_off) outages_.push_back({node, now_ns, kNever});
}

double PacketNetwork::fault_loss(std::size_t from, std::size_t to, std::uint64_t now_ns) const {
  const double now_s = 1e-9 * static_cast<double>(now_ns);
  for (const Outage& outage : outages_) {
    if ((outage.node == from || outage.node == to) && outage.from_ns <= now_ns && now_ns < outage.until_ns) return 1;
  }
  double loss = 0;  // a single draw is compared with all of them
  for (const LinkFault& fault : faults_) {
    if (fault.from_s <= now_s && now_s < fault.until_s) loss = std::max(loss, fault.loss);
  }
  return loss;
}

/// The combined level of all other packets that overlap this one at the receiver.
double PacketNetwork::interference_db(const Flight& flight) const {
  double power = 0;
  for (const Sound& other : sounds_) {
    if (other.at != flight.at || other.packet == flight.packet || other.starts_ns >= flight.ends_ns ||
        other.ends_ns <= flight.starts_ns) {
      continue;
    }
    power += std::pow(10, 0.1 * other.level_db);
  }
  return power > 0 ? 10 * std::log10(power) : -300;
}

void PacketNetwork::finish(const Flight& flight, Loss loss) {
  const LinkMessage& message = flight.message;
  TopicCounts& counts = counts_[message.topic][message.from];
  if (loss != Loss::kNone) {
    ++counts.lost[static_cast<std::size_t>(loss)];
    return;
  }
  ++counts.delivered;
  counts.bytes_delivered += message.payload.size();
  counts.delay_s += 1e-9 * static_cast<double>(flight.ends_ns - message.given_ns);
  if (message.acknowledges != LinkMessage::kNone) return acknowledged(flight.at, message.acknowledges);
  if (!message.signal) quality_[message.from * nodes_.size() + flight.at].heard_ns = flight.ends_ns;
  ++delivered_;
  deliveries_.push_back(
      {message.number, message.from, flight.at, message.topic, message.given_ns, flight.ends_ns, message.payload});
  if (deliveries_.size() > kDeliveriesKept) deliveries_.pop_front();
}

/// Discards sounds that cannot overlap any packet still in flight.
void PacketNetwork::forget_sounds(std::uint64_t now_ns) {
  first_start_ns_.assign(nodes_.size(), kNever);  // for each node, the earliest start of a packet still in flight to it
  for (const Flight& flight : flights_) {
    first_start_ns_[flight.at] = std::min(first_start_ns_[flight.at], flight.starts_ns);
  }
  std::erase_if(sounds_,
                [&](const Sound& old) { return old.ends_ns <= now_ns && first_start_ns_[old.at] >= old.ends_ns; });
}

/// Discards outages that cannot overlap any packet still in flight.
void PacketNetwork::forget_outages(std::uint64_t now_ns) {
  std::uint64_t first_ns = now_ns;
  for (const Flight& flight : flights_) first_ns = std::min(first_ns, flight.starts_ns);
  std::erase_if(outages_, [&](const Outage& old) { return old.until_ns <= first_ns; });
}

}  // namespace uwsim
