#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <initializer_list>

#include "bindings/core/arrays.h"
#include "uwsim/control/motion_estimate.h"

/// Conversion of estimates and efforts between Python and controllers.
namespace uwsim::bindings {

/// Returns an attribute, which must be an array of this shape. An array of doubles is not copied, regardless of its
/// memory order.
inline py::array_t<double> array_of(const py::object& owner, const char* name,
                                    std::initializer_list<py::ssize_t> shape) {
  const py::object value = owner.attr(name);
  if (py::isinstance<py::array_t<double>>(value)) {
    auto array = py::reinterpret_borrow<py::array_t<double>>(value);
    if (std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim())) return array;
  }
  return as_array<double>(value, name, shape);
}

/// Builds an estimate from `pose`, with world_from_body (4, 4), and `velocity`, with linear_body_m_s (3,) and
/// angular_body_rad_s (3,). Raises ValueError for other shapes.
inline MotionEstimate as_estimate(const py::object& pose, const py::object& velocity) {
  const auto matrix = array_of(pose, "world_from_body", {4, 4});
  const auto linear = array_of(velocity, "linear_body_m_s", {3});
  const auto angular = array_of(velocity, "angular_body_rad_s", {3});
  const auto entry = matrix.unchecked<2>();
  const auto v = linear.unchecked<1>(), w = angular.unchecked<1>();
  MotionEstimate estimate;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) estimate.world_from_body(i, j) = entry(i, j);
    estimate.position_world_m[i] = entry(i, 3);
    estimate.velocity_body[i] = v(i);
    estimate.velocity_body[3 + i] = w(i);
  }
  return estimate;
}

/// Six efforts as plain floats, as set_effort accepts them.
using Efforts = py::typing::Tuple<py::float_, py::float_, py::float_, py::float_, py::float_, py::float_>;
inline Efforts as_efforts(const Vector6d& effort) {
  return py::make_tuple(effort[0], effort[1], effort[2], effort[3], effort[4], effort[5]);
}

}  // namespace uwsim::bindings
