#include <algorithm>
#include <cstdint>

#include "uwsim/acoustics/modem/packet_network.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::uint64_t kMost = 10000000;

/// A list: its length, then each item by exchange(item).
template <typename List, typename Exchange>
void exchange_list(StateArchive& archive, List& list, const Exchange& exchange) {
  std::uint64_t count = list.size();
  archive(count);
  require(count <= kMost, "state.link", count, "must be a plausible number of items");
  list.resize(count);
  for (auto& item : list) exchange(item);
}

void exchange_losses(StateArchive& archive, std::array<std::uint64_t, kLossKinds>& lost) {
  for (std::uint64_t& count : lost) archive(count);
}

void exchange_reception(StateArchive& archive, Reception& heard) {
  archive(heard.reached);
  for (double* value : {&heard.delay_s, &heard.signal_db, &heard.noise_db, &heard.closing_m_s, &heard.spread_s}) {
    archive(*value);
  }
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
  exchange_losses(archive, lost);
  archive(delay_s);
}

void LinkQuality::exchange_state(StateArchive& archive) {
  for (std::uint64_t* value : {&packets, &packets_lost, &heard_ns}) archive(*value);
  for (double* value : {&delay_s, &snr_db, &closing_m_s, &spread_s}) archive(*value);
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

void PacketNetwork::exchange_state(StateArchive& archive) {
  archive.same("link nodes", nodes_.size());
  for (Node& node : nodes_) {
    node.queue.exchange_state(archive);
    archive(node.may_send_ns);
    archive(node.waits);
    archive(node.sending_until_ns);
  }
  exchange_list(archive, topics_, [&](std::string& name) { archive(name); });
  counts_.resize(topics_.size(), std::vector<TopicCounts>(nodes_.size()));
  for (std::vector<TopicCounts>& by_node : counts_) {
    for (TopicCounts& counts : by_node) counts.exchange_state(archive);
  }
  for (LinkQuality& quality : quality_) quality.exchange_state(archive);
  exchange_list(archive, flights_, [&](Flight& flight) {
    flight.exchange_state(archive);
    require(flight.at < nodes_.size() && flight.from < nodes_.size(), "state.link.at", flight.at, "must be a node");
  });
  exchange_list(archive, sounds_, [&](Sound& sound) {
    sound.exchange_state(archive);
    require(sound.at < nodes_.size(), "state.link.at", sound.at, "must be a node");
  });
  exchange_list(archive, partials_, [&](Partial& partial) {
    archive(partial.number);
    archive(partial.fate);
    archive(partial.before);
    archive(partial.delivered);
    const std::uint64_t fate = std::max(partial.fate, partial.before);
    require(fate < kLossKinds, "state.link.fate", fate, "must be a kind of loss");
  });
  exchange_list(archive, outages_, [&](Outage& outage) {
    for (std::uint64_t* value : {&outage.node, &outage.from_ns, &outage.until_ns}) archive(*value);
  });
  exchange_list(archive, deliveries_, [&](LinkDelivery& delivery) { delivery.exchange_state(archive); });
  for (std::uint64_t* value : {&next_message_, &next_packet_, &next_end_ns_, &waiting_, &busy_until_ns_}) {
    archive(*value);
  }
  archive(sending_s_);
}

}  // namespace uwsim
