#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bindings/core/arrays.h"
#include "uwsim/core/pose.h"
#include "uwsim/core/triangle_mesh.h"

/// Conversion of geometry from Python's arrays.
namespace uwsim::bindings {

/// Converts numbers, (n,).
inline std::vector<double> as_numbers(const py::object& object, const char* name) {
  const auto array = as_array<double>(object, name, {-1});
  return {array.data(), array.data() + array.size()};
}

/// Converts points, (n, 3), which must be finite.
inline std::vector<Eigen::Vector3d> as_points(const py::object& object, const char* name) {
  const auto array = as_array<double>(object, name, {-1, 3});
  std::vector<Eigen::Vector3d> points(static_cast<std::size_t>(array.shape(0)));
  std::copy(array.data(), array.data() + array.size(), reinterpret_cast<double*>(points.data()));
  for (const auto& p : points) require(p.allFinite(), name, p.transpose(), "must be finite");
  return points;
}

/// Converts indices, (m, 3). Negative and fractional indices are refused, instead of wrapping around or being rounded.
inline std::vector<Triangle> as_triangles(const py::object& object, const char* name) {
  const auto array = as_array<double>(object, name, {-1, 3});
  std::vector<Triangle> triangles(static_cast<std::size_t>(array.shape(0)));
  auto* out = reinterpret_cast<std::uint32_t*>(triangles.data());
  for (py::ssize_t k = 0; k < array.size(); ++k) {
    const double index = array.data()[k];
    require(index >= 0 && index < 4294967295.0 && index == std::floor(index), name, index, "must be a whole index");
    out[k] = static_cast<std::uint32_t>(index);
  }
  return triangles;
}

/// Checks that the position is finite and the quaternion's length is in [1e-6, 1e6]; normalises the quaternion.
inline Pose checked_pose(const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation,
                         const std::string& name) {
  require(position.allFinite(), name + ".position_m", position.transpose(), "must be finite");
  const double length = orientation.coeffs().stableNorm();
  require(length >= 1e-6 && length <= 1e6, name + ".orientation_xyzw", orientation.coeffs().transpose(),
          "must be a quaternion of length in [1e-6, 1e6]");
  return {position, orientation.normalized()};
}

/// Converts a position (3,) and a quaternion x, y, z, w (4,) to a pose. The quaternion is normalised.
inline Pose as_pose(const py::object& position_m, const py::object& orientation_xyzw, const std::string& name) {
  const Eigen::Vector3d position = as_vector3(position_m, (name + ".position_m").c_str());
  const auto q = as_array<double>(orientation_xyzw, (name + ".orientation_xyzw").c_str(), {4});
  return checked_pose(position, {q.at(3), q.at(0), q.at(1), q.at(2)}, name);
}

/// Converts positions (n, 3) and quaternions x, y, z, w (n, 4) to poses. The quaternions are normalised.
inline std::vector<Pose> as_poses(const py::object& positions_m, const py::object& orientations_xyzw,
                                  const std::string& name) {
  const auto p = as_array<double>(positions_m, (name + ".positions_m").c_str(), {-1, 3});
  const auto q = as_array<double>(orientations_xyzw, (name + ".orientations_xyzw").c_str(), {p.shape(0), 4});
  std::vector<Pose> poses;
  for (py::ssize_t k = 0; k < p.shape(0); ++k) {
    poses.push_back(checked_pose({p.at(k, 0), p.at(k, 1), p.at(k, 2)}, {q.at(k, 3), q.at(k, 0), q.at(k, 1), q.at(k, 2)},
                                 name + "[" + std::to_string(k) + "]"));
  }
  return poses;
}

}  // namespace uwsim::bindings
