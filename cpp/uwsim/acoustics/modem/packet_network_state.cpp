#include <algorithm>
#include <cstdint>
#include <string>

#include "uwsim/acoustics/modem/packet_network.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

void exchange_reception(StateArchive& archive, Reception& heard) {
  archive(heard.reached);
  for (double* value : {&heard.delay_s, &heard.signal_db, &heard.noise_db, &heard.closing_m_s, &heard.spread_s}) {
    archive(*value);
  }
  archive(heard.bed_departure);
}

}  // namespace

void LinkDelivery::exchange_state(StateArchive& archive) {
  for (std::uint64_t* value : {&number, &from, &to, &topic, &given_ns, &arrived_ns}) archive(*value);
  archive(payload);
}

void TopicCounts::exchange_state(StateArchive& archive) {
  for (std::uint64_t* value : {&given, &replaced, &refused, &late, &sent, &delivered, &bytes_sent, &bytes_delivered}) {
    archive(*value);
  }
  for (std::uint64_t& count : lost) archive(count);
  archive(delay_s);
  archive(resent);
}

void LinkQuality::exchange_state(StateArchive& archive) {
  for (std::uint64_t* value : {&packets, &packets_lost, &heard_ns}) archive(*value);
  for (double* value : {&delay_s, &snr_db, &closing_m_s, &spread_s}) archive(*value);
  archive(packets_uneven);
}

void PacketNetwork::Flight::exchange_state(StateArchive& archive) {
  for (std::uint64_t* value : {&packet, &from, &at, &starts_ns, &ends_ns, &bytes}) archive(*value);
  for (bool* value : {&is_last, &deaf, &is_copy}) archive(*value);
  exchange_reception(archive, heard);
  message.exchange_state(archive);
}

void PacketNetwork::Sound::exchange_state(StateArchive& archive) {
  for (std::uint64_t* value : {&packet, &at, &starts_ns, &ends_ns}) archive(*value);
  archive(level_db);
}

void PacketNetwork::Partial::exchange_state(StateArchive& archive) {
  for (std::uint64_t* value : {&number, &fate, &before}) archive(*value);
  archive(delivered);
  require(std::max(fate, before) < kLossKinds, "state.link.fate", fate, "must be a kind of loss");
}

void PacketNetwork::exchange_state(StateArchive& archive) {
  archive.same("link nodes", nodes_.size());
  for (Node& node : nodes_) {
    node.queue.exchange_state(archive);
    archive(node.may_send_ns);
    archive(node.waits);
    archive(node.sending_until_ns);
  }
  archive.list(topics_, [&](std::string& name) { archive(name); });
  if (archive.restoring()) counts_.clear();
  for (std::size_t k = 0; k < topics_.size(); ++k) {
    if (archive.restoring()) counts_.emplace_back(nodes_.size());
    for (TopicCounts& counts : counts_[k]) counts.exchange_state(archive);
  }
  for (LinkQuality& quality : quality_) quality.exchange_state(archive);
  archive.list(flights_, [&](Flight& flight) { flight.exchange_state(archive); });
  archive.list(sounds_, [&](Sound& sound) { sound.exchange_state(archive); });
  archive.list(partials_, [&](Partial& partial) { partial.exchange_state(archive); });
  archive.list(outages_, [&](Outage& outage) {
    for (std::uint64_t* value : {&outage.node, &outage.from_ns, &outage.until_ns}) archive(*value);
  });
  archive.list(deliveries_, [&](LinkDelivery& delivery) { delivery.exchange_state(archive); });
  for (std::uint64_t* value : {&next_message_, &next_packet_, &next_end_ns_, &waiting_, &busy_until_ns_}) {
    archive(*value);
  }
  archive(sending_s_);
  if (archive.restoring()) check();
}

/// Throws InvalidValue for a state that no network could have saved and that would lead to an invalid index or length,
/// or to an endless loop.
void PacketNetwork::check() const {
  std::uint64_t waiting = 0, next_end_ns = ~std::uint64_t{0};
  for (std::size_t from = 0; from < nodes_.size(); ++from) {
    for (const LinkMessage* message : nodes_[from].queue.messages()) check(*message, from);
    waiting += nodes_[from].queue.size();
  }
  require(waiting_ == waiting, "state.link.waiting", waiting_, "must be the number of messages");
  require(acknowledgements_ < topics_.size() || modem_.retransmissions == 0, "state.link.topics", topics_.size(),
          "must include acknowledgements");
  for (const Flight& flight : flights_) {
    check_ends("flight", flight.from, flight.at);
    check_topic(flight.message.topic);
    require(flight.message.from < nodes_.size() && flight.message.to < nodes_.size(), "state.link.flight.message.to",
            flight.message.to, "must be a node");
    require(flight.bytes <= modem_.packet_bytes, "state.link.bytes", flight.bytes, "must be those of a packet");
    next_end_ns = std::min(next_end_ns, flight.ends_ns);
  }
  require(next_end_ns_ == next_end_ns, "state.link.next_end_ns", next_end_ns_, "must be that of a flight");
  for (const Sound& sound : sounds_) require(sound.at < nodes_.size(), "state.link.at", sound.at, "must be a node");
  for (const LinkDelivery& delivery : deliveries_) {
    check_ends("delivery", delivery.from, delivery.to);
    check_topic(delivery.topic);
  }
}

void PacketNetwork::check(const LinkMessage& message, std::size_t from) const {
  check_ends("message", from, message.to);
  check_topic(message.topic);
  require(message.from < nodes_.size(), "state.link.from", message.from, "must be a node");
  require(message.repeats <= kRepeatsMax, "state.link.repeats", message.repeats, "must be at most 1000");
  require(message.retransmissions <= modem_.retransmissions, "state.link.retransmissions", message.retransmissions,
          "must be at most the modem's");
  const std::uint64_t packets = (message.payload.size() + modem_.packet_bytes - 1) / modem_.packet_bytes;
  require(message.packets_sent < std::max<std::uint64_t>(packets, 1), "state.link.packets_sent", message.packets_sent,
          "must leave some to send");
}

void PacketNetwork::check_ends(const char* what, std::size_t from, std::size_t to) const {
  const std::string path = std::string("state.link.") + what;
  require(from < nodes_.size() && to < nodes_.size() && from != to, path, to, "must be another node");
}

void PacketNetwork::check_topic(std::uint64_t topic) const {
  require(topic < topics_.size(), "state.link.topic", topic, "must be a topic");
}

}  // namespace uwsim
