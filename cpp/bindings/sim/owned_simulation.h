#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "bindings/core/gil.h"
#include "uwsim/core/check.h"
#include "uwsim/core/fork_safe_mutex.h"
#include "uwsim/sim/simulation.h"

namespace uwsim::bindings {

namespace py = pybind11;

inline constexpr std::uint64_t kStepsBetweenSignals = 2000;

/// A simulation that only one call at a time may use. Other calls wait with the GIL released.
class OwnedSimulation {
 public:
  OwnedSimulation(const World& world, std::shared_ptr<const RayScene> scene, const SimulationSpec& spec)
      : scene_(std::move(scene)), simulation_(std::make_shared<Simulation>(world, scene_, spec)) {}

  /// Wraps a member of a batch, including the member's vehicles and link. Must be used only while no call to the batch
  /// is running.
  explicit OwnedSimulation(std::shared_ptr<Simulation> member) : simulation_(std::move(member)) {}

  /// Returns call(simulation), called with the GIL released.
  template <typename Call>
  auto with(Call&& call) {
    const GilReleased unlocked;
    const std::lock_guard owned(mutex_);
    return call(*simulation_);
  }

  /// Returns call(simulation), for calls that take a few microseconds. Keeps the GIL unless another thread is using the
  /// simulation: if it were released, a waiting thread might acquire it, which would cost far more than the call
  /// itself.
  template <typename Call>
  auto with_briefly(Call&& call) {
    if (const std::unique_lock owned(mutex_, std::try_to_lock); owned) return call(*simulation_);
    return with(std::forward<Call>(call));
  }

  /// Adds a vehicle and returns its index.
  std::size_t add_vehicle(const VehicleSpec& spec) {
    return with([&](Simulation& sim) {
      vehicles_.reserve(vehicles_.size() + 1);
      const std::size_t index = sim.add_vehicle(spec);
      vehicles_.push_back(spec);
      return index;
    });
  }

  /// Adds an object and returns its index.
  std::size_t add_object(const ObjectSpec& spec) {
    return with([&](Simulation& sim) {
      objects_.reserve(objects_.size() + 1);
      const std::size_t index = sim.add_object(spec);
      objects_.push_back(spec);
      return index;
    });
  }

  /// Adds a tether and returns its index.
  std::size_t add_tether(const TetherSpec& spec) {
    return with([&](Simulation& sim) {
      tethers_.reserve(tethers_.size() + 1);
      const std::size_t index = sim.add_tether(spec);
      tethers_.push_back(spec);
      return index;
    });
  }

  /// See Simulation::set_link.
  void set_link(const LinkSpec& spec) {
    with([&](Simulation& sim) {
      sim.set_link(spec);
      link_ = spec;
    });
  }

  /// Restarts in `world` with `spec`, with the same vehicles at their start states. On error, throws without changing
  /// anything.
  void restart(const World& world, const SimulationSpec& spec) {
    require(scene_ != nullptr, "restart", "a member of a batch", "must be restarted by the batch");
    with([&](Simulation& old) {
      auto fresh = std::make_shared<Simulation>(world, scene_, spec);
      for (const VehicleSpec& vehicle : vehicles_) fresh->add_vehicle(vehicle);
      for (const ObjectSpec& object : objects_) fresh->add_object(object);
      for (const TetherSpec& tether : tethers_) fresh->add_tether(tether);
      if (link_) fresh->set_link(*link_);
      earlier_versions_ += old.version() + 1;
      previous_ = std::move(simulation_);
      simulation_ = std::move(fresh);
    });
  }

  /// See Simulation::change.
  void change(const Water& water, const SimulationSpec& spec, const std::vector<VehicleSpec>& vehicles) {
    with([&](Simulation& sim) {
      std::vector<VehicleSpec> kept = vehicles;
      sim.change(water, spec, vehicles);
      vehicles_ = std::move(kept);
    });
  }

  /// The simulation's version. Restarts never repeat a version.
  std::uint64_t version() {
    return with_briefly([&](Simulation& sim) { return earlier_versions_ + sim.version(); });
  }

  /// Advances in slices, so that Ctrl-C is handled, but does not let other calls run in between.
  void step(std::uint64_t count) {
    with([&](Simulation& sim) {
      for (; count > kStepsBetweenSignals; count -= kStepsBetweenSignals) {
        sim.step(kStepsBetweenSignals);
        const GilTaken locked;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      }
      sim.step(count);
    });
  }

 private:
  ForkSafeMutex<std::recursive_mutex> mutex_;  // recursive: a signal handler that runs between slices may also call
  std::shared_ptr<const RayScene> scene_;
  std::vector<VehicleSpec> vehicles_;
  std::vector<ObjectSpec> objects_;
  std::vector<TetherSpec> tethers_;
  std::optional<LinkSpec> link_;
  std::shared_ptr<Simulation> simulation_;
  // The simulation before the last restart, kept alive because a signal handler may restart the simulation during a
  // ping
  std::shared_ptr<Simulation> previous_;
  std::uint64_t earlier_versions_ = 0;
};

}  // namespace uwsim::bindings
