#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "crafts.h"
#include "meshes.h"
#include "uwsim/dynamics/rigid_body_world.h"

namespace uwsim {

inline constexpr double kStep_s = 0.005, kGravity = 9.80665;
inline constexpr std::array kEngines = {EngineKind::kUwsim, EngineKind::kBullet};

/// A state at rest, upright.
inline BodyState at(const Eigen::Vector3d& place_m) {
  BodyState state;
  state.world_from_body.position_m = place_m;
  return state;
}

inline BodyState at(double x, double y, double z) { return at(Eigen::Vector3d(x, y, z)); }

/// So thin that only gravity acts.
inline EvenWater vacuum(double gravity_m_s2 = kGravity) {
  EvenWater water;
  water.density_kg_m3 = 1e-12;
  water.gravity_m_s2 = gravity_m_s2;
  return water;
}

inline BodySpec body_of(std::shared_ptr<const Craft> craft, double friction = 0.6, double restitution = 0.1) {
  return {"body", std::move(craft), CollisionShape::kHull, friction, restitution};
}

/// A bed of nodes x nodes heights around the origin.
template <typename Height>
World bed_world(int nodes, double spacing_m, const Height& height_m) {
  const double edge = -0.5 * (nodes - 1) * spacing_m;
  std::vector<float> heights;
  for (int j = 0; j < nodes; ++j) {
    for (int i = 0; i < nodes; ++i)
      heights.push_back(static_cast<float>(height_m(edge + i * spacing_m, edge + j * spacing_m)));
  }
  World world;
  const auto count = static_cast<std::size_t>(nodes);
  world.set_terrain(Heightfield(heights, count, count, spacing_m, {edge, edge}));
  return world;
}

inline World flat_bed(double z_m, int nodes = 41, double spacing_m = 1) {
  return bed_world(nodes, spacing_m, [=](double, double) { return z_m; });
}

inline World solid_world(const TriangleMesh& mesh, const std::string& name = "solid") {
  World world;
  world.add_solid(name, mesh);
  return world;
}

inline void run(RigidBodyWorld& bodies, int steps, const WaterField& water = EvenWater{}, double step_s = kStep_s) {
  for (int k = 0; k < steps; ++k) bodies.step(water, k * step_s);
}

inline Eigen::Vector3d place_m(const RigidBodyWorld& bodies, std::size_t body = 0) {
  return bodies.state(body).world_from_body.position_m;
}

/// Along the world's axes, of the body's origin.
inline Eigen::Vector3d velocity_m_s(const RigidBodyWorld& bodies, std::size_t body = 0) {
  return bodies.state(body).world_from_body.direction(bodies.state(body).linear_body_m_s());
}

/// A force along a body's x axis.
inline Vector6d ahead(double force_n) {
  Vector6d wrench = Vector6d::Zero();
  wrench[0] = force_n;
  return wrench;
}

/// Saves or restores bodies with all that belongs to them.
inline void exchange_all(RigidBodyWorld& bodies, StateArchive& archive) {
  bodies.exchange_state(archive);
  bodies.exchange_contacts(archive);
  bodies.exchange_last_step(archive);
  bodies.exchange_tethers(archive);
  bodies.exchange_arms(archive);
}

inline std::string saved(RigidBodyWorld& bodies) {
  StateArchive archive;
  exchange_all(bodies, archive);
  return archive.bytes();
}

inline void restore(RigidBodyWorld& bodies, const std::string& bytes) {
  StateArchive archive(bytes);
  exchange_all(bodies, archive);
  archive.finish();
}

}  // namespace uwsim
