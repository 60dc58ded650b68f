#include "bind.h"
#include "uwsim/core/check.h"

namespace uwsim::bindings {

void bind_core(pybind11::module_&) {
  // InvalidValue is a std::invalid_argument, which pybind11 already turns into ValueError.
  pybind11::register_local_exception_translator([](std::exception_ptr p) {  // by value: pybind11's signature
    try {
      if (p) std::rethrow_exception(p);
    } catch (const FileError& error) {
      // A path may be of any bytes; Python's own convention carries them.
      const pybind11::object message =
          pybind11::reinterpret_steal<pybind11::object>(PyUnicode_DecodeFSDefault(error.what()));
      PyErr_SetObject(PyExc_OSError, message.ptr());
    }
  });
}

}  // namespace uwsim::bindings
