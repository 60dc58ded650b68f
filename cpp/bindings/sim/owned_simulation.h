#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

#include "uwsim/sim/simulation.h"

namespace uwsim::bindings {

namespace py = pybind11;

inline constexpr std::uint64_t kStepsBetweenSignals = 2000;

/// A simulation that one call at a time owns. Other calls wait with the GIL released.
class OwnedSimulation {
 public:
  OwnedSimulation(const World& world, std::shared_ptr<const RayScene> scene, const SimulationSpec& spec)
      : simulation_(world, std::move(scene), spec) {}

  /// call(simulation), with the GIL released.
  template <typename Call>
  auto with(Call&& call) {
    const py::gil_scoped_release unlocked;
    const std::lock_guard owned(mutex_);
    return call(simulation_);
  }

  /// Steps in slices, so that Ctrl-C is answered, but keeps the simulation for itself throughout.
  void step(std::uint64_t count) {
    with([&](Simulation& sim) {
      while (count > 0) {
        const std::uint64_t slice = std::min(count, kStepsBetweenSignals);
        sim.step(slice);
        count -= slice;
        const py::gil_scoped_acquire locked;
        if (count > 0 && PyErr_CheckSignals() != 0) throw py::error_already_set();
      }
    });
  }

 private:
  std::recursive_mutex mutex_;  // recursive: a signal handler that runs between slices may call, too
  Simulation simulation_;
};

}  // namespace uwsim::bindings
