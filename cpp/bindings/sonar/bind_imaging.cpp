#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <map>
#include <string>
#include <utility>

#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "bindings/core/parameters.h"
#include "bindings/sonar/angles.h"
#include "bindings/sonar/binders.h"
#include "uwsim/sonar/imaging/imaging_kinds.h"

namespace uwsim::bindings {
namespace {

using Arrays = py::typing::Dict<py::str, py::array_t<float>>;

Arrays imaging_ping(const ImagingSonar& sonar, const RayScene& scene, const Water& water, const py::object& positions_m,
                    const py::object& orientations_xyzw, std::uint64_t seed, const std::string& stream,
                    std::uint64_t first_ping, int threads, const py::object& angles_rad, bool with_labels) {
  const std::vector<Pose> poses = as_poses(positions_m, orientations_xyzw, "sonar");
  const std::vector<double> angles = as_angles(angles_rad);
  const RandomStream random(seed, stream);
  std::vector<ImagingArray> results;
  {
    const GilReleased unlocked;
    results = sonar.ping({scene, water, poses, angles, random, first_ping, threads, with_labels});
  }
  Arrays arrays;
  for (ImagingArray& result : results) {
    const std::vector<py::ssize_t> shape(result.shape.begin(), result.shape.end());
    arrays[py::str(result.name.data(), result.name.size())] = move_out(std::move(result.values), shape);
  }
  return arrays;
}

std::unique_ptr<ImagingSonar> checked_sonar(const std::string& kind, const std::map<std::string, double>& parameters,
                                            const std::vector<double>& strengths_db,
                                            const std::vector<BottomMaterial>& materials) {
  ParameterValues values;
  for (const auto& [name, value] : parameters) values[name] = {value};
  return imaging_sonar(kind, std::move(values), strengths_db, materials);
}

}  // namespace

void bind_imaging(py::module_& m) {
  py::class_<ImagingKind, std::unique_ptr<ImagingKind, py::nodelete>>(m, "ImagingKind", "A kind of imaging sonar.")
      .def_property_readonly("name", [](const ImagingKind& k) { return std::string(k.name); })
      .def_property_readonly("meaning", [](const ImagingKind& k) { return std::string(k.meaning); })
      .def_property_readonly(
          "parameters", [](const ImagingKind& k) { return by_name(imaging_parameters(k)); },
          "{name: Parameter}: the shared acoustic parameters and those of the kind.");
  m.def(
      "imaging_kinds", [] { return kind_names(imaging_kinds()); }, "Return the built-in kinds of imaging sonar.");
  m.def(
      "imaging_kind", [](const std::string& name) { return &imaging_kind(name); }, py::arg("name"),
      py::return_value_policy::reference, "Return the kind with this name. Raises ValueError listing the known names.");
  py::class_<ImagingSonar>(m, "ImagingSonar", "An imaging sonar; see uwsim.instruments.sonars.imaging.")
      .def(py::init(&checked_sonar), py::arg("kind"), py::arg("parameters"),
           py::arg("strengths_db") = std::vector<double>{}, py::arg("materials") = std::vector<BottomMaterial>{},
           "parameters: values by name, see ImagingKind.parameters. strengths_db: Lambert's strength by label; NaN\n"
           "selects the strength of the bottom or of solids. materials: by label; a material with a seabed scatters\n"
           "like that seabed, and all materials reflect sound that bounces more than once. Raises ValueError naming\n"
           "the parameter.")
      .def(
          "absorption_db_m",
          [](const ImagingSonar& s, const Water& water, double z_m) {
            return s.acoustics().absorption_db_m(water, z_m);
          },
          py::arg("water"), py::arg("head_z_m"), "Absorption in the water at the head [dB/m].")
      .def("ping", &imaging_ping, py::arg("scene"), py::arg("water"), py::arg("positions_m"),
           py::arg("orientations_xyzw"), py::arg("seed"), py::arg("stream"), py::arg("first_ping"),
           py::arg("threads") = 1, py::arg("angles_rad") = py::tuple(), py::arg("with_labels") = false,
           "Return the kind's float32 arrays by name, for pings from poses (n, 3) and (n, 4), world from sonar.\n"
           "angles_rad (m,): of a steered beam. Ping k has the number first_ping + k, which selects its noise.\n"
           "with_labels: also return the label of the surface with the strongest mean echo in each cell, 0 where no\n"
           "echo is above the noise. The result does not depend on the number of threads. Raises ValueError.\n"
           "Releases the GIL.");
}

}  // namespace uwsim::bindings
