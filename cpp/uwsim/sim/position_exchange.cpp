#include "uwsim/sim/position_exchange.h"

#include <cmath>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

std::uint64_t nanoseconds(double seconds) { return static_cast<std::uint64_t>(std::llround(1e9 * seconds)); }

std::string numbered(std::uint64_t number, std::size_t size) {
  std::string payload(size, '\0');
  payload[0] = static_cast<char>(number & 0xff);
  payload[1] = static_cast<char>(number >> 8 & 0xff);
  return payload;
}

}  // namespace

void PositionExchange::request(NoisySensor& sensor, PacketNetwork& network, std::uint64_t now_ns) {
  const std::optional<std::uint64_t> question = sensor.take_question();
  if (!question || state_ == State::kAsked || state_ == State::kAnswered) return;
  LinkMessage ping;
  ping.topic = topic_;
  ping.priority = kPriority;
  ping.replaces = ping.signal = true;
  ping.payload = numbered(*question, kPingBytes);
  if (state_ == State::kIdle) sent_before_ = network.counts(topic_, node_).sent;
  const bool has_room = network.send(node_, std::move(ping), now_ns);
  if (has_room) number_ = *question;
  if (has_room) state_ = State::kWaiting;
}

void PositionExchange::left(const VehicleSnapshot& from, const NoisySensor& sensor, const PacketNetwork& network,
                            std::uint64_t now_ns) {
  state_ = State::kAsked;
  asked_ = from;
  until_ns_ = now_ns + nanoseconds(2 * network.longest_wait_s() + sensor.longest_travel_time_s());
}

void PositionExchange::receive(const LinkDelivery& delivery, const NoisySensor& sensor, PacketNetwork& network) {
  if (delivery.topic != topic_) return;
  if (delivery.from == node_ && delivery.to == 0) {
    LinkMessage fix;
    fix.to = node_;
    fix.topic = topic_;
    fix.priority = kPriority;
    fix.replaces = fix.signal = true;
    fix.payload = delivery.payload;
    fix.payload.resize(kFixBytes);
    network.send(0, std::move(fix), delivery.arrived_ns);
  } else if (delivery.to == node_ && state_ == State::kAsked &&
             delivery.payload.compare(0, kPingBytes, numbered(number_, kPingBytes)) == 0) {
    state_ = State::kAnswered;
    until_ns_ = delivery.arrived_ns + nanoseconds(sensor.spec().latency_s);
  }
}

void PositionExchange::exchange_station(StateArchive& archive) {
  for (double& each : asked_.station_world_m) archive(each);
}

void PositionExchange::exchange_state(StateArchive& archive, const PacketNetwork& network, std::uint64_t tick) {
  require(topic_ < network.topics().size(), "state.link.topics", network.topics().size(),
          "must be those of its instruments");
  archive.same("link exchange", node_);
  archive.same("link exchange", sensor_);
  auto state = static_cast<std::uint64_t>(state_);
  archive(state);
  require(state <= static_cast<std::uint64_t>(State::kAnswered), "state.link.exchange", state, "must be a state");
  state_ = static_cast<State>(state);
  for (std::uint64_t* value : {&number_, &sent_before_, &until_ns_, &asked_.tick}) archive(*value);
  require(asked_.tick <= tick, "state.link.asked", asked_.tick, "must not lie ahead");
  archive(asked_.state);
  archive(asked_.acceleration_body);
  archive(asked_.touching);
}

}  // namespace uwsim
