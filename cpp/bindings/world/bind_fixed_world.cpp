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

/// A FixedWater whose type in Python's stubs is Water, as World.water's is.
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

/// The world of a running simulator, and its water. Physics and rays work with copies, so that a change here would have
/// no effect: it raises AttributeError instead.
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

/// A property that can be read but whose assignment explains why it is refused.
template <typename Class, typename Get>
void fixed(py::class_<Class, Water>& owner, const char* name, Get get, const char* doc = "") {
  owner.def_property(
      name, get, [name](Class&, const py::object&) { refuse(std::string("water.") + name); }, doc);
}

template <typename Member>
auto value(Member Water::*member) {
  return [member](const FixedWater& water) { return water.*member; };
}

}  // namespace

void bind_fixed_world(py::module_& m) {
  py::class_<FixedWater, Water> water(m, "FixedWater",
                                      "The water of a running simulator: Water that cannot be changed.");
  water.def(
      "add_current", [](FixedWater&, const py::object&) { refuse("water.add_current"); }, py::arg("current"));
  fixed(water, "density_kg_m3", [](const FixedWater& w) { return w.density_kg_m3; });
  fixed(water, "gravity_m_s2", [](const FixedWater& w) { return w.gravity_m_s2; });
  fixed(water, "atmospheric_pressure_pa", value(&Water::atmospheric_pressure_pa));
  fixed(water, "surface_temperature_deg_c", value(&Water::surface_temperature_deg_c));
  fixed(water, "bottom_temperature_deg_c", value(&Water::bottom_temperature_deg_c));
  fixed(water, "bottom_depth_m", value(&Water::bottom_depth_m));
  fixed(water, "salinity_psu", value(&Water::salinity_psu));
  fixed(
      water, "current_world_m_s",
      [](const FixedWater& w) {
        const Eigen::Vector3d& current = w.current_world_m_s;
        return read_only(py::array_t<double>(3, current.data()));
      },
      "(3,), read-only");
  fixed(
      water, "waves", [](const FixedWater& w) { return std::const_pointer_cast<Waves>(w.waves); },
      "None: a flat surface");
  fixed(
      water, "profile", [](const FixedWater& w) { return std::const_pointer_cast<WaterProfile>(w.profile); },
      "None: one density and salinity, temperature linear down to bottom_depth_m");

  py::class_<FixedWorld, World, std::shared_ptr<FixedWorld>>(
      m, "FixedWorld", "The world of a running simulator: a World that cannot be changed.")
      .def(py::init<const World&>(), py::arg("world"))
      .def_property(
          "water", [](const FixedWorld& world) { return WaterObject(py::cast(FixedWater(world.water))); },
          [](FixedWorld&, const Water&) { refuse("world.water"); }, "Read-only.")
      .def(
          "set_terrain", [](FixedWorld&, const py::object&, double, const py::object&) { refuse("world.set_terrain"); },
          py::arg("heights_m"), py::arg("spacing_m"), py::arg("origin_m"), "Raises AttributeError.")
      .def(
          "add_solid",
          [](FixedWorld&, std::string, const py::object&, const py::object&, std::vector<RoundShape>) -> Label {
            refuse("world.add_solid");
          },
          py::arg("name"), py::arg("vertices_world_m"), py::arg("triangles"),
          py::arg("shapes") = std::vector<RoundShape>(), "Raises AttributeError.");
}

}  // namespace uwsim::bindings
