#include "bindings/core/points.h"
#include "bindings/sonar/binders.h"
#include "uwsim/sonar/depth_string.h"

namespace uwsim::bindings {
namespace {

std::string_view utf8(const py::str& text) {
  Py_ssize_t size = 0;
  const char* data = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (!data) {
    PyErr_Clear();
    throw InvalidValue("depth_string: contains a lone surrogate, which is not a character");
  }
  return {data, static_cast<std::size_t>(size)};
}

}  // namespace

void bind_depth_string(py::module_& m) {
  m.def(
      "encode_depth_string",
      [](const py::object& ranges_m, double range_max_m) {
        const FloatArray ranges = as_float32(ranges_m, "ranges_m", {-1});
        return encode_depth_string(span_of(ranges), range_max_m);
      },
      py::arg("ranges_m"), py::arg("range_max_m"),
      "Return the published depthArray text: each range in C#'s G7 format, followed by the letter a.\n"
      "ranges_m: (n,) float32, in [0, range_max_m], or inf for no echo, which is written as range_max_m.\n"
      "Raises ValueError naming the beam for any other value.");
  m.def(
      "decode_depth_string",
      [](const py::str& text, std::size_t beams, double range_limit_m) {
        return move_out(decode_depth_string(utf8(text), beams, range_limit_m));
      },
      py::arg("text"), py::arg("beams"), py::arg("range_limit_m"),
      "Return the ranges of a depthArray text, (beams,) float32; values greater than range_limit_m become\n"
      "inf. Raises ValueError naming the beam unless the text consists of exactly `beams` plain decimals,\n"
      "each followed by a.");
}

}  // namespace uwsim::bindings
