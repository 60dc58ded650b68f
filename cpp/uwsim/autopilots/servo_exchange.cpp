#include "uwsim/autopilots/servo_exchange.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <string_view>
#include <system_error>
#include <thread>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr int kPacketsAtOnce = 1000;  // so that a flood of packets does not keep a call from returning
// A frame usually follows its line within this time, and falling asleep for it and waking up would take about as long.
constexpr std::chrono::microseconds kAwake{100};
// After a frame that took longer, as on a busy machine, this number of frames are awaited asleep.
constexpr int kAsleep = 50;
// The autopilot truncates each difference of two timestamps to whole microseconds. Without this factor, it would often
// truncate 2.4999999 ms to 2.499 ms.
constexpr double kStretch = 1 + 4e-8;
constexpr double kBeyondRange_m = 9999;
// The autopilot multiplies the rangefinder's distance by the cosine of the tilt or this value, whichever is larger.
constexpr double kTiltCosineMin = 0.707;

void append(std::string& text, double value) {
  char digits[32];
  text.append(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

void append(std::string& text, std::string_view key, std::initializer_list<double> values) {
  text += key;
  char separator = '[';
  for (const double value : values) {
    text += separator;
    append(text, value);
    separator = ',';
  }
  text += ']';
}

/// Converts a vector from ENU to north-east-down axes (as_ned), or from body axes forward-left-up to forward-right-down
/// (as_frd).
Eigen::Vector3d as_ned(const Eigen::Vector3d& enu) { return {enu.y(), enu.x(), -enu.z()}; }
Eigen::Vector3d as_frd(const Eigen::Vector3d& flu) { return {flu.x(), -flu.y(), -flu.z()}; }

/// Body forward-right-down to north-east-down; w is not negative.
Eigen::Quaterniond ned_from_frd(const Eigen::Quaterniond& enu_from_flu) {
  static const Eigen::Quaterniond ned_from_enu(0, std::sqrt(0.5), std::sqrt(0.5), 0), flu_from_frd(0, 1, 0, 0);
  Eigen::Quaterniond q = (ned_from_enu * enu_from_flu * flu_from_frd).normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return q;
}

sockaddr_in address_of(std::uint32_t address, std::uint16_t port) {
  sockaddr_in made{};
  made.sin_family = AF_INET;
  made.sin_addr.s_addr = address;
  made.sin_port = port;
  return made;
}

double seconds(std::chrono::steady_clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

ServoExchange::ServoExchange(const Simulation& simulation, const ServoExchangeSpec& spec)
    : spec_(spec), motors_(simulation, spec.vehicle, spec.motors) {
  const SensorRack& rack = simulation.vehicle(spec.vehicle).sensors;
  require(spec.imu < rack.size() && rack.at(spec.imu).kind().name == "imu", "imu", spec.imu, "must be an IMU");
  const SensorSpec& imu = rack.at(spec.imu).spec();
  require(imu.body_from_sensor.orientation.isApprox(Eigen::Quaterniond::Identity(), 1e-9), "sensors." + imu.name,
          imu.body_from_sensor.orientation.coeffs().transpose(), "must be mounted along the body axes");
  require(!spec.altimeter || (*spec.altimeter < rack.size() && rack.at(*spec.altimeter).kind().name == "altitude"),
          "altimeter", spec.altimeter.value_or(0), "must be an altimeter");
  for (const std::size_t output : spec.watched) {
    require(output < ServoOutputs{}.size(), "watched", output, "must be in [0, 31]");
  }
  in_addr host{};
  require(inet_pton(AF_INET, spec.host.c_str(), &host) == 1, "host", spec.host, "must be an IPv4 address");
  socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_in own = address_of(host.s_addr, htons(spec.port));
  socklen_t length = sizeof own;
  if (socket_ < 0 || bind(socket_, reinterpret_cast<const sockaddr*>(&own), length) != 0 ||
      getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &length) != 0) {
    const std::string why = std::generic_category().message(errno);
    if (socket_ >= 0) close(socket_);
    throw FileError("UDP " + spec.host + ":" + std::to_string(spec.port) + ": " + why);
  }
  port_ = ntohs(own.sin_port);
  line_.reserve(1024);
}

ServoExchange::~ServoExchange() { close(socket_); }

std::string ServoExchange::peer() const {
  if (!has_peer_) return {};
  char text[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &peer_.address, text, sizeof text);
  return std::string(text) + ":" + std::to_string(ntohs(peer_.port));
}

bool ServoExchange::wait(double patience_s) const {
  pollfd readable{socket_, POLLIN, 0};
  return is_in_ || poll(&readable, 1, static_cast<int>(std::ceil(1e3 * patience_s))) > 0;
}

ServoRun ServoExchange::run(const std::vector<ServoExchange*>& exchanges, Simulation& simulation, std::uint64_t steps,
                            double patience_s, const std::vector<bool>& steers) {
  require(!exchanges.empty() && exchanges.size() == steers.size(), "steers", steers.size(), "must be as many");
  const auto patience = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(patience_s));
  // Awake, this thread takes a core, which another autopilot may need.
  const bool may_stay_awake = exchanges.size() < std::thread::hardware_concurrency();
  ServoRun made;
  made.outputs_us.resize(exchanges.size());
  for (Clock::time_point since = Clock::now(); made.steps < steps && !made.changed; since = Clock::now()) {
    for (ServoExchange* exchange : exchanges) {
      if (!exchange->receive_until(since + patience, may_stay_awake)) return made;
    }
    for (std::size_t k = 0; k < exchanges.size(); ++k) {
      exchanges[k]->is_in_ = false;
      if (steers[k]) exchanges[k]->motors_.command(simulation, exchanges[k]->frame_.outputs_us);
    }
    simulation.step();
    ++made.steps;
    for (std::size_t k = 0; k < exchanges.size(); ++k) {
      ServoExchange& exchange = *exchanges[k];
      exchange.write_line(simulation);
      exchange.send_line();
      ++exchange.counts_.frames;
      made.outputs_us[k].push_back(exchange.frame_.outputs_us);
      made.changed |= exchange.note_watched();
    }
  }
  return made;
}

/// Returns whether a frame is in, after waiting for it: awake at first, unless that was in vain lately.
bool ServoExchange::receive_until(Clock::time_point end, bool may_stay_awake) {
  const bool is_awake = may_stay_awake && asleep_ == 0;
  const Clock::time_point awake = is_awake ? std::min(end, Clock::now() + kAwake) : Clock::time_point::min();
  while (!is_in_) {
    const Received received = receive();
    is_in_ = received == Received::kFrame;
    if (received == Received::kAgain) send_line();
    if (received != Received::kNothing) continue;
    const Clock::time_point now = Clock::now();
    if (now >= end) return false;
    if (now < awake) continue;
    asleep_ = asleep_ > 0 ? asleep_ - 1 : kAsleep;
    wait(seconds(end - now));
  }
  return true;
}

/// Returns whether the frame changed a watched output, or is the first.
bool ServoExchange::note_watched() {
  bool changed = false;
  for (const std::size_t output : spec_.watched) {
    changed |= !has_watched_ || watched_us_[output] != frame_.outputs_us[output];
    watched_us_[output] = frame_.outputs_us[output];
  }
  has_watched_ = true;
  return changed;
}

/// Reads packets until one of them must be answered. Copies of that frame that are waiting behind it arrive too soon
/// after the answer to be answered again.
ServoExchange::Received ServoExchange::receive() {
  std::uint8_t packet[128];  // longer than a frame: a longer packet is cut, and its length remains wrong
  for (int k = 0; k < kPacketsAtOnce; ++k) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size = recvfrom(socket_, packet, sizeof packet, 0, reinterpret_cast<sockaddr*>(&from), &length);
    if (size < 0) break;
    ServoFrame frame;
    const Packet kind = decode({packet, static_cast<std::size_t>(size)}, frame);
    counts_.foreign += kind == Packet::kForeign;
    counts_.cut += kind == Packet::kShort;
    if (kind != Packet::kFrame) continue;
    const Received received = take(frame, {from.sin_addr.s_addr, from.sin_port});
    if (received != Received::kNothing) return received;
  }
  return Received::kNothing;
}

ServoExchange::Received ServoExchange::take(const ServoFrame& frame, const Peer& from) {
  const Clock::time_point now = Clock::now();
  if (has_peer_ && from != peer_) {
    if (seconds(now - heard_) < kSilence_s) {
      ++counts_.others;
      return Received::kNothing;
    }
    ++counts_.resets;
  } else if (has_peer_) {
    const auto ahead = static_cast<std::int32_t>(frame.number - frame_.number);  // the counter may wrap
    if (ahead == 0) {
      heard_ = now;
      ++counts_.repeated;
      return seconds(now - answered_) < kAnswerAgain_s ? Received::kNothing : Received::kAgain;
    }
    if (ahead < 0) {
      ++counts_.resets;
    } else {
      counts_.lost += static_cast<std::uint64_t>(ahead - 1);
    }
  }
  peer_ = from;
  has_peer_ = true;
  heard_ = now;
  frame_ = frame;
  return Received::kFrame;
}

void ServoExchange::write_line(Simulation& simulation) {
  const BodyState& state = simulation.state(spec_.vehicle);
  const Eigen::Quaterniond& attitude = state.world_from_body.orientation;
  const std::vector<double>& measured =
      simulation.read_sensor(spec_.vehicle, spec_.imu, spec_.with_noise).values;  // rate, force, orientation
  const Eigen::Vector3d rate = as_frd(Eigen::Vector3d::Map(measured.data()));
  const Eigen::Vector3d force = as_frd(Eigen::Vector3d::Map(measured.data() + 3));
  const Eigen::Vector3d position = as_ned(state.world_from_body.position_m);
  const Eigen::Vector3d velocity = as_ned(attitude * state.linear_body_m_s());
  const Eigen::Quaterniond q = ned_from_frd(attitude);
  require(
      rate.allFinite() && force.allFinite() && position.allFinite() && velocity.allFinite() && q.coeffs().allFinite(),
      "vehicle '" + simulation.vehicle(spec_.vehicle).name + "'", position.transpose(), "its motion must be finite");
  char time[48];
  const auto end =
      std::to_chars(std::begin(time), std::end(time), simulation.time_s() * kStretch, std::chars_format::fixed, 12);
  line_.assign("\n{\"timestamp\":").append(time, end.ptr);
  append(line_, ",\"imu\":{\"gyro\":", {rate.x(), rate.y(), rate.z()});
  append(line_, ",\"accel_body\":", {force.x(), force.y(), force.z()});
  append(line_, "},\"position\":", {position.x(), position.y(), position.z()});
  append(line_, ",\"velocity\":", {velocity.x(), velocity.y(), velocity.z()});
  append(line_, ",\"quaternion\":", {q.w(), q.x(), q.y(), q.z()});
  if (spec_.altimeter) {
    const Sample& altitude = simulation.read_sensor(spec_.vehicle, *spec_.altimeter, spec_.with_noise);
    const double above_m = altitude.values.front();
    if (std::isinf(above_m)) {
      range_m_ = kBeyondRange_m;
    } else if (altitude.valid) {  // after a lost echo, the last reading remains
      range_m_ = above_m / std::max((attitude * Eigen::Vector3d::UnitZ()).z(), kTiltCosineMin);
    }
    line_ += ",\"rng_1\":";
    append(line_, range_m_);
  }
  line_ += ",\"no_time_sync\":1}\n";  // this side sets the pace
}

void ServoExchange::send_line() {
  const sockaddr_in to = address_of(peer_.address, peer_.port);
  // A line that cannot be sent is lost, like any packet: the autopilot repeats its frame.
  [[maybe_unused]] const ssize_t sent =
      sendto(socket_, line_.data(), line_.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  answered_ = heard_ = Clock::now();  // while its frame waited for others, it was not read
}

}  // namespace uwsim
