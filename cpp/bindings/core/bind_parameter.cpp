#include "bindings/core/binders.h"
#include "uwsim/core/parameter.h"

namespace uwsim::bindings {

namespace py = pybind11;

namespace {

const char* type_name(ParameterType type) {
  switch (type) {
    case ParameterType::kWholeNumber:
      return "whole number";
    case ParameterType::kFlag:
      return "flag";
    case ParameterType::kNumber:
      break;
  }
  return "number";
}

}  // namespace

void bind_parameter(py::module_& m) {
  py::class_<Parameter>(m, "Parameter", "A parameter of a kind of sensor or imaging sonar.")
      .def_readonly("width", &Parameter::width, "number of values")
      .def_readonly("by_default", &Parameter::by_default, "default of each value; NaN if the parameter is required")
      .def_readonly("low", &Parameter::low, "smallest value; the smallest positive number if 0 is excluded")
      .def_readonly("high", &Parameter::high)
      .def_property_readonly(
          "type", [](const Parameter& p) { return type_name(p.type); }, "\"number\", \"whole number\" or \"flag\"")
      .def_property_readonly("unit", [](const Parameter& p) { return std::string(p.unit); })
      .def_property_readonly("meaning", [](const Parameter& p) { return std::string(p.meaning); });
}

}  // namespace uwsim::bindings
