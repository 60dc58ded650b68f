#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "bindings/core/gil.h"
#include "bindings/core/record.h"
#include "bindings/sim/binders.h"
#include "bindings/sim/owned_simulation.h"
#include "bindings/sonar/physics_ping.h"
#include "uwsim/core/parallel.h"

namespace uwsim::bindings {
namespace {

constexpr std::size_t kPingsBetweenSignals = 1024;
constexpr std::size_t kPingsPerBatch = 8;
constexpr double kWorldEnd_m = 1e6;

using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

/// A block of memory for the results of one or more pings, shared by the arrays created from it.
class PingMemory {
 public:
  PingMemory(std::size_t pings, std::size_t beams)
      : count_(pings * beams), bytes_(std::make_unique_for_overwrite<std::byte[]>(count_ * kBytesPerBeam)) {}

  PingRows rows() {
    const auto floats = reinterpret_cast<float*>(bytes_.get());
    const auto labels = reinterpret_cast<Label*>(floats + 6 * count_);
    return {floats,
            floats + count_,
            floats + 4 * count_,
            floats + 5 * count_,
            labels,
            reinterpret_cast<std::uint8_t*>(labels + count_)};
  }

 private:
  static constexpr std::size_t kBytesPerBeam = 6 * sizeof(float) + sizeof(Label) + 1;
  std::size_t count_;
  std::unique_ptr<std::byte[]> bytes_;
};

struct PingArrays {
  py::array ranges_m, points_sonar_m, incidence_rad, intensity_db, labels, valid;
};

template <typename T>
py::array view(std::vector<py::ssize_t> shape, const T* data, const py::capsule& owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), data, owner);
  forbid_writing(array);
  return array;
}

PingArrays arrays_of(std::unique_ptr<PingMemory> memory, const std::vector<py::ssize_t>& shape) {
  const PingRows rows = memory->rows();
  const py::capsule owner(memory.release(), [](void* p) { delete static_cast<PingMemory*>(p); });
  std::vector<py::ssize_t> with_xyz = shape;
  with_xyz.push_back(3);
  return {view(shape, rows.ranges_m, owner),      view(with_xyz, rows.points_sonar_m, owner),
          view(shape, rows.incidence_rad, owner), view(shape, rows.intensity_db, owner),
          view(shape, rows.labels, owner),        view(shape, reinterpret_cast<const bool*>(rows.valid), owner)};
}

struct Ping : PingArrays {
  int model = 0;
  std::uint64_t time_ns = 0;
  Eigen::Matrix4d world_from_sonar;
  py::array angles_rad;
};

struct PingBatch : PingArrays {
  int model = 0;
  py::array world_from_sonar, angles_rad;
};

using SomePings = py::typing::List<py::typing::Union<Ping, PhysicsPing>>;

/// A ping that is being made. Only `as_ping` and `as_physics_ping` need the GIL.
class PingInMaking {
 public:
  PingInMaking(const Simulation& sim, std::size_t vehicle, std::size_t index, bool in_physics_mode,
               bool water_column = false)
      : order_{.vehicle = vehicle, .sonar = index, .water_column = water_column},
        fan_(sim.sonar(vehicle, index).multibeam().model()),
        world_from_sonar_(sim.world_from_sonar(vehicle, index)),
        time_ns_(sim.time_ns()) {
    if (in_physics_mode) return;
    angles_rad_ = sim.sonar(vehicle, index).multibeam().angles_rad();
    memory_ = std::make_unique<PingMemory>(1, angles_rad_.size());
    order_.rows = memory_->rows();
  }

  PingOrder& order() { return order_; }

  Ping as_ping() {
    Ping out;
    static_cast<PingArrays&>(out) = arrays_of(std::move(memory_), {static_cast<py::ssize_t>(angles_rad_.size())});
    out.model = fan_.number;
    out.time_ns = time_ns_;
    out.world_from_sonar = world_from_sonar_.matrix();
    out.angles_rad = read_only(move_out(std::move(angles_rad_)));
    return out;
  }

  PhysicsPing as_physics_ping() { return physics_ping(std::move(order_.acoustic), fan_, world_from_sonar_, time_ns_); }

  py::object as_object() { return memory_ ? py::cast(as_ping()) : py::cast(as_physics_ping()); }

 private:
  PingOrder order_;
  MultibeamModel fan_;
  Pose world_from_sonar_;
  std::uint64_t time_ns_;
  std::vector<float> angles_rad_;
  std::unique_ptr<PingMemory> memory_;  // in geometry mode
};

Ping ping(OwnedSimulation& owned, std::size_t vehicle, std::size_t index) {
  std::optional<PingInMaking> made;
  owned.with([&](Simulation& sim) {
    made.emplace(sim, vehicle, index, false);
    sim.ping(vehicle, index, made->order().rows);
  });
  return made->as_ping();
}

PhysicsPing acoustic_ping(OwnedSimulation& owned, std::size_t vehicle, std::size_t index, int threads,
                          bool water_column) {
  std::optional<PingInMaking> made;
  owned.with([&](Simulation& sim) {
    made.emplace(sim, vehicle, index, true, water_column);
    made->order().acoustic = sim.acoustic_ping(vehicle, index, threads, water_column);
  });
  return made->as_physics_ping();
}

SomePings pings_together(OwnedSimulation& owned, const std::vector<std::tuple<std::size_t, std::size_t, bool>>& sonars,
                         int threads) {
  std::vector<PingInMaking> made;
  owned.with([&](Simulation& sim) {
    for (const auto& [vehicle, index, water_column] : sonars)
      made.emplace_back(sim, vehicle, index, sim.sonar(vehicle, index).in_physics_mode(), water_column);
    std::vector<PingOrder*> orders;
    for (PingInMaking& one : made) orders.push_back(&one.order());
    sim.ping_together(orders, threads);
  });
  SomePings out;
  for (PingInMaking& one : made) out.append(one.as_object());
  return out;
}

/// Converts rigid transforms (n, 4, 4). Throws InvalidValue for anything else.
std::vector<Pose> poses_of(const py::object& object, const char* name) {
  const auto array = as_array<double>(object, name, {-1, 4, 4});
  std::vector<Pose> poses;
  for (py::ssize_t k = 0; k < array.shape(0); ++k) {
    const Eigen::Map<const RowMajor4> matrix(array.data(k));
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    const Eigen::Vector3d position = matrix.topRightCorner<3, 1>();
    const std::string path = std::string(name) + "[" + std::to_string(k) + "]";
    require(matrix.allFinite(), path, "non-finite", "must be finite");
    const double error = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    require(error < 1e-6 && rotation.determinant() > 0 && matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1), path,
            "not a rigid transform", "must be a rotation and a translation over a row 0, 0, 0, 1");
    require(position.cwiseAbs().maxCoeff() <= kWorldEnd_m, path, position.transpose(),
            "must be within 1000 km of the origin");
    poses.push_back({position, Eigen::Quaterniond(rotation).normalized()});
  }
  return poses;
}

int threads_or_all(const std::optional<int>& threads) {
  if (!threads) return usable_threads();
  require(*threads >= 1 && *threads <= 1024, "threads", *threads, "must be in [1, 1024]");
  return *threads;
}

PingBatch ping_batch(OwnedSimulation& owned, std::size_t vehicle, std::size_t index, const py::object& world_from_body,
                     const std::optional<int>& requested_threads) {
  const std::vector<Pose> poses = poses_of(world_from_body, "poses");
  const int threads = threads_or_all(requested_threads);
  const auto n = static_cast<py::ssize_t>(poses.size());
  std::vector<RowMajor4> heads(poses.size());
  PingBatch out;
  std::vector<float> angles_rad;
  std::unique_ptr<PingMemory> memory;
  owned.with([&](Simulation& sim) {
    const SonarHead& head = sim.sonar(vehicle, index);
    angles_rad = head.multibeam().angles_rad();
    out.model = head.multibeam().model().number;
    const std::size_t beams = angles_rad.size();
    memory = std::make_unique<PingMemory>(poses.size(), beams);
    const PingRows rows = memory->rows();
    const RayScene scene = sim.scene_around(vehicle);
    for (std::size_t done = 0; done < poses.size(); done += kPingsBetweenSignals) {
      const std::size_t count = std::min(kPingsBetweenSignals, poses.size() - done);
      parallel_batches(count, kPingsPerBatch, threads, [&](std::size_t first, std::size_t last, std::size_t) {
        for (std::size_t k = done + first; k < done + last; ++k) {
          head.ping(scene, sim.water(), poses[k], rows.row(k, beams));
          heads[k] = (poses[k] * head.body_from_sonar()).matrix();
        }
      });
      const GilTaken locked;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
  });
  static_cast<PingArrays&>(out) = arrays_of(std::move(memory), {n, static_cast<py::ssize_t>(angles_rad.size())});
  out.world_from_sonar = py::array_t<double>({n, py::ssize_t{4}, py::ssize_t{4}}, heads.data()->data());
  forbid_writing(out.world_from_sonar);
  out.angles_rad = read_only(move_out(std::move(angles_rad)));
  return out;
}

std::string describe(const Ping& ping) { return describe_fan("Ping", ping.ranges_m, ping.valid, ping.time_ns); }

std::string describe_batch(const PingBatch& batch) {
  return "PingBatch(" + std::to_string(batch.ranges_m.shape(0)) + " pings of " +
         std::to_string(batch.ranges_m.shape(1)) + " beams)";
}

}  // namespace

void bind_pings(py::module_& m, py::class_<OwnedSimulation>& simulation) {
  Record<Ping>(
      m, "Ping",
      "One multibeam ping. Arrays are read-only, with one value per beam. A ping that Sonar.ping() took also has\n"
      "`chain`, from pings to a map, and `world_from_body` (4, 4), which copies do not have.",
      py::dynamic_attr())
      .field("model", &Ping::model, "EM 2040 variant 1..4; 0 for another sonar")
      .field("time_ns", &Ping::time_ns)
      .field("world_from_sonar", &Ping::world_from_sonar, "(4, 4) float64")
      .field("angles_rad", &Ping::angles_rad, "(beams,) float32, about the sonar's +z, positive to port")
      .field("ranges_m", &Ping::ranges_m, "(beams,) float32, inf for no echo")
      .field("points_sonar_m", &Ping::points_sonar_m, "(beams, 3) float32, NaN for no echo")
      .field("incidence_rad", &Ping::incidence_rad, "(beams,) float32 in [0, pi/2], NaN for no echo")
      .field("intensity_db", &Ping::intensity_db,
             "(beams,) float32, echo level minus source level (Lambert, 40 log R, absorption); -inf for no echo")
      .field("labels", &Ping::labels, "(beams,) uint16, see Simulator.label_names")
      .field("valid", &Ping::valid, "(beams,) bool")
      .described_by(&describe)
      .drawn_by("uwsim.instruments.sonars.fan_plot")
      .done();

  Record<PingBatch>(m, "PingBatch",
                    "Several pings of one sonar. Arrays are read-only, with one row per ping; see Ping.")
      .field("model", &PingBatch::model, "EM 2040 variant 1..4; 0 for another sonar")
      .field("world_from_sonar", &PingBatch::world_from_sonar, "(n, 4, 4) float64")
      .field("angles_rad", &PingBatch::angles_rad, "(beams,) float32, common to all pings")
      .field("ranges_m", &PingBatch::ranges_m, "(n, beams) float32, inf for no echo")
      .field("points_sonar_m", &PingBatch::points_sonar_m, "(n, beams, 3) float32, NaN for no echo")
      .field("incidence_rad", &PingBatch::incidence_rad, "(n, beams) float32 in [0, pi/2], NaN for no echo")
      .field("intensity_db", &PingBatch::intensity_db, "(n, beams) float32, -inf for no echo")
      .field("labels", &PingBatch::labels, "(n, beams) uint16")
      .field("valid", &PingBatch::valid, "(n, beams) bool")
      .described_by(&describe_batch)
      .done();

  simulation
      .def(
          "aim",
          [](OwnedSimulation& o, std::size_t v, std::size_t sonar, double elevation_rad) {
            o.with([&](Simulation& s) { s.aim(v, sonar, elevation_rad); });
          },
          py::arg("vehicle"), py::arg("sonar"), py::arg("elevation_rad"),
          "Set the elevation to which the head turns over time; positive is up. Raises ValueError.")
      .def(
          "sonar_elevation_rad",
          [](OwnedSimulation& o, std::size_t v, std::size_t sonar) {
            return o.with([&](Simulation& s) { return s.sonar(v, sonar).elevation_rad(); });
          },
          py::arg("vehicle"), py::arg("sonar"), "Return the present elevation of the head.")
      .def(
          "sonar_target_elevation_rad",
          [](OwnedSimulation& o, std::size_t v, std::size_t sonar) {
            return o.with([&](Simulation& s) { return s.sonar(v, sonar).aimed_rad(); });
          },
          py::arg("vehicle"), py::arg("sonar"), "Return the elevation to which the head turns.")
      .def(
          "sonar_ping_rate_max_hz",
          [](OwnedSimulation& o, std::size_t v, std::size_t sonar) {
            return o.with([&](Simulation& s) {
              return s.sonar(v, sonar).multibeam().ping_rate_max_hz(s.water(),
                                                                    s.world_from_sonar(v, sonar).position_m.z());
            });
          },
          py::arg("vehicle"), py::arg("sonar"),
          "Return the maximum ping rate: the lower of the limit by two-way travel time, c / (2 range) with c at the\n"
          "head, and the limit of the electronics.")
      .def(
          "in_physics_mode",
          [](OwnedSimulation& o, std::size_t v, std::size_t sonar) {
            return o.with([&](Simulation& s) { return s.sonar(v, sonar).in_physics_mode(); });
          },
          py::arg("vehicle"), py::arg("sonar"))
      .def("acoustic_ping", &acoustic_ping, py::arg("vehicle"), py::arg("sonar"), py::arg("threads") = 1,
           py::arg("water_column") = false,
           "Ping in physics mode. Raises ValueError in geometry mode. Releases the GIL.")
      .def("ping", &ping, py::arg("vehicle"), py::arg("sonar"), "Ping in geometry mode. Releases the GIL.")
      .def("pings_together", &pings_together, py::arg("sonars"), py::arg("threads"),
           "Ping with each of sonars, (vehicle, sonar, water_column), on several threads. Returns Pings, and\n"
           "PhysicsPings of sonars in physics mode. Releases the GIL.")
      .def("ping_batch", &ping_batch, py::arg("vehicle"), py::arg("sonar"), py::arg("world_from_body"),
           py::arg("threads") = py::none(),
           "Ping in geometry mode from each of world_from_body, (n, 4, 4) float64, rigid, with the head at its\n"
           "present elevation and the other vehicles at their present poses. threads: all by default; results do\n"
           "not depend on it. Raises ValueError. Releases the GIL. Can be interrupted by Ctrl-C.");
}

}  // namespace uwsim::bindings
