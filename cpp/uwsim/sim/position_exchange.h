#pragma once

#include <cstdint>
#include <string>

#include "uwsim/acoustics/modem/packet_network.h"
#include "uwsim/sensors/noisy_sensor.h"

namespace uwsim {

/// The pings of a USBL that shares its vehicle's modem: a ping and the fix that answers it are packets of the link like
/// any others, with air time, turns, collisions and losses. One ping at a time: it waits for its turn (a newer one
/// takes its place), is measured from where the vehicle is when it leaves, and is answered by the station at once; the
/// vehicle gives up when no answer has come after all turns and the travel over its range, and has no sample then.
/// Vehicle and station are in step by the number of the sample, modulo 65536, in both packets.
class PositionExchange {
 public:
  static constexpr std::uint64_t kPriority = 2;                 ///< as other instruments
  static constexpr std::size_t kPingBytes = 2, kFixBytes = 14;  ///< number; and three coordinates; assumed

  PositionExchange() = default;
  /// node: of the vehicle; sensor: its index there. topic: of both packets.
  PositionExchange(std::size_t node, std::size_t sensor, std::uint64_t topic)
      : node_(node), sensor_(sensor), topic_(topic) {}

  std::size_t node() const { return node_; }
  std::size_t sensor() const { return sensor_; }

  /// Before packets are sent: gives up what is overdue, and asks if the sensor does.
  void ask(NoisySensor& sensor, PacketNetwork& network, std::uint64_t now_ns);
  /// Whether its ping has left since the last call; the caller then tells from where by left().
  bool has_left(const PacketNetwork& network) const {
    return state_ == State::kWaiting && network.counts(topic_, node_).sent != sent_before_;
  }
  void left(const VehicleSnapshot& from, const NoisySensor& sensor, const PacketNetwork& network, std::uint64_t now_ns);
  /// The station answers a ping that has arrived there; a vehicle has the answer.
  void hear(const LinkDelivery& delivery, const NoisySensor& sensor, PacketNetwork& network);
  /// Whether the sensor has its answer, or will never have it. If so, it is told by settle().
  bool is_settled(std::uint64_t now_ns) const {
    return (state_ == State::kAsked || state_ == State::kAnswered) && now_ns >= until_ns_;
  }
  bool given_up() const { return state_ == State::kAsked; }
  const VehicleSnapshot& asked() const { return asked_; }
  void settle() { state_ = State::kIdle; }

  /// Saves or restores it, as of `tick`, after the network. Throws InvalidValue.
  void exchange_state(StateArchive& archive, const PacketNetwork& network, std::uint64_t tick);

 private:
  enum class State : std::uint64_t { kIdle, kWaiting, kAsked, kAnswered };

  std::size_t node_ = 0, sensor_ = 0;
  std::uint64_t topic_ = 0;
  State state_ = State::kIdle;
  std::uint64_t number_ = 0;       // of the sample that it asks for
  std::uint64_t sent_before_ = 0;  // pings, when the present one began to wait
  std::uint64_t until_ns_ = 0;     // kAsked: gives up; kAnswered: the sensor's latency is over
  VehicleSnapshot asked_;          // where the ping left
};

}  // namespace uwsim
