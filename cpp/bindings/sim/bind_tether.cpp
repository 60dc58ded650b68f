#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/core/record.h"
#include "bindings/sim/binders.h"
#include "uwsim/sim/tether_tubes.h"

namespace uwsim::bindings {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// A tether as it is.
struct TetherReading {
  Rows points_world_m;
  Eigen::VectorXd tensions_n;
  std::vector<Eigen::Vector3d> end_forces_n;
  double length_m, rate_m_s;
  std::optional<std::size_t> broken;
};

TetherReading reading(const Tether& tether) {
  const auto elements = static_cast<Eigen::Index>(tether.elements());
  TetherReading now{Rows(elements + 1, 3), Eigen::VectorXd(elements), {tether.end_force_n(0), tether.end_force_n(1)},
                    tether.length_m(),     tether.rate_m_s(),         tether.broken()};
  for (Eigen::Index k = 0; k <= elements; ++k)
    now.points_world_m.row(k) = tether.position_m(static_cast<std::size_t>(k)).transpose();
  for (Eigen::Index k = 0; k < elements; ++k) now.tensions_n(k) = tether.tension_n(static_cast<std::size_t>(k));
  return now;
}

using Triangles = Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

std::pair<Rows, Triangles> tube_of(const TetherSpec& spec) {
  const TriangleMesh mesh = tether_tube(spec);
  std::pair<Rows, Triangles> found{Rows(mesh.vertices_m.size(), 3), Triangles(mesh.triangles.size(), 3)};
  for (std::size_t k = 0; k < mesh.vertices_m.size(); ++k)
    found.first.row(static_cast<Eigen::Index>(k)) = mesh.vertices_m[k].transpose();
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto& [a, b, c] = mesh.triangles[k];
    found.second.row(static_cast<Eigen::Index>(k)) << a, b, c;
  }
  return found;
}

}  // namespace

void bind_tether_spec(py::module_& m) {
  py::class_<TetherEnd>(m, "TetherEnd", "Where a tether is fastened.")
      .def(py::init([](const Eigen::Vector3d& point_m, std::optional<std::uint64_t> body) {
             return TetherEnd{body.value_or(TetherEnd::kNoBody), point_m};
           }),
           py::arg("point_m"), py::arg("body") = py::none(),
           "point_m: (3,), in the frame of the vehicle or object with this index, or the world's.");
  py::class_<TetherSpec>(m, "TetherSpec", "A tether's parameters.")
      .def(py::init<>())
      .def_readwrite("name", &TetherSpec::name)
      .def_readwrite("first", &TetherSpec::first, "the winch's end")
      .def_readwrite("second", &TetherSpec::second)
      .def_readwrite("length_m", &TetherSpec::length_m)
      .def_readwrite("elements", &TetherSpec::elements)
      .def_readwrite("diameter_m", &TetherSpec::diameter_m)
      .def_readwrite("mass_kg_m", &TetherSpec::mass_kg_m)
      .def_readwrite("axial_stiffness_n", &TetherSpec::axial_stiffness_n)
      .def_readwrite("bending_stiffness_n_m2", &TetherSpec::bending_stiffness_n_m2)
      .def_readwrite("axial_damping_n_s", &TetherSpec::axial_damping_n_s)
      .def_readwrite("normal_drag", &TetherSpec::normal_drag)
      .def_readwrite("tangential_drag", &TetherSpec::tangential_drag)
      .def_readwrite("normal_added_mass", &TetherSpec::normal_added_mass)
      .def_readwrite("tangential_added_mass", &TetherSpec::tangential_added_mass)
      .def_readwrite("friction", &TetherSpec::friction)
      .def_readwrite("bed_stiffness_pa_m", &TetherSpec::bed_stiffness_pa_m)
      .def_readwrite("breaking_load_n", &TetherSpec::breaking_load_n)
      .def_readwrite("longest_m", &TetherSpec::longest_m, "0: the length")
      .def_readwrite("shortest_m", &TetherSpec::shortest_m, "0: one element")
      .def_readwrite("fastest_m_s", &TetherSpec::fastest_m_s, "0: there is no winch")
      .def_readwrite("strongest_n", &TetherSpec::strongest_n)
      .def_property_readonly("tubes", &TetherSpec::tubes, "as targets for rays, each with a label")
      .def(
          "tube", [](const TetherSpec& spec) { return tube_of(spec); },
          "Return vertices [m] (n, 3) and triangles (m, 3) of one of them, along z from its origin.");
}

void bind_tether(py::module_& m, py::class_<OwnedSimulation>& simulation) {
  Record<TetherReading>(m, "TetherReading", "A tether's shape, tension and length.")
      .field("points_world_m", &TetherReading::points_world_m, "(n + 1, 3): its nodes, from the winch")
      .field("tensions_n", &TetherReading::tensions_n, "(n,): of its elements")
      .field("end_forces_n", &TetherReading::end_forces_n, "of the tether on what holds its ends, world axes, (2, 3)")
      .field("length_m", &TetherReading::length_m, "out, without load")
      .field("rate_m_s", &TetherReading::rate_m_s, "paid out in the last step")
      .field("broken", &TetherReading::broken, "the element that has broken, or None")
      .done();
  simulation
      .def(
          "add_tether", [](OwnedSimulation& o, const TetherSpec& spec) { return o.add_tether(spec); }, py::arg("spec"),
          "Add a tether, after all vehicles and objects, lay it, and return its index. Raises ValueError.")
      .def(
          "tether",
          [](OwnedSimulation& o, std::size_t k) { return o.with([&](Simulation& s) { return reading(s.tether(k)); }); },
          py::arg("tether"))
      .def(
          "command_winch",
          [](OwnedSimulation& o, std::size_t k, std::optional<double> rate_m_s, std::optional<double> tension_n) {
            using Mode = WinchCommand::Mode;
            WinchCommand command;
            if (rate_m_s) command = {Mode::kRate, *rate_m_s};
            if (tension_n) command = {Mode::kTension, *tension_n};
            o.with([&](Simulation& s) { s.tether(k).command(command); });
          },
          py::arg("tether"), py::arg("rate_m_s") = py::none(), py::arg("tension_n") = py::none(),
          "Pay out at a rate, keep a tension, or, without either, hold. Raises ValueError.")
      .def(
          "cut_tether",
          [](OwnedSimulation& o, std::size_t k, double at_m) { o.with([&](Simulation& s) { s.tether(k).cut(at_m); }); },
          py::arg("tether"), py::arg("at_m"), "Cut it at this length from the winch. Raises ValueError.")
      .def(
          "weaken_tether",
          [](OwnedSimulation& o, std::size_t k, double load_n) {
            o.with([&](Simulation& s) { s.tether(k).weaken(load_n); });
          },
          py::arg("tether"), py::arg("load_n"),
          "From now on, break it also at this load, until a restart; states do not include it. Raises ValueError.");
}

}  // namespace uwsim::bindings
