#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>

#include "bindings/sonar/binders.h"
#include "uwsim/sonar/multibeam_model.h"

namespace uwsim::bindings {

namespace py = pybind11;

namespace {

MultibeamModel checked_model(std::string name, int beams, double field_of_view_rad, double range_max_m,
                             double frequency_hz, std::optional<double> range_limit_m, int number, bool dual_swath,
                             double ping_rate_max_hz, double tilt_rate_rad_s, double receiver_tilt_rad,
                             double gain_db) {
  MultibeamModel model{number,
                       std::move(name),
                       beams,
                       field_of_view_rad,
                       range_max_m,
                       range_limit_m.value_or(range_max_m),
                       frequency_hz,
                       dual_swath,
                       ping_rate_max_hz,
                       tilt_rate_rad_s,
                       receiver_tilt_rad,
                       gain_db};
  model.check();
  return model;
}

}  // namespace

void bind_multibeam(py::module_& m) {
  py::class_<MultibeamModel>(m, "MultibeamModel",
                             "A multibeam's fan: beams evenly spaced about the head's forward axis.")
      .def(py::init(&checked_model), py::kw_only(), py::arg("name"), py::arg("beams"), py::arg("field_of_view_rad"),
           py::arg("range_max_m"), py::arg("frequency_hz"), py::arg("range_limit_m") = py::none(),
           py::arg("number") = 0, py::arg("dual_swath") = false, py::arg("ping_rate_max_hz") = 50.0,
           py::arg("tilt_rate_rad_s") = MultibeamModel{}.tilt_rate_rad_s, py::arg("receiver_tilt_rad") = 0.0,
           py::arg("gain_db") = 0.0, "Create a model. Raises ValueError naming the field.")
      .def_readonly("number", &MultibeamModel::number, "1..4 in messages; 0 for a model that messages cannot select")
      .def_readonly("name", &MultibeamModel::name)
      .def_readonly("beams", &MultibeamModel::beams)
      .def_readonly("field_of_view_rad", &MultibeamModel::field_of_view_rad)
      .def_readonly("range_max_m", &MultibeamModel::range_max_m, "a range at or beyond this counts as no echo")
      .def_readonly("range_limit_m", &MultibeamModel::range_limit_m,
                    "limit of the published decoder: a range above this counts as no echo")
      .def_readonly("frequency_hz", &MultibeamModel::frequency_hz)
      .def_readonly("dual_swath", &MultibeamModel::dual_swath)
      .def_readonly("ping_rate_max_hz", &MultibeamModel::ping_rate_max_hz, "limit of the electronics")
      .def_readonly("tilt_rate_rad_s", &MultibeamModel::tilt_rate_rad_s)
      .def_readonly("receiver_tilt_rad", &MultibeamModel::receiver_tilt_rad,
                    "angle of each of two receivers from straight ahead to its side; 0 for a single receiver")
      .def_readonly("gain_db", &MultibeamModel::gain_db, "of the receiver's display; added to every intensity")
      .def_property_readonly("angle_min_rad", [](const MultibeamModel& m) { return m.angles().first_rad; })
      .def_property_readonly("angle_increment_rad", [](const MultibeamModel& m) { return m.angles().spacing_rad; });
  m.def("multibeam_model", &em2040, py::arg("number"), py::return_value_policy::reference,
        "Return the EM 2040 MKII variant 1..4. Raises ValueError for other numbers.");
}

}  // namespace uwsim::bindings
