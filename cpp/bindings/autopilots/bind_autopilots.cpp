#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "bindings/binders.h"
#include "bindings/sim/owned_simulation.h"
#include "uwsim/autopilots/servo_exchange.h"

namespace uwsim::bindings {
namespace {

constexpr double kBriefly_s = 0.002;  // how long a call keeps the simulation to itself while no frame arrives

py::bytes as_bytes(const std::vector<ServoOutputs>& frames) {
  return {reinterpret_cast<const char*>(frames.data()), frames.size() * sizeof(ServoOutputs)};
}

py::typing::Tuple<py::bytes, bool> run(ServoExchange& exchange, OwnedSimulation& owned, std::uint64_t steps,
                                       double patience_s, bool steers) {
  ServoRun all;
  while (all.outputs_us.size() < steps && !all.changed) {
    ServoRun part = owned.with([&](Simulation& sim) {
      return exchange.run(sim, steps - all.outputs_us.size(), std::min(kBriefly_s, patience_s), steers);
    });
    all.changed = part.changed;
    all.outputs_us.insert(all.outputs_us.end(), part.outputs_us.begin(), part.outputs_us.end());
    if (all.outputs_us.size() == steps || all.changed) break;
    const GilReleased unlocked;  // meanwhile, other threads may use the simulation
    if (!exchange.wait(patience_s)) break;
  }
  return py::make_tuple(as_bytes(all.outputs_us), all.changed);
}

void play(OwnedSimulation& owned, std::size_t vehicle, const std::vector<ServoMotor>& motors, const py::bytes& frames,
          bool steers) {
  const std::string_view bytes = frames;
  require(bytes.size() % sizeof(ServoOutputs) == 0, "frames", bytes.size(), "must be a multiple of 64 bytes");
  owned.with([&](Simulation& sim) {
    ServoMotors mixer(sim, vehicle, motors);
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(ServoOutputs)) {
      ServoOutputs outputs_us;
      std::memcpy(outputs_us.data(), bytes.data() + at, sizeof outputs_us);
      if (steers) mixer.command(sim, outputs_us);
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
      .def("run", &run, py::arg("simulation"), py::arg("steps"), py::arg("patience_s"), py::arg("steers"),
           "Make one step for each frame that arrives, at most `steps`. Return the frames' outputs as bytes, 32\n"
           "uint16 [us] per frame, and whether a watched output changed, which ends the call. The call also ends if\n"
           "no frame arrives for patience_s. steers: whether frames command the thrusters. Releases the GIL. Raises\n"
           "ValueError.")
      .def(
          "wait",
          [](const ServoExchange& exchange, double patience_s) {
            const GilReleased unlocked;
            return exchange.wait(patience_s);
          },
          py::arg("patience_s"),
          "Wait until a packet has arrived, and return whether one has. From then until the next step, an autopilot\n"
          "in lockstep is waiting, too, so data that other sockets deliver to it do not depend on the wall clock.")
      .def_property_readonly("port", &ServoExchange::port)
      .def_property_readonly("peer", &ServoExchange::peer,
                             "The autopilot's address and port; empty before its first frame.")
      .def_property_readonly("rate_hz", &ServoExchange::rate_hz, "The rate that the last frame announced.")
      .def_property_readonly("counts", [](const ServoExchange& e) { return e.counts(); });

  m.def("play_servo_frames", &play, py::arg("simulation"), py::arg("vehicle"), py::arg("motors"), py::arg("frames"),
        py::arg("steers"),
        "Make one step for each frame, as ServoExchange.run does. frames: bytes, 32 uint16 [us] per frame. Releases\n"
        "the GIL. Raises ValueError.");
}

}  // namespace uwsim::bindings
