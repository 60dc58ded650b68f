#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/typing.h>

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bindings/core/arrays.h"

namespace uwsim::bindings {

/// A record's fields by name.
using Fields = py::typing::Dict<py::str, py::object>;

/// Exposes a result type to Python: its fields are read-only, and to_dict(), copying and pickling are derived from
/// them.
template <typename T>
class Record {
 public:
  template <typename... Extra>
  Record(py::module_& m, const char* name, const char* doc, const Extra&... extra) : class_(m, name, doc, extra...) {}

  template <typename Base, typename Member>
  Record& field(const char* name, Member Base::*member, const char* doc = "") {
    class_.def_readonly(name, member, doc);
    fields_.push_back({name, [member](T& value, const py::object& given) {
                         value.*member = given.cast<Member>();
                         if constexpr (std::is_same_v<Member, py::array>) forbid_writing(value.*member);
                       }});
    return *this;
  }

  /// Sets a short description for people, such as "Ping(400 beams, ...)".
  Record& described_by(std::string (*describe)(const T&)) {
    class_.def("__repr__", describe);
    is_described_ = true;
    return *this;
  }

  /// Sets the Python module that draws the picture shown in notebooks. It is imported on demand; its plot() returns a
  /// matplotlib figure.
  Record& drawn_by(const char* module) {
    class_
        .def(
            "plot", [module](const py::object& self) { return py::module_::import(module).attr("plot")(self); },
            "Return a matplotlib Figure of this object.")
        .def("_repr_png_", [module](const py::object& self) { return py::module_::import(module).attr("png")(self); });
    return *this;
  }

  py::class_<T>& done() {
    if (!is_described_) {
      std::vector<std::string> names;
      for (const auto& field : fields_) names.push_back(field.name);
      class_.def("__repr__", [names](const py::object& self) {
        return py::module_::import("uwsim.base.short_repr").attr("described")(self, names).cast<std::string>();
      });
    }
    class_
        .def(
            "to_dict", [fields = fields_](const py::object& self) { return as_dict(fields, self); },
            "Return the fields by name; arrays are not copied.")
        .def("__copy__", [](const py::object& self) { return self; })
        .def(
            "__deepcopy__", [](const py::object& self, const py::object&) { return self; }, py::arg("memo"))
        .def(py::pickle([fields = fields_](const py::object& self) { return as_dict(fields, self); },
                        [fields = fields_](const Fields& state) {
                          T value{};
                          for (const Field& field : fields) field.set(value, state[field.name]);
                          return value;
                        }));
    return class_;
  }

 private:
  struct Field {
    const char* name;
    std::function<void(T&, const py::object&)> set;
  };

  static Fields as_dict(const std::vector<Field>& fields, const py::object& self) {
    Fields all;
    for (const Field& field : fields) all[field.name] = self.attr(field.name);
    return all;
  }

  py::class_<T> class_;
  std::vector<Field> fields_;
  bool is_described_ = false;
};

}  // namespace uwsim::bindings
