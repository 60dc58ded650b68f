#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <limits>

#include "bindings/camera/bands.h"
#include "bindings/camera/binders.h"
#include "uwsim/camera/optics.h"
#include "uwsim/camera/refraction.h"

namespace uwsim::bindings {
namespace {

DaylightBelow daylight_under_water(const Optics& optics) {
  return daylight_below(daylight(optics.sun), optics.water.refractive_index);
}

}  // namespace

void bind_optics(py::module_& m) {
  m.def("jerlov_types", &jerlov_types, "Return the names of the Jerlov water types.");
  m.def(
      "refracted",
      [](const Eigen::Vector3d& direction, const Eigen::Vector3d& normal, double n_from, double n_to) {
        return refracted(direction.normalized(), normal.normalized(), n_from, n_to);
      },
      py::arg("direction"), py::arg("normal"), py::arg("n_from"), py::arg("n_to"),
      "Return the direction refracted by Snell's law, (3,), or None for total reflection. normal: (3,),\n"
      "towards the side that the ray comes from.");

  py::class_<WaterOptics>(m, "WaterOptics", "The optical properties of water [1/m], each (3,): red, green, blue.")
      .def(py::init([](const py::object& kd, const py::object& a, const py::object& b, double index) {
             WaterOptics water{as_bands(kd, "diffuse_attenuation"), as_bands(a, "absorption"),
                               as_bands(b, "scattering"), index};
             water.check();
             return water;
           }),
           py::arg("diffuse_attenuation"), py::arg("absorption"), py::arg("scattering"),
           py::arg("refractive_index") = 1.333)
      .def_static(
          "jerlov", &jerlov_water, py::arg("type"),
          "Return the water of a Jerlov type (sources in water_optics.h). Raises ValueError for an unknown type.")
      .def_property_readonly("diffuse_attenuation",
                             [](const WaterOptics& w) { return bands_out(w.diffuse_attenuation); })
      .def_property_readonly("absorption", [](const WaterOptics& w) { return bands_out(w.absorption); })
      .def_property_readonly("scattering", [](const WaterOptics& w) { return bands_out(w.scattering); })
      .def_property_readonly("beam_attenuation", [](const WaterOptics& w) { return bands_out(w.beam_attenuation()); })
      .def_readonly("refractive_index", &WaterOptics::refractive_index);

  py::class_<Optics>(
      m, "Optics",
      "Everything that determines the light: the water, the sun, the wind on the surface, and particles in\n"
      "the water.")
      .def(py::init([](const WaterOptics& water, double elevation_rad, double azimuth_rad, double wind_m_s,
                       double wind_towards_rad, double particles_per_m3, double turbulence_k, double fetch_m) {
             const Optics optics{
                 water,  {elevation_rad, azimuth_rad}, wind_m_s, wind_towards_rad, particles_per_m3, turbulence_k,
                 fetch_m};
             optics.check();
             return optics;
           }),
           py::arg("water"), py::arg("sun_elevation_rad"), py::arg("sun_azimuth_rad"), py::arg("wind_m_s"),
           py::arg("wind_towards_rad"), py::arg("particles_per_m3"), py::arg("turbulence_k"),
           py::arg("fetch_m") = std::numeric_limits<double>::infinity())
      .def_readonly("water", &Optics::water)
      .def_property_readonly("to_sun_world", [](const Optics& o) { return daylight(o.sun).to_sun_world; })
      .def_property_readonly("to_sun_below_world", [](const Optics& o) { return daylight_under_water(o).to_sun_world; })
      .def(
          "level_irradiance_below",
          [](const Optics& o) {
            const DaylightBelow below = daylight_under_water(o);
            return bands_out(below.beam_level + below.sky_level);
          },
          "Return the irradiance of daylight (3,) on a level surface just below a flat water surface, in units of\n"
          "the sun's irradiance outside the atmosphere.")
      .def(
          "sun_irradiance_below", [](const Optics& o) { return bands_out(daylight_under_water(o).beam_level); },
          "Return the sun's part (3,) of level_irradiance_below.");
}

}  // namespace uwsim::bindings
