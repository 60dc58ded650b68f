// Saved states: as they come, and with a header and checksum that are right, so that mutations reach what is inside. A
// state that is accepted can be stepped and saved, and is the same when it is restored once more.
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "uwsim/core/check.h"
#include "uwsim/sim/saved_state_format.h"
#include "uwsim/sim/simulation.h"

namespace {

using namespace uwsim;

const StateOrigin kHere{"a scenario", "a build"};

TriangleMesh box() {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices_m.emplace_back(corner & 1 ? 0.6 : -0.6, corner & 2 ? 0.4 : -0.4, corner & 4 ? 0.3 : -0.3);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A craft with a lagging thruster, a fin, a sonar head and sensors with memory.
VehicleSpec craft() {
  const TriangleMesh mesh = box();
  const SolidProperties solid = solid_properties(mesh);
  CraftParameters p;
  p.mass_kg = 1050 * solid.volume_m3;
  p.inertia_kg_m2 = 1050 * solid.inertia_per_density_m5;
  p.quadratic_damping.diagonal().setConstant(250);
  VehicleSpec spec;
  spec.name = "craft";
  spec.craft = std::make_shared<const Craft>(p, BuoyantHull(mesh));
  ThrusterParameters thruster;
  thruster.name = "aft";
  thruster.curve = ThrustCurve({-1, 0, 1}, {-30, 0, 40});
  thruster.time_constant_s = 0.3;
  spec.actuators.thrusters = {thruster};
  FinParameters fin;
  fin.name = "rudder";
  fin.span_body = Eigen::Vector3d::UnitZ();
  fin.deflection_max_rad = 0.5;
  fin.rate_max_rad_s = 0.2;
  spec.actuators.fins = {fin};
  spec.start_world_from_body.position_m = {0, 0, -8};
  SensorSpec depth{.name = "depth", .kind = "depth", .body_from_sensor = {}, .parameters = {}, .noise = {}};
  depth.rate_hz = 7;
  depth.latency_s = 0.31;
  depth.noise["depth"] = {.std = 0.1, .walk = 0.05};
  spec.sensors = {depth};
  spec.sonars.resize(1);
  spec.sonars[0].name = "sonar";
  return spec;
}

std::unique_ptr<Simulation> simulation() {
  static World world;
  static const auto rays = [] {
    world.set_terrain(Heightfield({-11, -11, -12, -12}, 2, 2, 400.0, {-200, -200}));
    return std::make_shared<const RayScene>(world);
  }();
  SimulationSpec spec;
  spec.seed = 3;
  return std::make_unique<Simulation>(world, rays, spec);
}

/// A simulation, and what it saves where it begins: each input meets it in this state.
struct Subject {
  std::unique_ptr<Simulation> sim = simulation();
  std::string begin;
};

Subject alone() {
  Subject made;
  made.sim->add_vehicle(craft());
  made.begin = made.sim->save_state(kHere, "");
  return made;
}

/// Joined by a modem, with a USBL that shares it, messages that wait, one on its way, and a node that is cut off.
Subject linked() {
  Subject made;
  VehicleSpec vehicle = craft();
  vehicle.sensors.push_back({.name = "usbl", .kind = "usbl", .body_from_sensor = {}, .parameters = {}, .noise = {}});
  vehicle.sensors.back().rate_hz = 0.5;
  vehicle.sensors.back().parameters["shares_modem"] = {1};
  made.sim->add_vehicle(vehicle);
  made.sim->set_link({});
  PacketNetwork& network = made.sim->link();
  for (const std::size_t bytes : {200, 3, 100}) {
    LinkMessage message;
    message.to = bytes == 3 ? 0 : 1;
    message.topic = network.topic(bytes == 100 ? "map" : "odom");
    message.deadline_ns = bytes == 100 ? 20'000'000'000 : 0;
    message.repeats = bytes == 100 ? 2 : 0;
    message.payload.assign(bytes, 'x');
    network.send(1 - message.to, message, 0);
  }
  made.sim->step(600);
  network.cut_off(1, true, made.sim->time_ns());
  made.begin = made.sim->save_state(kHere, "");
  return made;
}

Subject* subjects() {
  static Subject made[] = {alone(), linked()};
  return made;
}

bool restore(Simulation& sim, std::string_view bytes) {
  try {
    sim.restore_state(bytes, kHere);
    return true;
  } catch (const InvalidValue&) {
    return false;
  }
}

void hold(Subject& subject, std::string_view bytes) {
  Simulation& sim = *subject.sim;
  const std::string& before = subject.begin;
  if (!restore(sim, bytes) && !restore(sim, wrapped_state(bytes, kHere))) {
    if (sim.save_state(kHere, "") != before) std::abort();  // a refused state changes nothing
    return;
  }
  const std::string saved = sim.save_state(kHere, "");
  try {
    sim.step(2);
    sim.read_sensor(0, 0);
  } catch (const std::exception&) {
    // A craft at the end of the world: said, not crashed.
  }
  if (!restore(sim, saved) || sim.save_state(kHere, "") != saved) std::abort();
  if (!restore(sim, before)) std::abort();
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

/// One in 64 mutations is of a state that a simulation saved, without its header: nobody guesses one.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (seed % 64 == 0) {
    const std::string_view inside = unwrapped_state(subjects()[seed / 64 % 2].begin, kHere);
    size = std::min(inside.size(), max_size);
    std::memcpy(data, inside.data(), size);
  }
  return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (std::size_t k = 0; k < 2; ++k) hold(subjects()[k], bytes);
  return 0;
}
