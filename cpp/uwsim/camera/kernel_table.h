#pragma once

#include "uwsim/camera/kernel_film.h"
#include "uwsim/camera/kernel_lamp.h"

/// All kernels of one build. Included by kernel_*.cpp only.
namespace uwsim::camera {
namespace {

constexpr Kernels table(const char* name) {
  return {name,         aim,           open_eye,  aim_shafts, place,       write_geometry, pass_water, go_on,  sky,
          light_by_day, light_by_lamp, add_light, lamp_veil,  shaft_point, shaft_light,    expose,     develop};
}

}  // namespace
}  // namespace uwsim::camera
