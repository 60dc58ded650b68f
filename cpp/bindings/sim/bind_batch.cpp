#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bindings/core/arrays.h"
#include "bindings/core/gil.h"
#include "bindings/sim/binders.h"
#include "uwsim/core/fork_safe_mutex.h"
#include "uwsim/sim/batch.h"

namespace uwsim::bindings {
namespace {

constexpr std::uint64_t kMemberStepsBetweenSignals = 20000;

/// Returns the data of an array that receives results. Refuses the array unless it is C-ordered, writeable and has
/// `size` elements.
template <typename T>
using Out = py::array_t<T, py::array::c_style>;

template <typename T>
T* room(Out<T>& array, std::size_t size, const char* name) {
  require(static_cast<std::size_t>(array.size()) == size, std::string(name) + ".size", array.size(),
          "must be " + std::to_string(size));
  return array.mutable_data();  // throws if it is read-only
}

std::span<const double> flat(const DoubleArray& rows) { return {rows.data(), static_cast<std::size_t>(rows.size())}; }

std::uint8_t* as_bytes(bool* flags) { return reinterpret_cast<std::uint8_t*>(flags); }

/// A batch that only one call at a time may use. Other calls wait with the GIL released.
class OwnedBatch {
 public:
  OwnedBatch(const World& world, std::shared_ptr<const RayScene> scene, std::vector<MemberSpec> members, int threads)
      : batch_(without_gil([&] { return Batch(world, std::move(scene), std::move(members), threads); })) {}

  /// Returns call(batch), called with the GIL released.
  template <typename Call>
  auto with(Call&& call) {
    const GilReleased unlocked;
    const std::lock_guard owned(mutex_);
    return call(batch_);
  }

  void step(std::uint64_t count) {
    in_slices(count, [&](Batch& batch, std::uint64_t, std::uint64_t now) { batch.step(now); });
  }

  void step_each(const std::vector<std::uint64_t>& counts) {
    std::vector<std::uint64_t> now_each(counts.size());
    const std::uint64_t most = counts.empty() ? 0 : *std::ranges::max_element(counts);
    in_slices(most, [&](Batch& batch, std::uint64_t done, std::uint64_t now) {
      for (std::size_t k = 0; k < counts.size(); ++k)
        now_each[k] = std::min(counts[k] - std::min(counts[k], done), now);
      batch.step_each(now_each);
    });
  }

 private:
  /// Calls advance(batch, done, now) until `count` steps are done, in slices, so that Ctrl-C is handled. If a member
  /// throws, the others still run to the end.
  template <typename Advance>
  void in_slices(std::uint64_t count, const Advance& advance) {
    with([&](Batch& batch) {
      std::exception_ptr error;
      const std::uint64_t slice = std::max<std::uint64_t>(1, kMemberStepsBetweenSignals / batch.size());
      for (std::uint64_t done = 0; done < count;) {
        const std::uint64_t now = std::min(count - done, slice);
        try {
          advance(batch, done, now);
        } catch (const InvalidValue&) {
          if (!error) error = std::current_exception();
        }
        done += now;
        const GilTaken locked;
        if (done < count && PyErr_CheckSignals() != 0) throw py::error_already_set();
      }
      if (error) std::rethrow_exception(error);
    });
  }

  ForkSafeMutex<std::recursive_mutex> mutex_;  // recursive: a signal handler that runs between slices may also call
  Batch batch_;
};

std::vector<std::size_t> checked(std::vector<std::size_t> members, const Batch& batch) {
  for (const std::size_t k : members) require(k < batch.size(), "members", k, "must be below the batch's size");
  return members;
}

void set_member_states(OwnedBatch& owned, std::size_t vehicle, std::vector<std::size_t> members,
                       const std::vector<BodyState>& states) {
  owned.with([&](Batch& b) { b.set_states(vehicle, checked(std::move(members), b), states); });
}

void write_motion(OwnedBatch& owned, std::size_t vehicle, Out<std::uint64_t> times_ns, Out<double> positions_world_m,
                  Out<double> orientations_xyzw, Out<double> velocities_body, Out<std::uint64_t> collisions,
                  Out<bool> released) {
  const std::size_t n = owned.with([](Batch& b) { return b.size(); });
  const MotionRows rows{room(times_ns, n, "times_ns"),
                        room(positions_world_m, 3 * n, "positions_world_m"),
                        room(orientations_xyzw, 4 * n, "orientations_xyzw"),
                        room(velocities_body, 6 * n, "velocities_body"),
                        room(collisions, n, "collisions"),
                        as_bytes(room(released, n, "released"))};
  owned.with([&](Batch& b) { b.motion(vehicle, rows); });
}

void write_samples(OwnedBatch& owned, std::size_t vehicle, std::size_t sensor, bool with_noise, Out<double> values,
                   Out<std::uint64_t> stamps_ns, Out<bool> valid) {
  const auto [n, width] = owned.with([&](Batch& b) { return std::pair(b.size(), b.reading_width(vehicle, sensor)); });
  const SampleRows rows{room(values, n * width, "values"), room(stamps_ns, n, "stamps_ns"),
                        as_bytes(room(valid, n, "valid"))};
  owned.with([&](Batch& b) { b.read_sensor(vehicle, sensor, with_noise, rows); });
}

std::size_t fans(OwnedBatch& owned, std::size_t vehicle, std::size_t sonar) {
  return owned.with([&](Batch& b) { return b.size() * b.member(0)->sonar(vehicle, sonar).multibeam().beams(); });
}

std::size_t heads(OwnedBatch& owned) {
  return owned.with([](Batch& b) { return 16 * b.size(); });
}

void write_pings(OwnedBatch& owned, std::size_t vehicle, std::size_t sonar, Out<float> ranges_m,
                 Out<float> points_sonar_m, Out<float> incidence_rad, Out<float> intensity_db, Out<Label> labels,
                 Out<bool> valid, Out<double> world_from_sonar) {
  const std::size_t beams = fans(owned, vehicle, sonar);
  const PingRows rows{room(ranges_m, beams, "ranges_m"),
                      room(points_sonar_m, 3 * beams, "points_sonar_m"),
                      room(incidence_rad, beams, "incidence_rad"),
                      room(intensity_db, beams, "intensity_db"),
                      room(labels, beams, "labels"),
                      as_bytes(room(valid, beams, "valid"))};
  double* const poses = room(world_from_sonar, heads(owned), "world_from_sonar");
  owned.with([&](Batch& b) { b.ping(vehicle, sonar, rows, poses); });
}

void write_acoustic_pings(OwnedBatch& owned, std::size_t vehicle, std::size_t sonar, Out<float> ranges_m,
                          Out<float> points_sonar_m, Out<float> incidence_rad, Out<float> intensity_db,
                          Out<Label> labels, Out<bool> valid, Out<float> snr_db, Out<float> travel_time_s,
                          Out<float> deviation_m, Out<float> vertical_deviation_m, Out<float> horizontal_deviation_m,
                          Out<std::uint8_t> detections, Out<double> world_from_sonar) {
  const std::size_t beams = fans(owned, vehicle, sonar);
  const AcousticRows rows{{room(ranges_m, beams, "ranges_m"), room(points_sonar_m, 3 * beams, "points_sonar_m"),
                           room(incidence_rad, beams, "incidence_rad"), room(intensity_db, beams, "intensity_db"),
                           room(labels, beams, "labels"), as_bytes(room(valid, beams, "valid"))},
                          room(snr_db, beams, "snr_db"),
                          room(travel_time_s, beams, "travel_time_s"),
                          room(deviation_m, beams, "deviation_m"),
                          room(vertical_deviation_m, beams, "vertical_deviation_m"),
                          room(horizontal_deviation_m, beams, "horizontal_deviation_m"),
                          room(detections, beams, "detections")};
  double* const poses = room(world_from_sonar, heads(owned), "world_from_sonar");
  owned.with([&](Batch& b) { b.acoustic_ping(vehicle, sonar, rows, poses); });
}

}  // namespace

void bind_batch(py::module_& m) {
  py::class_<MemberSpec>(m, "MemberSpec",
                         "Everything from which one simulation of a batch is built, apart from terrain and solids.")
      .def(
          py::init([](const Water& water, const SimulationSpec& simulation,
                      const std::vector<std::shared_ptr<VehicleSpec>>& vehicles, const std::optional<LinkSpec>& link,
                      const std::vector<std::shared_ptr<ObjectSpec>>& objects, const std::vector<TetherSpec>& tethers) {
            return MemberSpec{
                water, simulation, {vehicles.begin(), vehicles.end()}, link, {objects.begin(), objects.end()}, tethers};
          }),
          py::arg("water"), py::arg("simulation"), py::arg("vehicles"), py::arg("link") = py::none(),
          py::arg("objects") = std::vector<std::shared_ptr<ObjectSpec>>{},
          py::arg("tethers") = std::vector<TetherSpec>{},
          "vehicles, objects: shared, not copied; they must not be changed afterwards.");

  py::class_<OwnedBatch>(
      m, "Batch",
      "Simulations of one world, advanced and read together. Arrays that receive results are C-ordered, with\n"
      "one row per member; results do not depend on the number of threads. Calls release the GIL and raise\n"
      "ValueError naming the member, as batch[3].")
      .def(py::init<const World&, std::shared_ptr<RayScene>, std::vector<MemberSpec>, int>(), py::arg("world"),
           py::arg("scene").none(false), py::arg("members"), py::arg("threads"))
      .def(
          "restart",
          [](OwnedBatch& o, std::vector<std::size_t> members, std::vector<MemberSpec> specs) {
            o.with([&](Batch& b) { b.restart(checked(std::move(members), b), std::move(specs)); });
          },
          py::arg("members"), py::arg("specs") = std::vector<MemberSpec>{},
          "Restart members, with new specs if any are given. Raises ValueError without changing anything.")
      .def(
          "release",
          [](OwnedBatch& o, std::size_t vehicle, std::vector<std::size_t> members) {
            o.with([&](Batch& b) { b.release(vehicle, checked(std::move(members), b)); });
          },
          py::arg("vehicle"), py::arg("members"))
      .def("set_states", &set_member_states, py::arg("vehicle"), py::arg("members"), py::arg("states"))
      .def(
          "set_efforts",
          [](OwnedBatch& o, std::size_t vehicle, const py::object& efforts) {
            const auto rows = as_array<double>(efforts, "efforts", {-1, 6});
            o.with([&](Batch& b) { b.set_efforts(vehicle, flat(rows)); });
          },
          py::arg("vehicle"), py::arg("efforts"),
          "Set efforts (n, 6), each in [-1, 1]. Raises ValueError without changing anything.")
      .def(
          "set_wrenches",
          [](OwnedBatch& o, std::size_t vehicle, const py::object& wrenches_body) {
            const auto rows = as_array<double>(wrenches_body, "wrenches_body", {-1, 6});
            o.with([&](Batch& b) { b.set_wrenches(vehicle, flat(rows)); });
          },
          py::arg("vehicle"), py::arg("wrenches_body"), "Set wrenches (n, 6) [N, N m]. Raises ValueError.")
      .def(
          "set_thrusters",
          [](OwnedBatch& o, std::size_t vehicle, const std::vector<std::string>& names, const py::object& commands) {
            const auto rows = as_array<double>(commands, "commands", {-1, static_cast<py::ssize_t>(names.size())});
            o.with([&](Batch& b) { b.set_thrusters(vehicle, names, flat(rows)); });
          },
          py::arg("vehicle"), py::arg("names"), py::arg("commands"),
          "Set thruster commands (n, names), each in [-1, 1]; the others stop. Raises ValueError, after the other\n"
          "members have been commanded.")
      .def(
          "set_fins",
          [](OwnedBatch& o, std::size_t vehicle, const std::vector<std::string>& names, const py::object& angles_rad) {
            const auto rows = as_array<double>(angles_rad, "angles_rad", {-1, static_cast<py::ssize_t>(names.size())});
            o.with([&](Batch& b) { b.set_fins(vehicle, names, flat(rows)); });
          },
          py::arg("vehicle"), py::arg("names"), py::arg("angles_rad"),
          "Set fin deflections (n, names) [rad]; the others are centred. Raises ValueError, after the other members\n"
          "have been commanded.")
      .def("step", &OwnedBatch::step, py::arg("count") = 1,
           "Advance all members by fixed steps. Can be interrupted by Ctrl-C.")
      .def("step_each", &OwnedBatch::step_each, py::arg("counts"),
           "Advance each member by its own number of steps, (n,). Can be interrupted by Ctrl-C.")
      .def("motion", &write_motion, py::arg("vehicle"), py::arg("times_ns").noconvert(),
           py::arg("positions_world_m").noconvert(), py::arg("orientations_xyzw").noconvert(),
           py::arg("velocities_body").noconvert(), py::arg("collisions").noconvert(), py::arg("released").noconvert())
      .def("read_sensor", &write_samples, py::arg("vehicle"), py::arg("sensor"), py::arg("with_noise"),
           py::arg("values").noconvert(), py::arg("stamps_ns").noconvert(), py::arg("valid").noconvert())
      .def(
          "in_physics_mode",
          [](OwnedBatch& o, std::size_t vehicle, std::size_t sonar) {
            return o.with([&](Batch& b) {
              std::vector<bool> modes;
              for (std::size_t k = 0; k < b.size(); ++k)
                modes.push_back(b.member(k)->sonar(vehicle, sonar).in_physics_mode());
              return modes;
            });
          },
          py::arg("vehicle"), py::arg("sonar"), "Return, for each member, whether its sonar is in physics mode.")
      .def(
          "beams",
          [](OwnedBatch& o, std::size_t vehicle, std::size_t sonar) {
            return o.with([&](Batch& b) { return b.member(0)->sonar(vehicle, sonar).multibeam().beams(); });
          },
          py::arg("vehicle"), py::arg("sonar"), "Return the number of beams of the first member's sonar.")
      .def("ping", &write_pings, py::arg("vehicle"), py::arg("sonar"), py::arg("ranges_m").noconvert(),
           py::arg("points_sonar_m").noconvert(), py::arg("incidence_rad").noconvert(),
           py::arg("intensity_db").noconvert(), py::arg("labels").noconvert(), py::arg("valid").noconvert(),
           py::arg("world_from_sonar").noconvert(), "Ping in geometry mode.")
      .def("acoustic_ping", &write_acoustic_pings, py::arg("vehicle"), py::arg("sonar"),
           py::arg("ranges_m").noconvert(), py::arg("points_sonar_m").noconvert(), py::arg("incidence_rad").noconvert(),
           py::arg("intensity_db").noconvert(), py::arg("labels").noconvert(), py::arg("valid").noconvert(),
           py::arg("snr_db").noconvert(), py::arg("travel_time_s").noconvert(), py::arg("deviation_m").noconvert(),
           py::arg("vertical_deviation_m").noconvert(), py::arg("horizontal_deviation_m").noconvert(),
           py::arg("detections").noconvert(), py::arg("world_from_sonar").noconvert(),
           "Ping in physics mode. Raises ValueError in geometry mode.")
      .def(
          "member",
          [](OwnedBatch& o, std::size_t index) {
            return std::make_unique<OwnedSimulation>(
                o.with([&](Batch& b) { return b.member(checked({index}, b).front()); }));
          },
          py::arg("index"),
          "Return a member, valid until it is restarted. Must be used only while no call to the batch is running;\n"
          "a member cannot be restarted separately.");
}

}  // namespace uwsim::bindings
