#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "uwsim/sonar/acoustic_multibeam.h"

namespace uwsim::bindings {

/// A ping in physics mode as exposed to Python: read-only arrays with one value per beam.
struct PhysicsPing {
  int model = 0;
  std::uint64_t time_ns = 0;
  Eigen::Matrix4d world_from_sonar = Eigen::Matrix4d::Identity();
  pybind11::array ranges_m, angles_rad, points_sonar_m, incidence_rad, intensity_db, snr_db, travel_time_s, deviation_m,
      vertical_deviation_m, horizontal_deviation_m, labels, valid, detections;
  /// (beams, samples) and (samples,), or None
  pybind11::object water_column = pybind11::none(), water_column_ranges_m = pybind11::none();
};

/// Moves the results of a ping into arrays.
PhysicsPing physics_ping(AcousticPing&& ping, const MultibeamModel& fan, const Pose& world_from_sonar,
                         std::uint64_t time_ns);

/// Returns a short description for people: a ping's time, number of beams, and range of distances of its echoes.
std::string describe_fan(const char* name, const pybind11::array& ranges_m, const pybind11::array& valid,
                         std::uint64_t time_ns);

}  // namespace uwsim::bindings
