#include "uwsim/autopilots/servo_frame.h"

#include <algorithm>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr std::size_t kHead_bytes = 8;
constexpr unsigned kMagic16 = 18458, kMagic32 = 29569;
constexpr double kCentre_us = 1500, kSpan_us = 400;

unsigned word(std::span<const std::uint8_t> bytes, std::size_t at) { return bytes[at] | unsigned{bytes[at + 1]} << 8; }

}  // namespace

Packet decode(std::span<const std::uint8_t> packet, ServoFrame& frame) {
  if (packet.size() < 2) return Packet::kForeign;
  const unsigned magic = word(packet, 0);
  if (magic != kMagic16 && magic != kMagic32) return Packet::kForeign;
  const std::size_t channels = magic == kMagic16 ? 16 : 32;
  if (packet.size() != kHead_bytes + 2 * channels) return Packet::kShort;
  frame.rate_hz = static_cast<std::uint16_t>(word(packet, 2));
  frame.number = word(packet, 4) | word(packet, 6) << 16;
  frame.channels = channels;
  frame.outputs_us.fill(0);
  for (std::size_t k = 0; k < channels; ++k) {
    frame.outputs_us[k] = static_cast<std::uint16_t>(word(packet, kHead_bytes + 2 * k));
  }
  return Packet::kFrame;
}

ServoMotors::ServoMotors(const Simulation& simulation, std::size_t vehicle, const std::vector<ServoMotor>& motors)
    : vehicle_(vehicle), motors_(motors) {
  const std::vector<Thruster>& thrusters = simulation.actuators(vehicle).thrusters();
  for (const ServoMotor& motor : motors) {
    require(motor.output < ServoOutputs{}.size(), "motors.output", motor.output, "must be in [0, 31]");
    require(motor.direction == 1 || motor.direction == -1, "motors.direction", motor.direction, "must be 1 or -1");
    require(std::any_of(thrusters.begin(), thrusters.end(),
                        [&](const Thruster& t) { return t.parameters().name == motor.thruster; }),
            "motors.thruster", motor.thruster, "must be a thruster of the vehicle");
    commands_.emplace_back(motor.thruster, 0.0);
  }
}

void ServoMotors::command(Simulation& simulation, const ServoOutputs& outputs_us) {
  for (std::size_t k = 0; k < motors_.size(); ++k) {
    const double width_us = outputs_us[motors_[k].output];
    const double command = width_us == 0 ? 0 : std::clamp((width_us - kCentre_us) / kSpan_us, -1.0, 1.0);
    commands_[k].second = motors_[k].direction * command;
  }
  simulation.actuators(vehicle_).set_thrusters(commands_);
}

}  // namespace uwsim
