#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <string>
#include <vector>

#include "bindings/control/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "uwsim/control/autopilot.h"
#include "uwsim/control/batch_control.h"
#include "uwsim/control/path_follower.h"

namespace uwsim::bindings {
namespace {

/// The estimates of n vehicles, as arrays that are not copied if they are C-ordered float64.
struct EstimateArrays {
  DoubleArray positions_world_m, orientations_xyzw, velocities_body;

  EstimateArrays(std::size_t count, const py::object& positions, const py::object& orientations,
                 const py::object& velocities) {
    const auto n = static_cast<py::ssize_t>(count);
    positions_world_m = as_array<double>(positions, "positions_world_m", {n, 3});
    orientations_xyzw = as_array<double>(orientations, "orientations_xyzw", {n, 4});
    velocities_body = as_array<double>(velocities, "velocities_body", {n, 6});
  }
  EstimateRows rows() const { return {positions_world_m.data(), orientations_xyzw.data(), velocities_body.data()}; }
};

DoubleArray effort_array(std::size_t n) { return DoubleArray({static_cast<py::ssize_t>(n), py::ssize_t{6}}); }

DoubleArray reach(BatchMotionController& each, const py::object& positions, const py::object& orientations,
                  const py::object& velocities, const py::object& targets_world_m,
                  const py::object& velocities_world_m_s, const py::object& rolls_rad, const py::object& pitches_rad,
                  const py::object& headings_rad, bool across_first) {
  const auto n = static_cast<py::ssize_t>(each.size());
  const EstimateArrays estimates(each.size(), positions, orientations, velocities);
  const auto place = as_array<double>(targets_world_m, "targets_world_m", {n, 3});
  const auto moving = as_array<double>(velocities_world_m_s, "velocities_world_m_s", {n, 3});
  const auto roll = as_array<double>(rolls_rad, "rolls_rad", {n}),
             pitch = as_array<double>(pitches_rad, "pitches_rad", {n});
  const auto heading = as_array<double>(headings_rad, "headings_rad", {n});
  std::vector<MotionTarget> targets;
  for (py::ssize_t k = 0; k < n; ++k) {
    targets.push_back({Eigen::Vector3d::Map(place.data(k)), Eigen::Vector3d::Map(moving.data(k)), roll.at(k),
                       pitch.at(k), heading.at(k), across_first});
  }
  DoubleArray efforts = effort_array(each.size());
  double* const out = efforts.mutable_data();
  without_gil([&] { return each.reach(estimates.rows(), targets, out), 0; });
  return efforts;
}

DoubleArray hold_velocity(BatchMotionController& each, const py::object& positions, const py::object& orientations,
                          const py::object& velocities, const py::object& wanted_body) {
  const EstimateArrays estimates(each.size(), positions, orientations, velocities);
  const auto wanted = as_array<double>(wanted_body, "wanted_body", {static_cast<py::ssize_t>(each.size()), 6});
  DoubleArray efforts = effort_array(each.size());
  double* const out = efforts.mutable_data();
  without_gil([&] { return each.hold_velocity(estimates.rows(), wanted.data(), out), 0; });
  return efforts;
}

DoubleArray steer(std::vector<Autopilot>& each, const py::object& positions, const py::object& orientations,
                  const py::object& velocities, const py::object& headings_rad, const py::object& velocities_world_m_s,
                  const py::object& heights_world_m) {
  const auto n = static_cast<py::ssize_t>(each.size());
  const EstimateArrays estimates(each.size(), positions, orientations, velocities);
  const auto heading = as_array<double>(headings_rad, "headings_rad", {n});
  const auto velocity = as_array<double>(velocities_world_m_s, "velocities_world_m_s", {n, 2});
  const auto height = as_array<double>(heights_world_m, "heights_world_m", {n});
  DoubleArray efforts = effort_array(each.size());
  for (py::ssize_t k = 0; k < n; ++k) {
    const Course course{heading.at(k), Eigen::Vector2d::Map(velocity.data(k)), height.at(k)};
    const auto row = static_cast<std::size_t>(k);
    Vector6d::Map(efforts.mutable_data(k)) = each[row].steer(estimates.rows().row(row), course);
  }
  return efforts;
}

using GuidanceRow = Eigen::Matrix<double, 9, 1>;

/// Guides each vehicle along its path, and paces it: (n, 9), see the docstring below.
DoubleArray guide(std::vector<PathFollower>& each, const py::object& positions_world_m, double speed_m_s,
                  const py::object& force_shares) {
  const auto n = static_cast<py::ssize_t>(each.size());
  const auto positions = as_array<double>(positions_world_m, "positions_world_m", {n, 3});
  const auto shares = as_array<double>(force_shares, "force_shares", {n});
  DoubleArray rows({n, py::ssize_t{9}});
  for (py::ssize_t k = 0; k < n; ++k) {
    PathFollower& follower = each[static_cast<std::size_t>(k)];
    const Guidance g = follower.guide(Eigen::Vector3d::Map(positions.data(k)));
    const Eigen::Vector2d velocity = follower.pace(g.course_rad, speed_m_s, shares.at(k));
    GuidanceRow::Map(rows.mutable_data(k)) << g.course_rad, g.path_rad, g.cross_track_m, g.along_m, g.left_m,
        g.z_world_m, g.is_done ? 1.0 : 0.0, velocity.x(), velocity.y();
  }
  return rows;
}

struct BatchAutopilot {
  std::vector<Autopilot> fresh, each;
};

struct BatchPathFollower {
  std::vector<PathFollower> fresh, each;
};

}  // namespace

void bind_batch_control(py::module_& m) {
  py::class_<BatchMotionController>(m, "BatchMotionController",
                                    "n instances of MotionController, called together; arrays have one row each.")
      .def(py::init<const ControlModel&, const ControlGains&, double, std::size_t, int>(), py::arg("model"),
           py::arg("gains"), py::arg("period_s"), py::arg("n"), py::arg("threads"), "Raises ValueError.")
      .def("reach", &reach, py::arg("positions_world_m"), py::arg("orientations_xyzw"), py::arg("velocities_body"),
           py::arg("targets_world_m"), py::arg("velocities_world_m_s"), py::arg("rolls_rad"), py::arg("pitches_rad"),
           py::arg("headings_rad"), py::arg("across_first"),
           "Return the efforts (n, 6) of MotionController.reach. The first three are the estimated motion: (n, 3),\n"
           "(n, 4) and (n, 6). Releases the GIL. Raises ValueError for wrong shapes.")
      .def("hold_velocity", &hold_velocity, py::arg("positions_world_m"), py::arg("orientations_xyzw"),
           py::arg("velocities_body"), py::arg("wanted_body"),
           "Return the efforts (n, 6) of MotionController.hold_velocity for velocities (n, 6). Releases the GIL.")
      .def_property_readonly(
          "force_shares",
          [](const BatchMotionController& each) {
            std::vector<double> shares;
            for (std::size_t k = 0; k < each.size(); ++k) shares.push_back(each[k].force_share());
            return move_out(std::move(shares));
          },
          "MotionController.force_share of each, (n,).")
      .def(
          "restart",
          [](BatchMotionController& each, const std::vector<std::size_t>& chosen) {
            for (const std::size_t k : chosen) each.restart(k);
          },
          py::arg("chosen"), "Return some controllers to their initial state.");

  py::class_<BatchAutopilot>(m, "BatchAutopilot", "n instances of Autopilot, called together.")
      .def(py::init([](double period_s, const std::vector<AutopilotGains>& gains) {
             std::vector<Autopilot> fresh;
             for (const AutopilotGains& own : gains) fresh.emplace_back(period_s, own);
             return BatchAutopilot{fresh, fresh};
           }),
           py::arg("period_s"), py::arg("gains"))
      .def(
          "steer",
          [](BatchAutopilot& a, const py::object& positions, const py::object& orientations,
             const py::object& velocities, const py::object& headings, const py::object& over_ground,
             const py::object& heights) {
            return steer(a.each, positions, orientations, velocities, headings, over_ground, heights);
          },
          py::arg("positions_world_m"), py::arg("orientations_xyzw"), py::arg("velocities_body"),
          py::arg("headings_rad"), py::arg("velocities_world_m_s"), py::arg("heights_world_m"),
          "Return the efforts (n, 6) of Autopilot.steer for headings (n,), horizontal velocities (n, 2) and heights\n"
          "(n,). The first three are the estimated motion: (n, 3), (n, 4) and (n, 6). Raises ValueError.")
      .def(
          "restart",
          [](BatchAutopilot& a, const std::vector<std::size_t>& chosen) {
            for (const std::size_t k : chosen) a.each.at(k) = a.fresh.at(k);
          },
          py::arg("chosen"), "Return some autopilots to their initial state.");

  py::class_<BatchPathFollower>(m, "BatchPathFollower", "n instances of PathFollower, called together.")
      .def(py::init(
               [](const std::vector<py::object>& paths_m, double lookahead_m, double integral_m_s, double period_s) {
                 std::vector<PathFollower> fresh;
                 for (const py::object& path : paths_m)
                   fresh.emplace_back(as_points(path, "points_m"), lookahead_m, integral_m_s, period_s);
                 return BatchPathFollower{fresh, fresh};
               }),
           py::arg("paths_m"), py::arg("lookahead_m"), py::arg("integral_m_s"), py::arg("period_s"),
           "paths_m: n paths (points, 3). Raises ValueError.")
      .def(
          "guide",
          [](BatchPathFollower& f, const py::object& positions, double speed_m_s, const py::object& shares) {
            return guide(f.each, positions, speed_m_s, shares);
          },
          py::arg("positions_world_m"), py::arg("speed_m_s"), py::arg("force_shares"),
          "Guide and pace each for one control period: the fields of Guidance in order, then the velocity over\n"
          "ground, (n, 9). positions_world_m (n, 3); force_shares (n,), see PathFollower.pace.")
      .def(
          "restart",
          [](BatchPathFollower& f, const std::vector<std::size_t>& chosen) {
            for (const std::size_t k : chosen) f.each.at(k) = f.fresh.at(k);
          },
          py::arg("chosen"), "Return some followers to the beginnings of their paths.");
}

}  // namespace uwsim::bindings
