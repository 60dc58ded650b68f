#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <map>
#include <string>
#include <utility>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/parameters.h"
#include "bindings/sensors/sensor_reading.h"
#include "uwsim/sensors/sensor_kinds.h"

namespace uwsim::bindings {
namespace {

using Parts = py::typing::Dict<py::str, py::typing::Tuple<py::int_, py::str>>;

/// Returns {name: (width, unit)}, in the order of the items.
template <typename Part>
Parts parts(std::span<const Part> items) {
  Parts named;
  for (const Part& item : items) {
    named[py::str(std::string(item.name))] = py::make_tuple(item.width, std::string(item.unit));
  }
  return named;
}

void bind_kinds(py::module_& m) {
  py::class_<SensorKind, std::unique_ptr<SensorKind, py::nodelete>>(m, "SensorKind", "A kind of sensor.")
      .def_property_readonly("name", [](const SensorKind& k) { return std::string(k.name); })
      .def_property_readonly("meaning", [](const SensorKind& k) { return std::string(k.meaning); })
      .def_property_readonly(
          "fields", [](const SensorKind& k) { return parts(k.fields); }, "{name: (width, unit)} of a reading's fields")
      .def_property_readonly(
          "channels", [](const SensorKind& k) { return parts(k.channels); },
          "{name: (width, unit)} of the quantities to which noise is added")
      .def_property_readonly(
          "parameters", [](const SensorKind& k) { return by_name(k.parameters); }, "{name: Parameter}");
  m.def(
      "sensor_kinds", [] { return kind_names(sensor_kinds()); }, "Return the built-in kinds of sensor.");
  m.def(
      "sensor_kind", [](const std::string& name) { return &sensor_kind(name); }, py::arg("name"),
      py::return_value_policy::reference, "Return the kind with this name. Raises ValueError listing the known names.");
}

void bind_noise(py::module_& m) {
  const NoiseSpec none;
  py::class_<NoiseSpec>(
      m, "NoiseSpec",
      "Errors of one channel of a sensor, in its unit u: white noise (std per sample, density in u per root\n"
      "hertz), turn_on_std, a Gauss-Markov bias (bias_std, bias_time_s), walk (u per root second), instability "
      "(flicker noise), quantum,\n"
      "limits. 0 disables an error.")
      .def(py::init([](double std, double density, double turn_on_std, double bias_std, double bias_time_s, double walk,
                       double instability, double quantum, double limit_low, double limit_high) {
             return NoiseSpec{std,  density,     turn_on_std, bias_std,  bias_time_s,
                              walk, instability, quantum,     limit_low, limit_high};
           }),
           py::kw_only(), py::arg("std") = 0.0, py::arg("density") = 0.0, py::arg("turn_on_std") = 0.0,
           py::arg("bias_std") = 0.0, py::arg("bias_time_s") = 0.0, py::arg("walk") = 0.0, py::arg("instability") = 0.0,
           py::arg("quantum") = 0.0, py::arg("limit_low") = none.limit_low, py::arg("limit_high") = none.limit_high)
      .def_readonly("std", &NoiseSpec::std)
      .def_readonly("density", &NoiseSpec::density)
      .def_readonly("turn_on_std", &NoiseSpec::turn_on_std)
      .def_readonly("limit_low", &NoiseSpec::limit_low)
      .def_readonly("limit_high", &NoiseSpec::limit_high)
      .def_readonly("bias_std", &NoiseSpec::bias_std)
      .def_readonly("bias_time_s", &NoiseSpec::bias_time_s)
      .def_readonly("walk", &NoiseSpec::walk)
      .def_readonly("instability", &NoiseSpec::instability, "the flat part of the Allan deviation")
      .def_property_readonly(
          "flicker_std", [](const NoiseSpec& n) { return NoiseSpec::kFlickerStd * n.instability; },
          "standard deviation of the flicker noise")
      .def_readonly("quantum", &NoiseSpec::quantum);
}

}  // namespace

SensorReading sensor_reading(const SensorKind& kind, const Sample& sample) {
  SensorReading reading{{}, sample.stamp_ns, sample.valid};
  const double* next = sample.values.data();
  for (const Field& field : kind.fields) {
    const py::str name(field.name.data(), field.name.size());
    if (field.width == 1) {
      reading.values[name] = *next;
    } else {
      reading.values[name] = py::array_t<double>(field.width, next);
    }
    next += field.width;
  }
  return reading;
}

void bind_sensors(py::module_& m) {
  bind_kinds(m);
  bind_noise(m);
  py::class_<SensorSpec>(m, "SensorSpec")
      .def(py::init([](std::string name, std::string kind, const py::object& position_m,
                       const py::object& orientation_xyzw, std::map<std::string, std::vector<double>> parameters,
                       std::map<std::string, NoiseSpec> noise, double rate_hz, double latency_s, double drop_out) {
             SensorSpec spec;
             spec.name = std::move(name);
             spec.kind = std::move(kind);
             spec.body_from_sensor = as_pose(position_m, orientation_xyzw, "sensor");
             spec.parameters = {parameters.begin(), parameters.end()};
             spec.noise = {noise.begin(), noise.end()};
             spec.rate_hz = rate_hz;
             spec.latency_s = latency_s;
             spec.drop_out = drop_out;
             return spec;
           }),
           py::arg("name"), py::arg("kind"), py::arg("position_m"), py::arg("orientation_xyzw"), py::kw_only(),
           py::arg("parameters") = std::map<std::string, std::vector<double>>{},
           py::arg("noise") = std::map<std::string, NoiseSpec>{}, py::arg("rate_hz") = 0.0, py::arg("latency_s") = 0.0,
           py::arg("drop_out") = 0.0,
           "parameters: of the kind; noise: by channel; rate_hz: 0 for every step. Validated by\n"
           "Simulation.add_vehicle.")
      .def_readonly("name", &SensorSpec::name)
      .def_readonly("kind", &SensorSpec::kind)
      .def_readonly("rate_hz", &SensorSpec::rate_hz)
      .def_readonly("latency_s", &SensorSpec::latency_s)
      .def_readonly("drop_out", &SensorSpec::drop_out)
      .def_property_readonly(
          "position_m", [](const SensorSpec& s) { return s.body_from_sensor.position_m; }, "position on the body (3,)")
      .def_property_readonly(
          "orientation_xyzw",
          [](const SensorSpec& s) { return Eigen::Vector4d(s.body_from_sensor.orientation.coeffs()); },
          "(4,), body from sensor")
      .def_property_readonly(
          "noise",
          [](const SensorSpec& s) {
            return std::map<std::string, NoiseSpec>{s.noise.begin(), s.noise.end()};
          },
          "{channel: NoiseSpec} of the channels with errors.")
      .def_property_readonly(
          "parameters",
          [](const SensorSpec& s) {
            const ParameterValues values = completed(s, sensor_kind(s.kind)).parameters;
            return std::map<std::string, std::vector<double>>{values.begin(), values.end()};
          },
          "{name: values} of the kind's parameters, including defaults.");

  py::class_<SensorReading>(m, "SensorReading", "One sample of a sensor.")
      .def_readonly("values", &SensorReading::values, "{field: float or (n,) float64}")
      .def_readonly("stamp_ns", &SensorReading::stamp_ns, "time of the measurement")
      .def_readonly("valid", &SensorReading::valid);
}

}  // namespace uwsim::bindings
