#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <initializer_list>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bindings/core/gil.h"
#include "uwsim/core/check.h"

/// Conversion of arrays between NumPy and C++. Inputs of the right type are not copied; results are moved into a
/// capsule.
namespace uwsim::bindings {

namespace py = pybind11;

/// C-ordered arrays. Lists and float64 are converted; complex numbers, text and objects are refused.
using FloatArray = py::array_t<float, py::array::c_style>;
using DoubleArray = py::array_t<double, py::array::c_style>;
using IndexArray = py::array_t<std::uint32_t, py::array::c_style>;

inline std::string shape_text(const py::array& array) {
  std::ostringstream text;
  text << "(";
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis) text << (axis ? ", " : "") << array.shape(axis);
  text << (array.ndim() == 1 ? ",)" : ")");
  return text.str();
}

/// Returns any numeric array or sequence as a C-ordered array of T, without a copy if it already is one. Raises
/// ValueError naming the argument if the dtype is not a real number or the shape does not match; -1 matches any extent.
template <typename T>
py::array_t<T, py::array::c_style> as_array(const py::object& object, const char* name,
                                            std::initializer_list<py::ssize_t> shape) {
  auto any = py::array::ensure(object);
  if (!any) {
    PyErr_Clear();
    throw InvalidValue(std::string(name) + ": not an array of numbers");
  }
  const char kind = any.dtype().kind();
  const bool empty_list = any.size() == 0;
  if (kind != 'f' && kind != 'i' && kind != 'u' &&
      !empty_list) {  // formatted only on failure: formatting a dtype takes longer than converting a small array
    require(false, std::string(name) + ".dtype", std::string(py::str(any.dtype())), "must be real numbers");
  }
  bool fits = any.ndim() == static_cast<py::ssize_t>(shape.size());
  py::ssize_t axis = 0;
  for (const py::ssize_t extent : shape) fits = fits && (extent < 0 || any.shape(axis) == extent) && ++axis;
  if (!fits) {
    std::ostringstream expected;
    expected << "expected (";
    axis = 0;
    for (const py::ssize_t extent : shape) {
      expected << (axis++ ? ", " : "");
      if (extent < 0) {
        expected << "n";
      } else {
        expected << extent;
      }
    }
    expected << (shape.size() == 1 ? ",)" : ")");
    require(false, std::string(name) + ".shape", shape_text(any), expected.str());
  }
  return py::array_t<T, py::array::c_style | py::array::forcecast>(any);
}

/// Moves a vector into a NumPy array of the given shape without copying its elements.
template <typename T, typename Allocator>
py::array_t<T> move_out(std::vector<T, Allocator>&& values, std::vector<py::ssize_t> shape) {
  using Values = std::vector<T, Allocator>;
  auto* owner = new Values(std::move(values));
  const py::capsule free(owner, [](void* p) { delete static_cast<Values*>(p); });
  return py::array_t<T>(std::move(shape), owner->data(), free);
}

/// As above, into an array (n,).
template <typename T>
py::array_t<T> move_out(std::vector<T>&& values) {
  const auto n = static_cast<py::ssize_t>(values.size());
  return move_out(std::move(values), {n});
}

/// Makes an array read-only by clearing its flag directly, which is faster than NumPy's look-up of the attribute by
/// name.
inline void forbid_writing(const py::array& array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
}

template <typename T>
py::array read_only(py::array_t<T> array) {
  forbid_writing(array);
  return array;
}

/// Returns a copy of a vector or matrix, in Eigen's order of columns. The copy is read-only, since writing to it would
/// not affect the original. py::cast would make three arrays of it.
template <typename Derived>
py::array_t<double> fixed(const Eigen::MatrixBase<Derived>& matrix) {
  static_assert(Derived::IsVectorAtCompileTime || !Derived::IsRowMajor);
  std::vector<py::ssize_t> shape{matrix.size()};
  if constexpr (!Derived::IsVectorAtCompileTime) shape = {matrix.rows(), matrix.cols()};
  py::array_t<double, py::array::f_style> array(std::move(shape));
  Eigen::Map<typename Derived::PlainObject>(array.mutable_data(), matrix.rows(), matrix.cols()) = matrix;
  forbid_writing(array);
  return py::reinterpret_steal<py::array_t<double>>(array.release());
}

inline Eigen::Vector3d as_vector3(const py::object& object, const char* name) {
  const auto array = as_array<double>(object, name, {3});
  return {array.at(0), array.at(1), array.at(2)};
}

/// Returns the result of work(), called without the GIL.
template <typename Work>
auto without_gil(const Work& work) {
  const GilReleased released;
  return work();
}

}  // namespace uwsim::bindings
