#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <string>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/binders.h"
#include "bindings/core/convert.h"
#include "uwsim/core/body_state.h"
#include "uwsim/core/check.h"
#include "uwsim/core/instruction_set.h"
#include "uwsim/core/stream_name.h"
#include "uwsim/core/triangle_mesh.h"

namespace uwsim::bindings {
namespace {

BodyState as_state(const py::object& position_m, const py::object& orientation_xyzw, const py::object& velocity_body) {
  BodyState state;
  state.world_from_body = as_pose(position_m, orientation_xyzw, "state");
  const auto v = as_array<double>(velocity_body, "velocity_body", {6});
  state.velocity_body = Eigen::Map<const Vector6d>(v.data());
  return state;
}

/// InvalidValue is a std::invalid_argument, which pybind11 translates to ValueError by default.
void translate_file_errors() {
  py::register_local_exception_translator([](std::exception_ptr p) {  // by value, as pybind11's signature requires
    try {
      if (p) std::rethrow_exception(p);
    } catch (const FileError& error) {
      // Paths may contain bytes that are not UTF-8, which Python's file-system encoding can represent.
      const auto message = py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(error.what()));
      PyErr_SetObject(PyExc_OSError, message.ptr());
    }
  });
}

}  // namespace

void bind_core(py::module_& m) {
  translate_file_errors();
  bind_parameter(m);
  m.def(
      "stream_name", [](const std::string& owner, const std::string& part) { return stream_name(owner, part); },
      py::arg("owner"), py::arg("part"),
      "Return the name of the random stream of a vehicle's sensor, sonar or camera.");

  py::class_<BodyState>(
      m, "BodyState",
      "Pose and velocity of a body, in read-only arrays; six-vectors are (linear, angular) in the body frame.")
      .def(py::init(&as_state), py::arg("position_m"), py::arg("orientation_xyzw"), py::arg("velocity_body"))
      .def_property_readonly(
          "position_world_m", [](const BodyState& s) { return fixed(s.world_from_body.position_m); }, "(3,) [m]")
      .def_property_readonly(
          "orientation_xyzw", [](const BodyState& s) { return fixed(s.world_from_body.orientation.coeffs()); }, "(4,)")
      .def_property_readonly(
          "world_from_body", [](const BodyState& s) { return fixed(s.world_from_body.matrix()); }, "(4, 4)")
      .def_property_readonly(
          "velocity_body", [](const BodyState& s) { return fixed(s.velocity_body); }, "(6,) [m/s, rad/s]");

  py::class_<SolidProperties>(m, "SolidProperties")
      .def_readonly("volume_m3", &SolidProperties::volume_m3)
      .def_readonly("centroid_m", &SolidProperties::centroid_m, "(3,) [m]")
      .def_readonly("inertia_per_density_m5", &SolidProperties::inertia_per_density_m5,
                    "(3, 3) [m^5], about the centroid; multiplied by the density, in kg m^2");
  m.def(
      "solid_properties",
      [](const py::object& vertices_m, const py::object& triangles) {
        const TriangleMesh mesh{as_points(vertices_m, "vertices_m"), as_triangles(triangles, "triangles")};
        require_closed(mesh, "mesh");
        return solid_properties(mesh);
      },
      py::arg("vertices_m"), py::arg("triangles"),
      "Return volume, centroid and inertia of a closed mesh (n, 3), (m, 3). Raises ValueError if the mesh is\n"
      "open or inverted.");
  m.def(
      "instruction_set", [] { return instruction_set_name(widest_instruction_set()); },
      "Return the instruction set that kernels use: avx512, avx2 or portable. It is the widest that this\n"
      "processor supports, or the one that UWSIM_INSTRUCTION_SET selects. Raises ValueError if that is not an\n"
      "instruction set, or the processor does not support it.");
}

}  // namespace uwsim::bindings
