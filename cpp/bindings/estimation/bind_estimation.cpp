#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "bindings/binders.h"
#include "bindings/core/arrays.h"
#include "bindings/core/convert.h"
#include "uwsim/estimation/navigation_filter.h"

namespace uwsim::bindings {
namespace {

using Stds = std::pair<double, double>;
using Times = py::array_t<std::uint64_t, py::array::c_style | py::array::forcecast>;

/// Returns the readings as an array (n, width), for n times. Throws InvalidValue.
py::array_t<double, py::array::c_style> rows(const Times& times, const py::object& readings, py::ssize_t width) {
  require(times.ndim() == 1, "times_ns.ndim", times.ndim(), "must be 1");
  return as_array<double>(readings, "readings", {times.shape(0), width});
}

void add_imu(NavigationFilter& filter, const Times& times_ns, const py::object& readings) {
  const auto values = rows(times_ns, readings, 6);
  for (py::ssize_t k = 0; k < times_ns.shape(0); ++k) filter.add_imu(times_ns.at(k), values.data(k));
}

void add_readings(NavigationFilter& filter, int aid, const Times& times_ns, const Times& arrivals_ns,
                  const py::object& readings) {
  const auto values = rows(times_ns, readings, -1);
  require(arrivals_ns.ndim() == 1 && arrivals_ns.shape(0) == times_ns.shape(0), "arrivals_ns.shape",
          shape_text(arrivals_ns), "must be that of times_ns");
  require(aid >= 0 && aid < filter.aids(), "aid", aid, "must be that of an aid");
  require(values.shape(1) == filter.aid_width(aid), "readings.shape[1]", values.shape(1), "must be the aid's width");
  for (py::ssize_t k = 0; k < times_ns.shape(0); ++k) {
    filter.add_reading(aid, times_ns.at(k), arrivals_ns.at(k), values.data(k));
  }
}

py::array_t<double> copied(const double* values, py::ssize_t n) { return py::array_t<double>(n, values); }

/// The motion and its errors side by side, for those who keep many estimates.
py::array_t<double> numbers(const NavigationFilter& filter) {
  using Errors = Eigen::Matrix<double, kAidBias, kAidBias, Eigen::RowMajor>;
  using Turn = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  constexpr int kTurn = 14, kErrors = kTurn + 9;
  const FilterState& state = filter.state();
  py::array_t<double> found(kErrors + kAidBias * kAidBias);
  double* to = found.mutable_data();
  to[0] = static_cast<double>(state.time_ns) * 1e-9;
  Eigen::Map<Eigen::Vector3d>{to + 1} = filter.position_body_origin_m();
  Eigen::Map<Eigen::Vector4d>{to + 4} = state.orientation.coeffs();
  Eigen::Map<Eigen::Vector3d>{to + 8} = filter.velocity_body_m_s();
  Eigen::Map<Eigen::Vector3d>{to + 11} = state.rate_rad_s();
  Eigen::Map<Turn>{to + kTurn} =
      Pose{filter.position_body_origin_m(), state.orientation}.matrix().topLeftCorner<3, 3>();
  Eigen::Map<Errors>{to + kErrors} = state.covariance.topLeftCorner<kAidBias, kAidBias>();
  return found;
}

void bind_state(py::class_<NavigationFilter>& filter) {
  filter
      .def_property_readonly(
          "time_ns", [](const NavigationFilter& f) { return f.state().time_ns; }, "time of the newest IMU sample")
      .def_property_readonly("position_world_m", &NavigationFilter::position_body_origin_m,
                             "(3,), of the body's origin")
      .def_property_readonly("orientation_xyzw",
                             [](const NavigationFilter& f) { return copied(f.state().orientation.coeffs().data(), 4); })
      .def_property_readonly(
          "world_from_body",
          [](const NavigationFilter& f) {
            return Pose{f.position_body_origin_m(), f.state().orientation}.matrix();
          },
          "(4, 4)")
      .def_property_readonly("linear_body_m_s", &NavigationFilter::velocity_body_m_s, "(3,), of the body's origin")
      .def_property_readonly(
          "angular_body_rad_s", [](const NavigationFilter& f) { return f.state().rate_rad_s(); }, "(3,)")
      .def_property_readonly(
          "covariance", [](const NavigationFilter& f) { return Eigen::MatrixXd(f.state().covariance); },
          "Covariance (n, n) of the errors of position and velocity (world axes), attitude (body axes, rad), the\n"
          "biases of gyroscope and accelerometer (body axes), the elements of the IMU's matrices of which an error is\n"
          "stated, 9 each, row by row, and the biases of the aids; of the IMU's centre")
      .def_property_readonly(
          "numbers", &numbers,
          "(248,): time [s], position, quaternion x, y, z, w, linear and angular velocity as above, the rotation\n"
          "(3, 3) and the covariance of the first 15 errors, both row by row")
      .def_property_readonly("rate_bias_rad_s", [](const NavigationFilter& f) { return f.state().rate_bias_rad_s; })
      .def_property_readonly("force_bias_m_s2", [](const NavigationFilter& f) { return f.state().force_bias_m_s2; })
      .def_property_readonly("aid_biases",
                             [](const NavigationFilter& f) { return Eigen::VectorXd(f.state().aid_bias); })
      .def(
          "first_bias",
          [](const NavigationFilter& f, int aid) {
            require(aid >= 0 && aid < f.aids(), "aid", aid, "must be that of an aid");
            return f.first_bias(aid);
          },
          py::arg("aid"), "Return the index of the first of an aid's biases in `covariance`.")
      .def_property_readonly("too_late", &NavigationFilter::too_late,
                             "number of readings that arrived too late to be used")
      .def(
          "counts",
          [](const NavigationFilter& f, int aid) {
            require(aid >= 0 && aid < f.aids(), "aid", aid, "must be that of an aid");
            const AidCounts& c = f.state().counts[static_cast<std::size_t>(aid)];
            return std::make_pair(c.accepted, c.rejected);
          },
          py::arg("aid"), "Return the numbers of scalars of an aid's readings that were used and that were outliers.");
}

void bind_aids(py::class_<NavigationFilter>& filter) {
  filter
      .def(
          "add_doppler",
          [](NavigationFilter& f, const Eigen::MatrixX3d& beams, const Eigen::Vector3d& lever, double std,
             const BiasModel& bias, const BiasModel& scale, const BiasModel& misalignment) {
            return f.add_aid(doppler_aid(beams, lever, {std, bias, scale, misalignment}));
          },
          py::arg("beams_body"), py::arg("lever_body_m"), py::arg("std"), py::arg("bias"), py::arg("scale"),
          py::arg("misalignment"),
          "Add an aid that measures velocities along beams (n, 3), unit vectors [m/s]; NaN for a lost beam. scale:\n"
          "relative error of all; misalignment: small rotation of the beams [rad]. Its biases: of the beams, then\n"
          "scale (1) and misalignment (3) as far as they exist. Return its index, like all functions that add an aid.")
      .def(
          "add_depth",
          [](NavigationFilter& f, const Eigen::Vector3d& lever, double std, const BiasModel& bias, double wave_std,
             double level_std, double column_std) {
            return f.add_aid(depth_aid(lever, std, bias, {wave_std, level_std, column_std}));
          },
          py::arg("lever_body_m"), py::arg("std"), py::arg("bias"), py::arg("wave_std"), py::arg("level_std"),
          py::arg("column_std"),
          "Add an aid that measures the weight of the water above as a depth in surface water [m]. Standard "
          "deviations\n"
          "before the first reading: wave_std, of the head of the waves' pressure, which the filter then adapts;\n"
          "level_std, of the still surface [m]; column_std, of the column's mean density, relative to the surface's.\n"
          "0: it errs by nothing, ever. Its biases: the instrument's, two for the waves, level, its rate over that of\n"
          "M2, column.")
      .def(
          "add_heading",
          [](NavigationFilter& f, const Eigen::Vector3d& axis, double std, const BiasModel& bias, double iron_std,
             double north_rad) { return f.add_aid(heading_aid(axis, std, bias, iron_std, north_rad)); },
          py::arg("axis_body"), py::arg("std"), py::arg("bias"), py::arg("iron_std"), py::arg("north_rad"),
          "Add an aid that measures the angle of axis_body from east, counter-clockwise [rad].")
      .def(
          "add_acoustic_fix",
          [](NavigationFilter& f, const Eigen::Vector3d& lever, double range_std, double bearing_std, double range_step,
             double period_s, const BiasModel& range_bias, const BiasModel& scale, const BiasModel& bearing_bias,
             double station_std, const BiasModel& station_bias) {
            return f.add_aid(acoustic_fix_aid(lever, {range_std, bearing_std, range_step, period_s, range_bias, scale,
                                                      bearing_bias, station_std, station_bias}));
          },
          py::arg("lever_body_m"), py::arg("range_std"), py::arg("bearing_std"), py::arg("range_step"),
          py::arg("period_s"), py::arg("range_bias"), py::arg("scale"), py::arg("bearing_bias"), py::arg("station_std"),
          py::arg("station_bias"),
          "Add an aid that measures the position relative to the station, world axes, then has that of the station "
          "itself\n"
          "[m]. station_std: white noise of the latter. range_step: that to which\n"
          "ranges are rounded, or 0 if their noise is larger. period_s: time between fixes. Its biases: of the range "
          "[m],\n"
          "its scale, two of the bearing [rad], and three of the station's place, as far as they exist.")
      .def(
          "add_satellites",
          [](NavigationFilter& f, const Eigen::Vector3d& lever, double horizontal_std, double vertical_std,
             double velocity_std, const BiasModel& horizontal_bias, const BiasModel& vertical_bias) {
            return f.add_aid(
                satellite_aid(lever, {horizontal_std, vertical_std, velocity_std, horizontal_bias, vertical_bias}));
          },
          py::arg("lever_body_m"), py::arg("horizontal_std"), py::arg("vertical_std"), py::arg("velocity_std"),
          py::arg("horizontal_bias"), py::arg("vertical_bias"),
          "Add an aid that measures the position [m] and velocity [m/s] of a satellite receiver's antenna, world axes.")
      .def(
          "add_orientation",
          [](NavigationFilter& f, double std, const BiasModel& bias) { return f.add_aid(orientation_aid(std, bias)); },
          py::arg("std"), py::arg("bias"), "Add an aid that measures the orientation x, y, z, w, world from body.")
      .def(
          "add_dock",
          [](NavigationFilter& f, double position_std, double attitude_std, double velocity_std) {
            return f.add_aid(dock_aid(position_std, attitude_std, velocity_std));
          },
          py::arg("position_std"), py::arg("attitude_std"), py::arg("velocity_std"),
          "Add an aid that measures the pose of a vehicle that a dock holds at rest: position of the IMU, then\n"
          "orientation x, y, z, w, with constant errors [m, rad, m/s].");
}

}  // namespace

void bind_estimation(py::module_& m) {
  py::class_<BiasModel>(m, "BiasModel",
                        "The model of a bias: a constant drawn at the start, a Gauss-Markov drift and a random walk.")
      .def(py::init([](double turn_on_std, double drift_std, double drift_time_s, double walk) {
             return BiasModel{turn_on_std, drift_std, drift_time_s, walk};
           }),
           py::kw_only(), py::arg("turn_on_std") = 0.0, py::arg("drift_std") = 0.0, py::arg("drift_time_s") = 0.0,
           py::arg("walk") = 0.0)
      .def_property_readonly("exists", &BiasModel::exists, "whether there is such a bias at all");
  py::class_<NavigationFilter> filter(
      m, "NavigationFilter",
      "An error-state Kalman filter (Sola 2017) for an IMU and its aids. Readings may arrive late and in any\n"
      "order: the result depends only on the readings and their times. World ENU; REP 103 body axes; lever\n"
      "arms from the IMU.");
  filter
      .def(py::init([](const Eigen::Vector3d& imu_body_m, double gravity_m_s2, double period_s, double rate_std,
                       double force_std, const BiasModel& rate_bias, const BiasModel& force_bias, double rate_limit,
                       double force_limit, double averaging_s, Stds rate_by_rate, Stds rate_by_force,
                       Stds force_by_force, const Eigen::Matrix3d& body_from_imu) {
             const auto matrix = [](Stds stds) { return MatrixErrors{stds.first, stds.second}; };
             const ImuErrors imu{rate_std,
                                 force_std,
                                 period_s,
                                 averaging_s,
                                 rate_bias,
                                 force_bias,
                                 {matrix(rate_by_rate), matrix(rate_by_force), matrix(force_by_force)},
                                 body_from_imu,
                                 rate_limit,
                                 force_limit};
             return std::make_unique<NavigationFilter>(imu, imu_body_m, gravity_m_s2);
           }),
           py::kw_only(), py::arg("imu_body_m"), py::arg("gravity_m_s2"), py::arg("period_s"), py::arg("rate_std"),
           py::arg("force_std"), py::arg("rate_bias"), py::arg("force_bias"),
           py::arg("rate_limit") = std::numeric_limits<double>::infinity(),
           py::arg("force_limit") = std::numeric_limits<double>::infinity(), py::arg("averaging_s") = 0.0,
           py::arg("gyroscope_scale") = Stds{}, py::arg("gyroscope_by_force") = Stds{},
           py::arg("accelerometer_scale") = Stds{},
           py::arg("body_from_imu") = Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
           "period_s: sampling period of the IMU. rate_std, force_std: white noise of a sample [rad/s, m/s2].\n"
           "rate_limit, force_limit: the largest magnitude that an axis can measure. averaging_s: the time before\n"
           "a sample over which its force is averaged; 0 for an instantaneous value. gyroscope_scale,\n"
           "gyroscope_by_force, accelerometer_scale: standard deviations of the elements on and off the diagonal of\n"
           "a constant matrix N, by which x + N y is measured for x, y being the rate, the force and the force. Its\n"
           "axes are the IMU's, which body_from_imu (3, 3) turns to the body's.")
      .def(
          "start",
          [](NavigationFilter& f, std::uint64_t time_ns, const py::object& position_world_m,
             const py::object& orientation_xyzw, const Eigen::Vector3d& position_std_m,
             const Eigen::Vector3d& attitude_std_rad, const Eigen::Vector3d& velocity_world_m_s,
             double velocity_std_m_s) {
            f.start({time_ns, as_pose(position_world_m, orientation_xyzw, "start"), velocity_world_m_s, position_std_m,
                     velocity_std_m_s, attitude_std_rad});
          },
          py::kw_only(), py::arg("time_ns"), py::arg("position_world_m"), py::arg("orientation_xyzw"),
          py::arg("position_std_m"), py::arg("attitude_std_rad"), py::arg("velocity_world_m_s"),
          py::arg("velocity_std_m_s"),
          "Start the filter, after all aids have been added. Discards all earlier readings.")
      .def("add_imu", &add_imu, py::arg("times_ns"), py::arg("readings"),
           "Add samples of the IMU. times_ns (n,) uint64; readings (n, 6): angular velocity, specific force, body\n"
           "axes.")
      .def("add_readings", &add_readings, py::arg("aid"), py::arg("times_ns"), py::arg("arrivals_ns"),
           py::arg("readings"), "Add readings of an aid. times_ns, arrivals_ns (n,) uint64; readings (n, width).")
      .def("add_silence", &NavigationFilter::add_silence, py::arg("time_ns"),
           "Record that the IMU provided no samples until this time.")
      .def("catch_up", &NavigationFilter::catch_up, "Process the readings that have been added.")
      .def("save", [](NavigationFilter& f) { return py::bytes(f.save()); })
      .def(
          "restore", [](NavigationFilter& f, const py::bytes& bytes) { f.restore(std::string_view(bytes)); },
          py::arg("bytes"),
          "Restore a saved state. Raises ValueError for bytes that were not saved by a filter with the same aids.\n"
          "Their version, which is stored beside them, must be save_version.");
  filter.attr("save_version") = NavigationFilter::kVersion;
  bind_aids(filter);
  bind_state(filter);
}

}  // namespace uwsim::bindings
