#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "uwsim/autopilots/servo_exchange.h"
#include "uwsim/core/check.h"

namespace uwsim {
namespace {

/// Neutral blocks of 1 m with a thruster ahead and an exact IMU at their centre, in deep water.
Simulation blocks(int count = 1) {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) mesh.vertices_m.emplace_back((k & 1) - 0.5, (k >> 1 & 1) - 0.5, (k >> 2) - 0.5);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  CraftParameters p;
  p.mass_kg = 1000;
  p.inertia_kg_m2.diagonal().setConstant(167);
  VehicleSpec vehicle;
  vehicle.craft = std::make_shared<const Craft>(p, BuoyantHull(std::move(mesh)));
  vehicle.start_world_from_body.position_m = {3, 4, -5};
  vehicle.start_world_from_body.orientation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());  // heading north
  ThrusterParameters thruster;
  thruster.name = "ahead";
  thruster.curve = ThrustCurve({-1, 1}, {-1000, 1000});
  vehicle.actuators.thrusters = {thruster};
  SensorSpec imu;
  imu.name = imu.kind = "imu";
  vehicle.sensors = {imu};
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, -50.0F), 2, 2, 400.0, {-200, -200}));
  const auto scene = std::make_shared<const RayScene>(world);
  SimulationSpec spec;
  spec.step_s = 0.0025;
  Simulation simulation(world, scene, spec);
  for (int k = 0; k < count; ++k) {
    vehicle.name = "block " + std::to_string(k);
    vehicle.start_world_from_body.position_m.x() = 3 + 10 * k;
    simulation.add_vehicle(vehicle);
  }
  return simulation;
}

/// The autopilot's end of the exchange.
class Autopilot {
 public:
  explicit Autopilot(std::uint16_t port) : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(port);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) ADD_FAILURE() << "connect";
  }
  ~Autopilot() { close(socket_); }

  static std::vector<std::uint8_t> frame(std::uint32_t number, std::uint16_t ahead_us, std::size_t channels = 16) {
    std::vector<std::uint16_t> words = {static_cast<std::uint16_t>(channels == 16 ? 18458 : 29569), 400,
                                        static_cast<std::uint16_t>(number), static_cast<std::uint16_t>(number >> 16),
                                        ahead_us};
    words.resize(4 + channels, 1500);
    std::vector<std::uint8_t> bytes(2 * words.size());
    std::memcpy(bytes.data(), words.data(), bytes.size());
    return bytes;
  }
  void send(const std::vector<std::uint8_t>& bytes) const { ::send(socket_, bytes.data(), bytes.size(), 0); }
  /// Returns the next line, or nothing if none has arrived.
  std::string line() const {
    char text[2000];
    pollfd readable{socket_, POLLIN, 0};
    if (poll(&readable, 1, 0) <= 0) return {};
    return {text, static_cast<std::size_t>(recv(socket_, text, sizeof text, 0))};
  }

 private:
  int socket_;
};

/// The numbers after a key, found as the autopilot finds them.
std::vector<double> numbers(const std::string& line, const std::string& key, std::size_t count) {
  const std::size_t at = line.find("\"" + key + "\":");
  if (at == std::string::npos) return {};
  const char* text = line.c_str() + at + key.size() + 3;
  std::vector<double> found;
  for (std::size_t k = 0; k < count; ++k) {
    text += *text == '[' || *text == ',';
    char* end = nullptr;
    found.push_back(std::strtod(text, &end));
    text = end;
  }
  return found;
}

class ServoExchangeTest : public ::testing::Test {
 protected:
  ServoExchangeTest() : exchange_(simulation_, spec()), autopilot_(exchange_.port()) {}
  static ServoExchangeSpec spec() {
    ServoExchangeSpec spec;
    spec.port = 0;
    spec.motors = {{0, "ahead", -1}};
    spec.watched = {9};
    return spec;
  }
  std::size_t run(std::uint64_t steps = 10) {
    return ServoExchange::run({&exchange_}, simulation_, steps, 0.0, {true}).steps;
  }

  Simulation simulation_ = blocks();
  ServoExchange exchange_;
  Autopilot autopilot_;
};

TEST_F(ServoExchangeTest, EachFrameMakesOneStepAndGetsOneLine) {
  run();
  EXPECT_EQ(simulation_.tick(), 0U);
  for (std::uint32_t k = 0; k < 3; ++k) {
    autopilot_.send(Autopilot::frame(k, 1500));
    run();
    EXPECT_EQ(simulation_.tick(), k + 1);
    EXPECT_NE(autopilot_.line(), "");
  }
  EXPECT_EQ(autopilot_.line(), "");
}

TEST_F(ServoExchangeTest, TheLineIsInTheAutopilotsFrames) {
  BodyState state = simulation_.state(0);
  state.velocity_body << 1, 0.5, 0, 0.1, 0.2, 0.3;
  simulation_.set_state(0, state);
  autopilot_.send(Autopilot::frame(0, 1500));
  run();
  const std::string line = autopilot_.line();
  EXPECT_EQ(line.front(), '\n');
  EXPECT_EQ(line.back(), '\n');
  EXPECT_EQ(line.find(' '), std::string::npos);
  const std::vector<double> position = numbers(line, "position", 3), velocity = numbers(line, "velocity", 3),
                            q = numbers(line, "quaternion", 4), rate = numbers(line, "gyro", 3),
                            force = numbers(line, "accel_body", 3);
  EXPECT_NEAR(position[0], 4, 0.01);  // north, which is ahead
  EXPECT_NEAR(position[1], 3, 0.01);
  EXPECT_NEAR(position[2], 5, 0.01);
  EXPECT_NEAR(velocity[0], 1, 0.02);
  EXPECT_NEAR(velocity[1], -0.5, 0.02);  // to the left is west
  EXPECT_NEAR(std::abs(q[0]), 1, 1e-5);
  EXPECT_NEAR(rate[0], 0.1, 1e-3);
  EXPECT_NEAR(rate[1], -0.2, 1e-3);
  EXPECT_NEAR(rate[2], -0.3, 1e-3);
  EXPECT_NEAR(force[2], -9.8, 0.2);
}

TEST_F(ServoExchangeTest, MicrosecondsOfTimeAreNeitherLostNorGained) {
  long total_us = 0;
  double last_s = 0;
  for (std::uint32_t k = 0; k < 20000; ++k) {
    autopilot_.send(Autopilot::frame(k, 1500));
    run();
    const double time_s = numbers(autopilot_.line(), "timestamp", 1).front();
    total_us += static_cast<long>((time_s - last_s) * 1e6);
    last_s = time_s;
  }
  EXPECT_EQ(total_us, 20000 * 2500);
}

TEST_F(ServoExchangeTest, PulsesCommandThrusters) {
  const auto command = [&](std::uint32_t number, std::uint16_t pulse_us) {
    autopilot_.send(Autopilot::frame(number, pulse_us, 32));
    run();
    return simulation_.actuators(0).thrusters().front().command();
  };
  EXPECT_EQ(command(0, 1900), -1);  // its direction is -1
  EXPECT_EQ(command(1, 1400), 0.25);
  EXPECT_EQ(command(2, 0), 0);
  EXPECT_EQ(command(3, 65535), -1);
}

TEST_F(ServoExchangeTest, LostRepeatedAndResetFramesAreCountedByTheirNumber) {
  for (const std::uint32_t number : {5U, 6U, 9U, 9U, 0U, 1U}) {
    autopilot_.send(Autopilot::frame(number, 1500));
    run();
  }
  EXPECT_EQ(simulation_.tick(), 5U);
  EXPECT_EQ(exchange_.counts().lost, 2U);
  EXPECT_EQ(exchange_.counts().repeated, 1U);
  EXPECT_EQ(exchange_.counts().resets, 1U);
}

TEST_F(ServoExchangeTest, ARepeatedFrameGetsTheLastLineAgainButOnlyLater) {
  autopilot_.send(Autopilot::frame(0, 1500));
  run();
  const std::string line = autopilot_.line();
  autopilot_.send(Autopilot::frame(0, 1500));
  run();
  EXPECT_EQ(autopilot_.line(), "");  // the line may still be on its way
  std::this_thread::sleep_for(std::chrono::duration<double>(ServoExchange::kAnswerAgain_s + 0.05));
  autopilot_.send(Autopilot::frame(0, 1500));
  run();
  EXPECT_EQ(autopilot_.line(), line);
  EXPECT_EQ(simulation_.tick(), 1U);
}

TEST_F(ServoExchangeTest, ForeignCutAndSecondAutopilotsPacketsMakeNoStep) {
  autopilot_.send(Autopilot::frame(0, 1500));
  run();
  autopilot_.send({1, 2, 3});
  std::vector<std::uint8_t> cut = Autopilot::frame(1, 1500);
  cut.pop_back();
  autopilot_.send(cut);
  cut.resize(500);
  autopilot_.send(cut);
  const Autopilot other(exchange_.port());
  other.send(Autopilot::frame(7, 1100));
  run();
  EXPECT_EQ(simulation_.tick(), 1U);
  EXPECT_EQ(exchange_.counts().foreign, 1U);
  EXPECT_EQ(exchange_.counts().cut, 2U);
  EXPECT_EQ(exchange_.counts().others, 1U);
  EXPECT_EQ(other.line(), "");
}

TEST_F(ServoExchangeTest, ARunEndsAfterAChangeOfAWatchedOutput) {
  for (std::uint32_t k = 0; k < 4; ++k) {
    std::vector<std::uint8_t> frame = Autopilot::frame(k, 1500);
    if (k == 2) frame[8 + 2 * 9] ^= 1U;
    autopilot_.send(frame);
  }
  EXPECT_EQ(run(), 1U);  // the first frame sets it
  EXPECT_EQ(run(), 2U);
  EXPECT_EQ(run(), 1U);
}

TEST_F(ServoExchangeTest, AStepNeedsAFrameOfEachExchange) {
  Simulation simulation = blocks(2);
  ServoExchangeSpec second = spec();
  second.vehicle = 1;
  second.motors.front().direction = 1;
  ServoExchange first(simulation, spec()), other(simulation, second);
  const Autopilot one(first.port()), two(other.port());
  const auto run = [&] { return ServoExchange::run({&first, &other}, simulation, 10, 0.0, {true, true}); };
  one.send(Autopilot::frame(0, 1900));
  run();
  one.send(Autopilot::frame(0, 1900));  // again, since the other is late
  run();
  EXPECT_TRUE(first.has_frame() && !other.has_frame());
  EXPECT_EQ(simulation.tick(), 0U);
  EXPECT_EQ(one.line(), "");
  two.send(Autopilot::frame(4, 1700));
  const ServoRun made = run();
  EXPECT_EQ(simulation.tick(), 1U);
  EXPECT_EQ(made.outputs_us[0].front()[0], 1900);
  EXPECT_EQ(made.outputs_us[1].front()[0], 1700);
  EXPECT_EQ(simulation.actuators(0).thrusters().front().command(), -1);
  EXPECT_EQ(simulation.actuators(1).thrusters().front().command(), 0.5);
  EXPECT_NEAR(numbers(one.line(), "position", 3)[1], 3, 0.01);
  EXPECT_NEAR(numbers(two.line(), "position", 3)[1], 13, 0.01);
  EXPECT_EQ(one.line(), "");
  run();
  EXPECT_EQ(simulation.tick(), 1U);  // the repeated frame makes none
}

TEST_F(ServoExchangeTest, ATakenPortIsAnError) {
  ServoExchangeSpec taken = spec();
  taken.port = exchange_.port();
  EXPECT_THROW(ServoExchange(simulation_, taken), FileError);
  taken.host = "here";
  EXPECT_THROW(ServoExchange(simulation_, taken), InvalidValue);
}

}  // namespace
}  // namespace uwsim
