#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "uwsim/sim/simulation.h"

namespace uwsim {

/// Pulse widths by servo output [us]; 0: no output.
using ServoOutputs = std::array<std::uint16_t, 32>;

/// A message that an autopilot sends for each frame: the servo packet of ArduPilot's JSON interface
/// (libraries/SITL/SIM_JSON.h), little-endian: uint16 magic, uint16 frame rate, uint32 frame number, and 16 or 32 pulse
/// widths of 16 bits.
struct ServoFrame {
  std::uint16_t rate_hz = 0;
  std::uint32_t number = 0;
  std::size_t channels = 0;  ///< 16 or 32
  ServoOutputs outputs_us{};
};

enum class Packet { kFrame, kShort, kForeign };  ///< kShort: correct magic number, wrong length

/// Decodes a packet into `frame`, which only changes if the result is kFrame.
Packet decode(std::span<const std::uint8_t> packet, ServoFrame& frame);

/// A motor of the autopilot's frame. A pulse of 1500 us is command 0, and 1900 us command 1 times `direction`
/// (MOT_PWM_MIN 1100, MOT_PWM_MAX 1900); wider pulses count as 1900 us.
struct ServoMotor {
  std::size_t output = 0;  ///< index in ServoOutputs
  std::string thruster;
  double direction = 1;  ///< 1 or -1
};

/// Converts servo outputs to commands for a vehicle's thrusters.
class ServoMotors {
 public:
  /// Throws InvalidValue for an unknown thruster, output or direction.
  ServoMotors(const Simulation& simulation, std::size_t vehicle, const std::vector<ServoMotor>& motors);

  std::size_t vehicle() const { return vehicle_; }
  /// Commands all thrusters.
  void command(Simulation& simulation, const ServoOutputs& outputs_us);

 private:
  std::size_t vehicle_;
  std::vector<ServoMotor> motors_;
  Actuators::Named commands_;
};

}  // namespace uwsim
