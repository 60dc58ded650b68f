#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "crafts.h"
#include "uwsim/sim/simulation.h"

namespace uwsim {

inline constexpr double kBed_m = -20;
inline const StateOrigin kHere{"a scenario", "a build"};

inline World flat_world() {
  World world;
  world.set_terrain(Heightfield(std::vector<float>(4, kBed_m), 2, 2, 400.0, {-200, -200}));
  return world;
}

inline Simulation simulation(const World& world, const SimulationSpec& spec = {}) {
  return {world, std::make_shared<const RayScene>(world), spec};
}

inline VehicleSpec vehicle_of(const std::string& name, const Eigen::Vector3d& position_m,
                              std::shared_ptr<const Craft> craft) {
  VehicleSpec spec;
  spec.name = name;
  spec.craft = std::move(craft);
  spec.start_world_from_body.position_m = position_m;
  return spec;
}

/// A neutral body, or another, with the same drag along and about all axes.
inline std::shared_ptr<const Craft> dragged(const TriangleMesh& mesh = brick(), double density_kg_m3 = 1000) {
  CraftParameters p = solid_of(mesh, density_kg_m3);
  p.quadratic_damping.diagonal().setConstant(250);
  return craft_of(p, mesh);
}

/// A propeller.
inline ThrusterParameters aft_thruster() {
  ThrusterParameters thruster;
  thruster.name = "aft";
  thruster.curve = ThrustCurve({-1, 0, 1}, {-30, 0, 40});
  return thruster;
}

inline BodyState at(const Eigen::Vector3d& position_m) {
  BodyState state;
  state.world_from_body.position_m = position_m;
  return state;
}

}  // namespace uwsim
