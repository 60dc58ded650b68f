#pragma once

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "uwsim/sensors/sensor_kinds.h"
#include "uwsim/sim/simulation.h"

namespace uwsim::testing {

/// A packaged hull or its collision pieces, from an OBJ file written by uwsim's tools: lines `v x y z` and `f a b c`,
/// and a line `o` before each piece. Throws if the file cannot be read.
struct ObjFile {
  TriangleMesh mesh;
  std::vector<ConvexPiece> pieces;

  explicit ObjFile(const std::string& name) {
    std::ifstream file(UWSIM_ASSETS "/meshes/" + name);
    if (!file) throw std::runtime_error("cannot read " UWSIM_ASSETS "/meshes/" + name);
    for (std::string line, word; std::getline(file, line);) {
      std::istringstream words(line);
      words >> word;
      if (word == "o") pieces.emplace_back();
      if (word == "v") {
        Eigen::Vector3d& v = mesh.vertices_m.emplace_back();
        words >> v.x() >> v.y() >> v.z();
        if (!pieces.empty()) pieces.back().push_back(v);
      } else if (word == "f") {
        Triangle& t = mesh.triangles.emplace_back();
        words >> t[0] >> t[1] >> t[2];
        for (std::uint32_t& index : t) --index;
      }
    }
  }
};

/// A sensor of this kind with all kinds of errors.
inline SensorSpec noisy(const SensorKind& kind) {
  SensorSpec spec;
  spec.name = spec.kind = kind.name;
  for (const Parameter& parameter : kind.parameters) {
    if (!std::isnan(parameter.by_default)) continue;
    spec.parameters.try_emplace(std::string(parameter.name), static_cast<std::size_t>(parameter.width), 30.0);
  }
  for (const Channel& channel : kind.channels) {
    spec.noise[std::string(channel.name)] = {
        .std = 0.01, .density = 0.001, .turn_on_std = 0.01, .bias_std = 0.01, .bias_time_s = 60, .walk = 1e-4};
  }
  spec.rate_hz = 50;
  spec.latency_s = 0.02;
  spec.drop_out = 0.05;
  return spec;
}

/// A BlueROV2 Heavy: the packaged hull of 2,202 triangles and its 24 collision pieces, eight lagging thrusters that
/// lose thrust with speed, the coefficients of von Benzon et al. 2022, and one noisy sensor of every kind.
inline VehicleSpec heavy_rov(const std::string& name, const Eigen::Vector3d& position_m, double density_kg_m3 = 1000) {
  TriangleMesh mesh = ObjFile("bluerov2_heavy.obj").mesh;
  const SolidProperties solid = solid_properties(mesh);
  for (Eigen::Vector3d& v : mesh.vertices_m) v -= solid.centroid_m - Eigen::Vector3d(0, 0, 0.01);
  CraftParameters p;
  p.mass_kg = density_kg_m3 * solid.volume_m3;
  p.inertia_kg_m2.diagonal() << 0.26, 0.23, 0.37;
  p.added_mass.diagonal() << 6.3567, 7.1206, 18.6863, 0.1858, 0.1348, 0.2215;
  p.linear_damping.diagonal() << 13.7, 0, 33, 0, 0.8, 0;
  p.quadratic_damping.diagonal() << 141, 217, 190, 1.192, 0.470, 1.5;
  VehicleSpec spec;
  spec.name = name;
  spec.shape = CollisionShape::kPieces;
  spec.collision_pieces_body_m = ObjFile("bluerov2_heavy.pieces.obj").pieces;
  for (ConvexPiece& piece : spec.collision_pieces_body_m) {
    for (Eigen::Vector3d& v : piece) v -= solid.centroid_m - Eigen::Vector3d(0, 0, 0.01);
  }
  spec.craft = std::make_shared<const Craft>(p, BuoyantHull(std::move(mesh)));
  spec.start_world_from_body.position_m = position_m;
  for (int k = 0; k < 8; ++k) {
    ThrusterParameters thruster;
    const double left = k % 2 ? 1 : -1, ahead = k % 4 < 2 ? 1 : -1;
    thruster.name = "thruster_" + std::to_string(k);
    thruster.position_body_m =
        k < 4 ? Eigen::Vector3d(0.145 * ahead, 0.092 * left, 0) : Eigen::Vector3d(0.118 * ahead, 0.215 * left, 0.064);
    thruster.axis_body = k < 4 ? Eigen::Vector3d(-ahead, left, 0).normalized() : Eigen::Vector3d::UnitZ();
    thruster.curve = ThrustCurve({-1, -0.07, 0.07, 1}, {-39.9, 0, 0, 51.5});
    thruster.time_constant_s = 0.076;
    thruster.diameter_m = 0.076;
    thruster.zero_thrust_advance_ratio = 0.976;
    thruster.torque_per_thrust_m = 0.0153;
    spec.actuators.thrusters.push_back(thruster);
  }
  for (const SensorKind* kind : sensor_kinds()) spec.sensors.push_back(noisy(*kind));
  return spec;
}

}  // namespace uwsim::testing
