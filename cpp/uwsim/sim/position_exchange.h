#pragma once

#include <cstdint>
#include <string>

#include "uwsim/acoustics/modem/packet_network.h"
#include "uwsim/sensors/noisy_sensor.h"

namespace uwsim {

/// The pings of a USBL that shares its vehicle's modem. A ping and the fix that answers it are ordinary packets of the
/// link: they take air time, wait for their turn, and may collide or be lost. Only one ping is under way at a time.
/// While it waits for its turn, a newer ping replaces it; the fix is measured from the vehicle's position when the ping
/// is sent, and the station answers immediately. If no answer has arrived after the time for all turns and the travel
/// time over the sensor's range, the vehicle gives up and has no sample. Both packets contain the sample number modulo
/// 65536, which keeps vehicle and station synchronised.
class PositionExchange {
 public:
  static constexpr std::uint64_t kPriority = 2;  ///< the same as for other instruments
  /// A ping contains a number; a fix contains a number and three coordinates (assumed).
  static constexpr std::size_t kPingBytes = 2, kFixBytes = 14;

  PositionExchange() = default;
  /// node: the vehicle's node. sensor: the index of the sensor on the vehicle. topic: the topic of both packets.
  PositionExchange(std::size_t node, std::size_t sensor, std::uint64_t topic)
      : node_(node), sensor_(sensor), topic_(topic) {}

  std::size_t node() const { return node_; }
  std::size_t sensor() const { return sensor_; }

  /// Abandons an overdue ping, and sends a new one if the sensor requests it. Must be called before packets are sent.
  void request(NoisySensor& sensor, PacketNetwork& network, std::uint64_t now_ns);
  /// Returns whether the ping has been sent since the last call; if so, the caller must pass the vehicle's state to
  /// left().
  bool has_left(const PacketNetwork& network) const {
    return state_ == State::kWaiting && network.counts(topic_, node_).sent != sent_before_;
  }
  void left(const VehicleSnapshot& from, const NoisySensor& sensor, const PacketNetwork& network, std::uint64_t now_ns);
  /// Handles an arrived packet: the station answers a ping; a vehicle receives the answer.
  void receive(const LinkDelivery& delivery, const NoisySensor& sensor, PacketNetwork& network);
  /// Whether the sensor has its answer or will never get it. If so, settle() reports the outcome to the sensor.
  bool is_settled(std::uint64_t now_ns) const {
    return (state_ == State::kAsked || state_ == State::kAnswered) && now_ns >= until_ns_;
  }
  bool given_up() const { return state_ == State::kAsked; }
  const VehicleSnapshot& asked() const { return asked_; }
  void settle() { state_ = State::kIdle; }

  /// Saves or restores where the station was when the ping was sent.
  void exchange_station(StateArchive& archive);
  /// Saves or restores the exchange at `tick`; must be called after the network's. Throws InvalidValue.
  void exchange_state(StateArchive& archive, const PacketNetwork& network, std::uint64_t tick);

 private:
  enum class State : std::uint64_t { kIdle, kWaiting, kAsked, kAnswered };

  std::size_t node_ = 0, sensor_ = 0;
  std::uint64_t topic_ = 0;
  State state_ = State::kIdle;
  std::uint64_t number_ = 0;       // number of the sample for which the ping was sent
  std::uint64_t sent_before_ = 0;  // number of pings sent when the present one was queued
  // In kAsked: when the vehicle gives up; in kAnswered: when the sensor's latency has passed
  std::uint64_t until_ns_ = 0;
  VehicleSnapshot asked_;  // the vehicle's state when the ping was sent
};

}  // namespace uwsim
