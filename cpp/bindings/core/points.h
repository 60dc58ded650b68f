#pragma once

#include <cmath>
#include <limits>
#include <span>

#include "bindings/core/arrays.h"

/// Conversion of points and ranges between NumPy and C++: float32 arrays are passed to C++ as spans, and points are
/// returned as rows of x, y, z.
namespace uwsim::bindings {

/// Like as_array<float>, except that a finite float64 that does not fit in a float32 is an error instead of becoming
/// infinite.
inline FloatArray as_float32(const py::object& object, const char* name, std::initializer_list<py::ssize_t> shape) {
  if (!py::isinstance<py::array_t<float>>(object)) {
    const auto wide = as_array<double>(object, name, shape);
    for (py::ssize_t i = 0; i < wide.size(); ++i) {
      const double value = wide.data()[i];
      require(!std::isfinite(value) || std::abs(value) <= std::numeric_limits<float>::max(), name, value,
              "must fit a float32");
    }
  }
  return as_array<float>(object, name, shape);
}

inline FloatArray as_point_rows(const py::object& object, const char* name) {
  return as_float32(object, name, {-1, 3});
}

template <typename T>
std::span<const T> span_of(const py::array_t<T, py::array::c_style>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

template <typename T>
py::array_t<T> rows_out(std::vector<T>&& values) {
  const auto rows = static_cast<py::ssize_t>(values.size() / 3);
  return move_out(std::move(values), {rows, 3});
}

}  // namespace uwsim::bindings
