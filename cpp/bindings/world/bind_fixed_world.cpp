#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bindings/core/arrays.h"
#include "bindings/world/binders.h"
#include "uwsim/world/world.h"

namespace uwsim::bindings {

/// A FixedWater object, which Python's stubs declare as Water, as for World.water.
struct WaterObject : py::object {
  explicit WaterObject(py::object water) : py::object(std::move(water)) {}
};

}  // namespace uwsim::bindings

template <>
struct pybind11::detail::handle_type_name<uwsim::bindings::WaterObject> {
  static constexpr auto name = const_name("uwsim._core.Water");
};

namespace uwsim::bindings {
namespace {

/// The world of a running simulator, including its water. Physics and rays use copies of it, so a change here would
/// have no effect; setting an attribute therefore raises AttributeError.
struct FixedWorld : World {
  explicit FixedWorld(const World& world) : World(world) {}
};
struct FixedWater : Water {
  explicit FixedWater(const Water& water) : Water(water) {}
};

[[noreturn]] void refuse(const std::string& change) {
  throw py::attribute_error(change +
                            ": a running simulator's world is fixed: change the scenario, and make a simulator");
}

/// Replaces Python's object.__setattr__ for a class whose attributes are fixed.
template <typename Class>
auto refuse_assignments(const std::string& owner) {
  return [owner](Class&, const std::string& name, const py::object&) { refuse(owner + "." + name); };
}

}  // namespace

void bind_fixed_world(py::module_& m) {
  py::class_<FixedWater, Water>(m, "FixedWater", "The water of a running simulator: Water that cannot be changed.")
      .def("__setattr__", refuse_assignments<FixedWater>("water"), py::arg("name"), py::arg("value"))
      .def(
          "add_current", [](FixedWater&, const std::shared_ptr<Current>&) { refuse("water.add_current"); },
          py::arg("current"), "Raise AttributeError.")
      .def_property(
          "current_world_m_s",
          [](const FixedWater& water) { return read_only(py::array_t<double>(3, water.current_world_m_s.data())); },
          [](FixedWater&, const py::object&) { refuse("water.current_world_m_s"); }, "(3,), read-only.");

  py::class_<FixedWorld, World, std::shared_ptr<FixedWorld>> world(
      m, "FixedWorld", "The world of a running simulator: a World that cannot be changed.");
  world.def(py::init<const World&>(), py::arg("world"))
      .def("__setattr__", refuse_assignments<FixedWorld>("world"), py::arg("name"), py::arg("value"))
      .def_property(
          "water", [](const FixedWorld& world) { return WaterObject(py::cast(FixedWater(world.water))); },
          [](FixedWorld&, const Water&) { refuse("world.water"); }, "Read-only.")
      .def(
          "set_terrain", [](FixedWorld&, const py::object&, double, const py::object&) { refuse("world.set_terrain"); },
          py::arg("heights_m"), py::arg("spacing_m"), py::arg("origin_m"), "Raise AttributeError.")
      .def(
          "add_solid",
          [](FixedWorld&, std::string, const py::object&, const py::object&, std::vector<RoundShape>) -> Label {
            refuse("world.add_solid");
          },
          py::arg("name"), py::arg("vertices_world_m"), py::arg("triangles"),
          py::arg("shapes") = std::vector<RoundShape>(), "Raise AttributeError.");
  def_add_cover(
      world,
      [](FixedWorld&, const std::string&, const std::vector<std::pair<py::object, py::object>>&, const std::string&,
         double, double, const Pair&, double, const Pair&, const Pair&, const Pair&, double, double, std::uint64_t,
         bool, double, double) -> Label { refuse("world.add_cover"); },
      "Raise AttributeError.");
  def_add_school(
      world,
      [](FixedWorld&, const std::string&, std::size_t,
         const std::vector<std::vector<std::pair<py::object, py::object>>>&, const Eigen::Vector3d&, double, double,
         const Eigen::Vector3d&, double, double, std::uint64_t) { refuse("world.add_school"); },
      "Raise AttributeError.");
  def_add_plume(
      world,
      [](FixedWorld&, const std::string&, std::size_t,
         const std::vector<std::vector<std::pair<py::object, py::object>>>&, const Eigen::Vector3d&, double,
         const Eigen::Vector3d&, std::uint64_t) { refuse("world.add_plume"); },
      "Raise AttributeError.");
}

}  // namespace uwsim::bindings
