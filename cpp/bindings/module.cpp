#include <pybind11/pybind11.h>

#include "bind.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The native core of uwsim. World ENU, z up, water surface z = 0; SI units; see each docstring for shapes.";
  using namespace uwsim::bindings;
  bind_core(m);
  bind_acoustics(m);
  bind_water(m);
  bind_world(m);
  bind_vehicle(m);
  bind_actuators(m);
  bind_sonar(m);
  bind_clouds(m);
  bind_acoustic_multibeam(m);
  bind_imaging(m);
  bind_depth_string(m);
  bind_occupancy_map(m);
  bind_camera(m);
  bind_sensors(m);
  bind_sim(m);
}
