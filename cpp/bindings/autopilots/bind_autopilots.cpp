#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings/binders.h"
#include "bindings/sim/owned_simulation.h"
#include "uwsim/autopilots/servo_exchange.h"

namespace uwsim::bindings {
namespace {

constexpr double kBriefly_s = 0.002;  // how long a call keeps the simulation to itself while no frame arrives

using Exchanges = std::vector<ServoExchange*>;

py::bytes as_bytes(const std::vector<ServoOutputs>& frames) {
  return {reinterpret_cast<const char*>(frames.data()), frames.size() * sizeof(ServoOutputs)};
}

py::typing::Tuple<std::vector<py::bytes>, bool> run(const Exchanges& exchanges, OwnedSimulation& owned,
                                                    std::uint64_t steps, double patience_s,
                                                    const std::vector<bool>& steers) {
  using Clock = ServoExchange::Clock;
  ServoRun all;
  all.outputs_us.resize(exchanges.size());
  Clock::time_point since = Clock::now();
  for (double left_s = patience_s;;) {
    const ServoRun part = owned.with([&](Simulation& sim) {
      return ServoExchange::run(exchanges, sim, steps - all.steps, std::min(kBriefly_s, patience_s), steers);
    });
    all.changed = part.changed;
    all.steps += part.steps;
    for (std::size_t k = 0; k < exchanges.size(); ++k) {
      all.outputs_us[k].insert(all.outputs_us[k].end(), part.outputs_us[k].begin(), part.outputs_us[k].end());
    }
    if (all.steps == steps || all.changed) break;
    const GilReleased unlocked;  // meanwhile, other threads may use the simulation
    if (part.steps > 0) since = Clock::now();
    left_s = patience_s - std::chrono::duration<double>(Clock::now() - since).count();
    if (left_s <= 0) break;
    for (const ServoExchange* exchange : exchanges) {
      if (!exchange->wait(left_s)) break;
    }
  }
  std::vector<py::bytes> frames;
  for (const std::vector<ServoOutputs>& each : all.outputs_us) frames.push_back(as_bytes(each));
  return py::make_tuple(frames, all.changed);
}

void play(OwnedSimulation& owned, const std::vector<std::pair<std::size_t, std::vector<ServoMotor>>>& vehicles,
          const std::vector<py::bytes>& frames, const std::vector<bool>& steers) {
  require(vehicles.size() == frames.size() && vehicles.size() == steers.size(), "frames", frames.size(),
          "must be as many as vehicles");
  const std::vector<std::string_view> bytes(frames.begin(), frames.end());
  for (const std::string_view each : bytes) {
    require(each.size() % sizeof(ServoOutputs) == 0 && each.size() == bytes.front().size(), "frames", each.size(),
            "must be a multiple of 64 bytes, the same for each vehicle");
  }
  owned.with([&](Simulation& sim) {
    std::vector<ServoMotors> mixers;
    for (const auto& [index, motors] : vehicles) mixers.emplace_back(sim, index, motors);
    for (std::size_t at = 0; !bytes.empty() && at < bytes.front().size(); at += sizeof(ServoOutputs)) {
      for (std::size_t k = 0; k < mixers.size(); ++k) {
        ServoOutputs outputs_us;
        std::memcpy(outputs_us.data(), bytes[k].data() + at, sizeof outputs_us);
        if (steers[k]) mixers[k].command(sim, outputs_us);
      }
      sim.step();
    }
  });
}

}  // namespace

void bind_autopilots(py::module_& m) {
  py::class_<ServoMotor>(m, "ServoMotor", "A motor of an autopilot's frame: the servo output that drives a thruster.")
      .def(py::init([](std::size_t output, std::string thruster, double direction) {
             return ServoMotor{output, std::move(thruster), direction};
           }),
           py::arg("output"), py::arg("thruster"), py::arg("direction"),
           "output: index, from 0. direction: 1 or -1, the sign of the thruster's command at a pulse above 1500 us.")
      .def_readonly("output", &ServoMotor::output)
      .def_readonly("thruster", &ServoMotor::thruster)
      .def_readonly("direction", &ServoMotor::direction);

  py::class_<ServoCounts>(m, "ServoCounts", "Counts of the packets that a ServoExchange has received since it began.")
      .def_readonly("frames", &ServoCounts::frames, "Frames that made a step.")
      .def_readonly("lost", &ServoCounts::lost, "Frames missing between two that arrived.")
      .def_readonly("repeated", &ServoCounts::repeated, "Frames that arrived again, without a step.")
      .def_readonly("resets", &ServoCounts::resets, "Autopilots that started again.")
      .def_readonly("foreign", &ServoCounts::foreign, "Packets that are not servo packets.")
      .def_readonly("cut", &ServoCounts::cut, "Servo packets of a wrong length.")
      .def_readonly("others", &ServoCounts::others, "Frames of another autopilot, which are ignored.");

  py::class_<ServoExchange>(
      m, "ServoExchange",
      "The physics side of ArduPilot's JSON interface: UDP, one frame of the autopilot for each step.")
      .def(py::init([](OwnedSimulation& owned, std::size_t vehicle, std::vector<ServoMotor> motors, std::size_t imu,
                       std::optional<std::size_t> altimeter, bool with_noise, std::vector<std::size_t> watched,
                       std::string host, std::uint16_t port) {
             const ServoExchangeSpec spec{std::move(host), port,       vehicle,           std::move(motors), imu,
                                          altimeter,       with_noise, std::move(watched)};
             return owned.with([&](Simulation& sim) { return std::make_unique<ServoExchange>(sim, spec); });
           }),
           py::arg("simulation"), py::arg("vehicle"), py::arg("motors"), py::arg("imu"), py::arg("altimeter"),
           py::arg("with_noise"), py::arg("watched"), py::arg("host"), py::arg("port"),
           "imu, altimeter: indices of sensors, which are read with their errors if with_noise. watched: outputs\n"
           "whose change ends a run. port: 0 for any free port. Raises ValueError, or OSError if the port is not\n"
           "available.")
      .def(
          "wait",
          [](const ServoExchange& exchange, double patience_s) {
            const GilReleased unlocked;
            return exchange.wait(patience_s);
          },
          py::arg("patience_s"),
          "Wait until a packet has arrived, and return whether one has. From then until the next step, an autopilot\n"
          "in lockstep is waiting, too, so data that other sockets deliver to it do not depend on the wall clock.")
      .def_property_readonly("has_frame", &ServoExchange::has_frame,
                             "True if a frame is in, which waits for those of other exchanges.")
      .def_property_readonly("port", &ServoExchange::port)
      .def_property_readonly("peer", &ServoExchange::peer,
                             "The autopilot's address and port; empty before its first frame.")
      .def_property_readonly("rate_hz", &ServoExchange::rate_hz, "The rate that the last frame announced.")
      .def_property_readonly("counts", [](const ServoExchange& e) { return e.counts(); });

  m.def("run_servo_exchanges", &run, py::arg("exchanges"), py::arg("simulation"), py::arg("steps"),
        py::arg("patience_s"), py::arg("steers"),
        "Make one step when a frame of each exchange is in, at most `steps`. Return each exchange's outputs as bytes,\n"
        "32 uint16 [us] per step, and whether a watched output changed, which ends the call. The call also ends if a\n"
        "frame is missing for patience_s; those that are in remain. steers: for each exchange, whether its frames\n"
        "command the thrusters. Releases the GIL. Raises ValueError.");
  m.def("play_servo_frames", &play, py::arg("simulation"), py::arg("vehicles"), py::arg("frames"), py::arg("steers"),
        "Make one step for each frame, as run_servo_exchanges does. vehicles: index and motors of each. frames: bytes\n"
        "for each vehicle, 32 uint16 [us] per step. Releases the GIL. Raises ValueError.");
}

}  // namespace uwsim::bindings
