#include <pybind11/pybind11.h>

#include "bindings/binders.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The native core of uwsim. World ENU, z up, water surface z = 0; SI units; see each docstring for shapes.";
  using namespace uwsim::bindings;
  bind_core(m);
  bind_world(m);
  bind_rays(m);
  bind_acoustics(m);
  bind_vehicle(m);
  bind_control(m);
  bind_sensors(m);
  bind_sonar(m);
  bind_camera(m);
  bind_mapping(m);
  bind_estimation(m);
  bind_sim(m);
  bind_autopilots(m);
}
