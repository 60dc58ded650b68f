#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// One of a swarm at one time: its place, and which of the meshes it has.
struct Swimmer {
  Eigen::Vector3d position_world_m;
  Eigen::Vector3d velocity_world;  ///< of any length, not vertical
  std::size_t size, phase;

  /// World from body: x along the velocity, y level.
  Eigen::Matrix3d rotation() const;
};

/// Many small bodies that only instruments meet, such as fish, whose places are a function of time, so that nothing of
/// them is saved.
class Swarm {
 public:
  virtual ~Swarm() = default;
  virtual const std::string& name() const = 0;
  /// For each size, the meshes of its phases: x ahead, z up, origin in the middle.
  virtual const std::vector<std::vector<TriangleMesh>>& shapes_m() const = 0;
  virtual std::size_t size() const = 0;
  /// Consecutive ones should be neighbours: rays exclude them together.
  virtual void place(double time_s, std::span<Swimmer> bodies) const = 0;
  /// A sphere in which the middles of all bodies stay.
  virtual Eigen::Vector3d middle_world_m() const = 0;
  virtual double reach_m() const = 0;
};

}  // namespace uwsim
