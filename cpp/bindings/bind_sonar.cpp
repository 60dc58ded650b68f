#include <pybind11/stl.h>

#include "bind.h"
#include "uwsim/sonar/multibeam_model.h"

namespace uwsim::bindings {

namespace py = pybind11;

void bind_sonar(py::module_& m) {
  py::class_<MultibeamModel>(m, "MultibeamModel", "A multibeam's fan, evenly spread about the head's forward axis.")
      .def_readonly("number", &MultibeamModel::number, "1..4, as on the wire")
      .def_readonly("name", &MultibeamModel::name)
      .def_readonly("beams", &MultibeamModel::beams)
      .def_readonly("field_of_view_rad", &MultibeamModel::field_of_view_rad)
      .def_readonly("range_max_m", &MultibeamModel::range_max_m, "A range at or past it is no echo.")
      .def_readonly("range_limit_m", &MultibeamModel::range_limit_m,
                    "The published decoder's limit: above it, no echo.")
      .def_readonly("frequency_hz", &MultibeamModel::frequency_hz)
      .def_readonly("dual_swath", &MultibeamModel::dual_swath)
      .def_property_readonly("angle_min_rad", &MultibeamModel::angle_min_rad)
      .def_property_readonly("angle_increment_rad", &MultibeamModel::angle_increment_rad);
  m.def("multibeam_model", &em2040, py::arg("number"), py::return_value_policy::reference,
        "The EM 2040 MKII variant 1..4. Raises ValueError for other numbers.");
}

}  // namespace uwsim::bindings
