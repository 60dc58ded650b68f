#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/sensors/sensor_reading.h"
#include "bindings/sim/binders.h"
#include "bindings/sim/owned_simulation.h"

namespace uwsim::bindings {
namespace {

SensorReading read_sensor(OwnedSimulation& owned, std::size_t vehicle, std::size_t sensor, bool with_noise) {
  Sample sample;
  const SensorKind* kind = nullptr;
  owned.with_briefly([&](Simulation& sim) {
    sample = sim.read_sensor(vehicle, sensor, with_noise);
    kind = &sim.vehicle(vehicle).sensors.at(sensor).kind();
  });
  return sensor_reading(*kind, sample);
}

using TakenSamples =
    py::typing::Tuple<py::array_t<std::uint64_t>, py::array_t<std::uint64_t>, py::array_t<double>, py::array_t<bool>>;

TakenSamples moved_out(SampleBatch&& batch, std::size_t width) {
  const auto n = static_cast<py::ssize_t>(batch.stamps_ns.size());
  const py::array_t<bool> valid(n, reinterpret_cast<const bool*>(batch.valid.data()));
  return py::make_tuple(move_out(std::move(batch.stamps_ns)), move_out(std::move(batch.arrivals_ns)),
                        move_out(std::move(batch.values), {n, static_cast<py::ssize_t>(width)}), valid);
}

TakenSamples take_samples(OwnedSimulation& owned, std::size_t vehicle, std::size_t sensor) {
  SampleBatch batch;
  std::size_t width = 0;
  owned.with([&](Simulation& sim) {
    batch = sim.take_samples(vehicle, sensor);
    width = sim.vehicle(vehicle).sensors.at(sensor).kind().reading_width();
  });
  return moved_out(std::move(batch), width);
}

TakenSamples take_rows(OwnedSimulation& owned, Tape& tape, std::size_t track) {
  SampleBatch rows = owned.with([&](Simulation&) { return tape.take(track); });
  const std::size_t width = rows.valid.empty() ? 0 : rows.values.size() / rows.valid.size();
  return moved_out(std::move(rows), width);
}

void bind_specs(py::module_& m) {
  py::enum_<EngineKind>(m, "DynamicsEngine").value("UWSIM", EngineKind::kUwsim).value("BULLET", EngineKind::kBullet);

  py::class_<SimulationSpec>(m, "SimulationSpec")
      .def(py::init<>())
      .def_readwrite("step_s", &SimulationSpec::step_s)
      .def_readwrite("seed", &SimulationSpec::seed)
      .def_readwrite("mission_time_s", &SimulationSpec::mission_time_s)
      .def_readwrite("station_world_m", &SimulationSpec::station_world_m)
      .def_readwrite("range_warning_m", &SimulationSpec::range_warning_m)
      .def_readwrite("proximity_warning_m", &SimulationSpec::proximity_warning_m)
      .def_readwrite("engine", &SimulationSpec::engine)
      .def(
          "set_wind",
          [](SimulationSpec& spec, double speed_m_s, double heading_rad, const py::object& gusts) {
            spec.wind.speed_m_s = speed_m_s;
            spec.wind.direction = {std::cos(heading_rad), std::sin(heading_rad), 0};
            spec.wind.gusts.clear();
            const auto rows = as_array<double>(gusts, "gusts", {-1, 3});
            for (py::ssize_t k = 0; k < rows.shape(0); ++k)
              spec.wind.gusts.push_back({rows.at(k, 0), rows.at(k, 1), rows.at(k, 2)});
          },
          py::arg("speed_m_s"), py::arg("heading_rad"), py::arg("gusts"),
          "Set the wind 10 m above the water, and where it blows. gusts: (n, 3), amplitude [m/s], angular frequency\n"
          "[rad/s] and phase [rad] of each harmonic.")
      .def(
          "carry_station",
          [](SimulationSpec& spec, std::size_t vehicle, const py::object& position_body_m, const py::object& docked_m,
             const py::object& docked_xyzw) {
            spec.carried_station = CarriedStation{vehicle, as_vector3(position_body_m, "position_body_m"),
                                                  as_pose(docked_m, docked_xyzw, "docked")};
          },
          py::arg("vehicle"), py::arg("position_body_m"), py::arg("docked_m"), py::arg("docked_xyzw"),
          "Let the station ride on a vehicle, in whose frame its position (3,) and the pose of what is docked are.");

  py::class_<SonarSpec>(m, "SonarSpec")
      .def(py::init([](std::string name, const MultibeamModel& model, const py::object& position_m,
                       const py::object& orientation_xyzw, double elevation_rad,
                       const std::optional<AcousticSpec>& acoustics, std::vector<double> strengths_db, bool on) {
             return SonarSpec{std::move(name),
                              model,
                              as_pose(position_m, orientation_xyzw, "sonar"),
                              elevation_rad,
                              acoustics,
                              std::move(strengths_db),
                              on};
           }),
           py::arg("name"), py::arg("model"), py::arg("position_m"), py::arg("orientation_xyzw"),
           py::arg("elevation_rad") = 0.0, py::arg("acoustics") = py::none(),
           py::arg("strengths_db") = std::vector<double>{}, py::arg("on") = true,
           "acoustics: selects physics mode; if None, geometry mode. strengths_db: backscatter at normal incidence\n"
           "by label, for geometry mode; further labels are rock. on: if False, the sonar tilts but receives\n"
           "nothing.")
      .def_readonly("name", &SonarSpec::name)
      .def_readonly("model", &SonarSpec::model);

  py::enum_<CollisionShape>(m, "CollisionShape")
      .value("HULL", CollisionShape::kHull)
      .value("BOX", CollisionShape::kBox)
      .value("PIECES", CollisionShape::kPieces);

  bind_arm_link(m);
  bind_object_spec(m);
  bind_tether_spec(m);
  py::class_<VehicleSpec, std::shared_ptr<VehicleSpec>>(m, "VehicleSpec")
      .def(py::init<>())
      .def_readwrite("name", &VehicleSpec::name)
      .def_property(
          "craft", [](const VehicleSpec& v) { return std::const_pointer_cast<Craft>(v.craft); },
          [](VehicleSpec& v, std::shared_ptr<Craft> craft) { v.craft = std::move(craft); })
      .def_readwrite("actuators", &VehicleSpec::actuators)
      .def_readwrite("shape", &VehicleSpec::shape)
      .def(
          "set_collision_pieces",
          [](VehicleSpec& v, const std::vector<py::array>& pieces_body_m) {
            v.shape = CollisionShape::kPieces;
            v.collision_pieces_body_m.clear();
            for (const py::array& piece : pieces_body_m)
              v.collision_pieces_body_m.push_back(as_points(piece, "pieces_body_m"));
          },
          py::arg("pieces_body_m"),
          "Set the convex pieces, each given by its corners (n, 3), body frame [m], and the shape to PIECES.")
      .def_readwrite("friction", &VehicleSpec::friction)
      .def_readwrite("restitution", &VehicleSpec::restitution)
      .def(
          "set_start",
          [](VehicleSpec& v, const py::object& position_m, const py::object& orientation_xyzw) {
            v.start_world_from_body = as_pose(position_m, orientation_xyzw, "start");
          },
          py::arg("position_m"), py::arg("orientation_xyzw"))
      .def_readwrite("docked", &VehicleSpec::docked)
      .def_readwrite("sensors", &VehicleSpec::sensors)
      .def_readwrite("sonars", &VehicleSpec::sonars)
      .def_readwrite("battery", &VehicleSpec::battery, "None: the simulation's mission time")
      .def_readwrite("windage", &VehicleSpec::windage, "None: it feels no wind")
      .def_readwrite("wrenches", &VehicleSpec::wrenches, "what acts on it, by schedule; copied")
      .def_readwrite("arm", &VehicleSpec::arm, "its links, a list; copied; empty: it has no arm");
}

}  // namespace

void bind_sim(py::module_& m) {
  bind_specs(m);
  py::class_<Tape, std::shared_ptr<Tape>>(m, "Tape",
                                          "Rows that a simulation appends at multiples of periods; see tape.h.")
      .def(py::init<>())
      .def("add_time", &Tape::add_time, py::arg("period_ns"), "Add a track of times without values.")
      .def("add_motion", &Tape::add_motion, py::arg("vehicle"), py::arg("period_ns"),
           "Add a track: position (3,) [m], orientation_xyzw (4,), linear and angular velocity (3,) each, in body\n"
           "axes, and the elevation [rad] of each sonar.")
      .def("add_sensor", &Tape::add_sensor, py::arg("vehicle"), py::arg("sensor"), py::arg("period_ns"),
           "Add a track of what read_sensor returns.");
  m.def(
      "saved_notes",
      [](const py::bytes& state, const std::string& scenario, const std::string& build) {
        return saved_notes(state, {scenario, build});
      },
      py::arg("state"), py::arg("scenario"), py::arg("build"),
      "Return the notes in a saved state. Raises ValueError for a damaged state or another scenario.");
  m.def(
      "saved_build", [](const py::bytes& state) { return saved_build(state); }, py::arg("state"),
      "Return the fingerprint of the build that saved a state. Raises ValueError for a damaged state.");
  py::class_<OwnedSimulation> simulation(
      m, "Simulation", "A world with vehicles, which are identified by index, advanced by fixed steps.");
  bind_telemetry(m, simulation);
  bind_commands(simulation);
  bind_forces(m, simulation);
  bind_tether(m, simulation);
  bind_arm(m, simulation);
  bind_pings(m, simulation);
  bind_link(m, simulation);
  bind_batch(m);
  simulation
      .def(py::init<const World&, std::shared_ptr<RayScene>, const SimulationSpec&>(), py::arg("world"),
           py::arg("scene").none(false), py::arg("spec"))
      .def(
          "add_vehicle",
          [](OwnedSimulation& owned, VehicleSpec spec) {
            require(spec.craft != nullptr, "vehicles.craft", "none", "must be set");
            return owned.add_vehicle(spec);
          },
          py::arg("spec"), "Add a vehicle and return its index.")
      .def("add_object", &OwnedSimulation::add_object, py::arg("spec"),
           "Add a loose body, after all vehicles, and return its index.")
      .def("restart", &OwnedSimulation::restart, py::arg("world"), py::arg("spec"),
           "Restart with the same vehicles and objects at their start states. world: as before, except for its water. "
           "Raises\n"
           "ValueError without changing anything.")
      .def("change", &OwnedSimulation::change, py::arg("water"), py::arg("spec"), py::arg("vehicles"),
           "Replace all parameters; all state is kept. vehicles: one spec per vehicle, in order; their start\n"
           "states are ignored. Raises ValueError without changing anything.")
      .def("step", &OwnedSimulation::step, py::arg("count") = 1,
           "Advance by fixed steps. Releases the GIL. Can be interrupted by Ctrl-C.")
      .def_property_readonly(
          "time_ns", [](OwnedSimulation& o) { return o.with_briefly([](Simulation& s) { return s.time_ns(); }); })
      .def_property_readonly(
          "version", &OwnedSimulation::version,
          "A counter that changes whenever an observation may change: with time, a vehicle's pose or a sonar's\n"
          "elevation.")
      .def_property_readonly("tick",
                             [](OwnedSimulation& o) { return o.with_briefly([](Simulation& s) { return s.tick(); }); })
      .def(
          "state",
          [](OwnedSimulation& o, std::size_t v) { return o.with_briefly([&](Simulation& s) { return s.state(v); }); },
          py::arg("vehicle"))
      .def(
          "motion",
          [](OwnedSimulation& o, std::size_t v) {
            const BodyState state = o.with_briefly([&](Simulation& s) { return s.state(v); });
            const Pose& pose = state.world_from_body;
            return py::make_tuple(fixed(pose.position_m), fixed(pose.orientation.coeffs()), fixed(pose.matrix()),
                                  fixed(state.linear_body_m_s()), fixed(state.angular_body_rad_s()));
          },
          py::arg("vehicle"),
          "Return the state as read-only arrays: position_world_m (3,), orientation_xyzw (4,), world_from_body\n"
          "(4, 4), linear_body_m_s (3,) and angular_body_rad_s (3,).")
      .def(
          "set_state",
          [](OwnedSimulation& o, std::size_t v, const BodyState& state) {
            o.with([&](Simulation& s) { s.set_state(v, state); });
          },
          py::arg("vehicle"), py::arg("state"))
      .def(
          "release", [](OwnedSimulation& o, std::size_t v) { o.with([&](Simulation& s) { s.release(v); }); },
          py::arg("vehicle"))
      .def(
          "dock",
          [](OwnedSimulation& o, std::size_t v, const py::object& position_m, const py::object& orientation_xyzw) {
            const Pose dock = as_pose(position_m, orientation_xyzw, "dock");
            o.with([&](Simulation& s) { s.dock(v, dock); });
          },
          py::arg("vehicle"), py::arg("position_world_m"), py::arg("orientation_xyzw"),
          "Hold the vehicle at this pose, at rest, with its commands cancelled and its battery full, until it is\n"
          "released. Raises ValueError.")
      .def(
          "released",
          [](OwnedSimulation& o, std::size_t v) {
            return o.with_briefly([&](Simulation& s) { return s.released(v); });
          },
          py::arg("vehicle"))
      .def(
          "collisions",
          [](OwnedSimulation& o, std::size_t v) {
            return o.with_briefly([&](Simulation& s) { return s.collisions(v); });
          },
          py::arg("vehicle"), "Return the number of times the vehicle has come into contact with anything.")
      .def(
          "scene_around",
          [](OwnedSimulation& o, std::optional<std::size_t> vehicle) {
            return o.with([&](Simulation& s) {
              if (vehicle) s.vehicle(*vehicle);  // throws if it is unknown
              const auto placed = std::make_shared<const MovingBodies>(s.vehicles_for_rays());
              return std::make_shared<RayScene>(
                  s.scene_with_plants().with(placed, vehicle.value_or(MovingBodies::kNone)));
            });
          },
          py::arg("vehicle") = py::none(),
          "Return the world with all vehicles and objects at their present poses, except the given vehicle. A\n"
          "snapshot. Labels of vehicles, then of objects and tethers, follow those of the world.")
      .def(
          "watch_sensor",
          [](OwnedSimulation& o, std::size_t v, std::size_t sensor, std::optional<std::uint64_t> from_ns) {
            o.with([&](Simulation& s) { s.watch_sensor(v, sensor, from_ns); });
          },
          py::arg("vehicle"), py::arg("sensor"), py::arg("from_ns"),
          "Start collecting the samples measured at or after from_ns, as they arrive; None stops collecting.")
      .def("take_samples", &take_samples, py::arg("vehicle"), py::arg("sensor"),
           "Return stamps_ns (n,), arrivals_ns (n,), readings (n, width) and valid (n,) of the samples that have\n"
           "arrived since the last call, except dropped ones. Raises ValueError unless the sensor is watched.")
      .def(
          "attach_tape",
          [](OwnedSimulation& o, std::shared_ptr<Tape> tape) {
            o.with([&](Simulation& s) { s.attach(std::move(tape)); });
          },
          py::arg("tape"), "Write a tape, before a restart or detach_tape, at the end of each step at which it is due.")
      .def(
          "detach_tape",
          [](OwnedSimulation& o, const std::shared_ptr<Tape>& tape) { o.with([&](Simulation& s) { s.detach(tape); }); },
          py::arg("tape"))
      .def("take_rows", &take_rows, py::arg("tape"), py::arg("track"),
           "Return stamps_ns (n,), times_ns (n,), values (n, width) and valid (n,) of a track since the last call.\n"
           "Raises IndexError.")
      .def("read_sensor", &read_sensor, py::arg("vehicle"), py::arg("sensor"), py::arg("with_noise") = true,
           "Read a sensor. Reading again at the same time returns the same sample. Without noise: the present\n"
           "value, without errors, rate, latency or drop-outs.")
      .def(
          "save_state",
          [](OwnedSimulation& o, const std::string& scenario, const std::string& build, const std::string& notes) {
            return py::bytes(o.with([&](Simulation& s) { return s.save_state({scenario, build}, notes); }));
          },
          py::arg("scenario"), py::arg("build"), py::arg("notes") = "",
          "Return the complete state, as bytes, along with fingerprints of the simulation's parameters; the\n"
          "parameters themselves are not included. notes: stored as well.")
      .def(
          "restore_state",
          [](OwnedSimulation& o, const py::bytes& state, const std::string& scenario, const std::string& build) {
            const std::string_view bytes = state;
            return o.with([&](Simulation& s) { return s.restore_state(bytes, {scenario, build}); });
          },
          py::arg("state"), py::arg("scenario"), py::arg("build"),
          "Restore a saved state and return its notes. Raises ValueError, without changing anything, for a\n"
          "damaged state or other fingerprints.");
}

}  // namespace uwsim::bindings
