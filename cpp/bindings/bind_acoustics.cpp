#include "bind.h"
#include "uwsim/acoustics/sea_water.h"

namespace uwsim::bindings {

namespace py = pybind11;

void bind_acoustics(py::module_& m) {
  m.def("sound_speed_m_s", &sound_speed_m_s, py::arg("temperature_deg_c"), py::arg("salinity_psu"), py::arg("depth_m"),
        "Speed of sound in water [m/s], Mackenzie 1981.");
  m.def("absorption_db_km", &absorption_db_km, py::arg("frequency_hz"), py::arg("temperature_deg_c"),
        py::arg("salinity_psu"), py::arg("depth_m"), py::arg("acidity_ph") = 8.0,
        "Absorption of sound in water [dB/km], Francois and Garrison 1982.");
}

}  // namespace uwsim::bindings
