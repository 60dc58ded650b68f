#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/autopilots/servo_frame.h"

namespace uwsim {

struct ServoExchangeSpec {
  std::string host = "127.0.0.1";  ///< an IPv4 address of this machine
  std::uint16_t port = 9002;       ///< 0: any free port
  std::size_t vehicle = 0;
  std::vector<ServoMotor> motors;
  std::size_t imu = 0;                   ///< index of the sensor; mounted along the body axes
  std::optional<std::size_t> altimeter;  ///< index of the sensor
  bool with_noise = false;               ///< whether both sensors are read with their errors
  std::vector<std::size_t> watched;      ///< outputs of lights and camera mounts, see ServoRun::changed
};

/// Counts of what the exchange has received since it began.
struct ServoCounts {
  std::uint64_t frames = 0;    ///< frames that caused a step
  std::uint64_t lost = 0;      ///< frames missing between two that arrived
  std::uint64_t repeated = 0;  ///< frames that arrived again
  std::uint64_t resets = 0;    ///< autopilots that restarted
  std::uint64_t foreign = 0;   ///< packets that are not servo packets
  std::uint64_t cut = 0;       ///< servo packets with a wrong length
  std::uint64_t others = 0;    ///< frames from another autopilot
};

/// The frames that one call of ServoExchange::run received, one of each exchange for each step.
struct ServoRun {
  std::vector<std::vector<ServoOutputs>> outputs_us;  ///< of each exchange
  std::uint64_t steps = 0;
  bool changed = false;  ///< whether the last step's frames changed a watched output, or the first ones set it
};

/// The physics side of ArduPilot's JSON interface (libraries/SITL/SIM_JSON.cpp): an autopilot sends a servo packet by
/// UDP, and waits for a line of JSON with its vehicle's motion after one more step. Nothing else advances time.
///
/// The line contains, in the autopilot's frames (world north-east-down from the world's origin, body
/// forward-right-down): timestamp [s], imu.gyro [rad/s], imu.accel_body (specific force) [m/s2], position [m], velocity
/// [m/s], quaternion (w, x, y, z; body to world) and, with an altimeter, rng_1 [m]. The parser at the other end
/// searches for keys as text, so the line contains no spaces.
///
/// Unexpected frame numbers are counted. A gap counts as lost frames, and a smaller number as a reset. The same number
/// counts as a repeated frame, which causes no step and is answered with the last line. Another autopilot is ignored
/// until the present one has been silent for kSilence_s.
///
/// Several exchanges, each with its own autopilot and vehicle, may step one simulation: see `run`.
class ServoExchange {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr double kSilence_s = 1;
  /// A repeated frame is answered only if the last line was sent at least this long ago. Otherwise that line may still
  /// be in transit, and two lines for one frame would put the autopilot one frame ahead.
  static constexpr double kAnswerAgain_s = 0.5;

  /// Opens the socket. Throws InvalidValue for an invalid spec or address, FileError if the port is not available.
  ServoExchange(const Simulation& simulation, const ServoExchangeSpec& spec);
  ~ServoExchange();
  ServoExchange(const ServoExchange&) = delete;
  ServoExchange& operator=(const ServoExchange&) = delete;

  std::uint16_t port() const { return port_; }
  const ServoCounts& counts() const { return counts_; }
  /// The address and port of the autopilot; empty before its first frame.
  std::string peer() const;
  /// The rate that the autopilot's last frame announced.
  int rate_hz() const { return frame_.rate_hz; }

  /// True if a frame is in, which waits for the other exchanges' frames.
  bool has_frame() const { return is_in_; }
  /// Waits until a packet has arrived, at most `patience_s`; returns whether one has, or whether a frame is in.
  bool wait(double patience_s) const;

  /// Runs one step when a frame of each exchange is in, at most `steps`, and then answers them in order. Returns early
  /// after a frame that changed a watched output, or if a frame is missing for `patience_s`; frames that are in remain.
  /// `steers`: for each exchange, whether its frames command the thrusters. Throws InvalidValue if a vehicle's motion
  /// diverges.
  static ServoRun run(const std::vector<ServoExchange*>& exchanges, Simulation& simulation, std::uint64_t steps,
                      double patience_s, const std::vector<bool>& steers);

 private:
  enum class Received { kNothing, kFrame, kAgain };
  struct Peer {
    std::uint32_t address = 0;  // network byte order, as in sockaddr_in
    std::uint16_t port = 0;
    bool operator==(const Peer&) const = default;
  };

  bool receive_until(Clock::time_point end, bool may_stay_awake);
  Received receive();
  Received take(const ServoFrame& frame, const Peer& from);
  bool note_watched();
  void write_line(Simulation& simulation);
  void send_line();

  ServoExchangeSpec spec_;
  ServoMotors motors_;
  int socket_ = -1;
  std::uint16_t port_ = 0;
  Peer peer_;
  bool has_peer_ = false;
  bool is_in_ = false;  // whether frame_ waits for a step
  bool has_watched_ = false;
  int asleep_ = 0;  // how many frames to await asleep
  Clock::time_point heard_, answered_;
  ServoFrame frame_;
  ServoOutputs watched_us_{};
  double range_m_ = 0;  // the altimeter's last valid reading
  std::string line_;
  ServoCounts counts_;
};

}  // namespace uwsim
