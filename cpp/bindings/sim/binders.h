#pragma once

#include "bindings/sim/owned_simulation.h"

/// Methods of a simulation that are bound in separate files.
namespace uwsim::bindings {

/// The instrument panel and the battery's monitor.
void bind_telemetry(py::module_& m, py::class_<OwnedSimulation>& simulation);
/// Commands to a vehicle's actuators, and their state.
void bind_commands(py::class_<OwnedSimulation>& simulation);
/// Loose bodies, and wrenches that act on vehicles.
void bind_object_spec(py::module_& m);
/// The forces on vehicles and objects.
void bind_forces(py::module_& m, py::class_<OwnedSimulation>& simulation);
/// Tethers.
void bind_tether_spec(py::module_& m);
void bind_tether(py::module_& m, py::class_<OwnedSimulation>& simulation);
/// Arms.
void bind_arm_link(py::module_& m);
void bind_arm(py::module_& m, py::class_<OwnedSimulation>& simulation);
/// Sonar heads and their pings in both modes.
void bind_pings(py::module_& m, py::class_<OwnedSimulation>& simulation);
/// The link between station and vehicles.
void bind_link(py::module_& m, py::class_<OwnedSimulation>& simulation);
/// Many simulations of one world.
void bind_batch(py::module_& m);

}  // namespace uwsim::bindings
