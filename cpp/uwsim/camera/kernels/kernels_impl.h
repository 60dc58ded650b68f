#pragma once

#include "uwsim/camera/kernels/development.h"
#include "uwsim/camera/kernels/hits.h"
#include "uwsim/camera/kernels/lamps.h"
#include "uwsim/camera/kernels/radiance.h"
#include "uwsim/camera/kernels/water.h"

/// All kernels of one instruction set.
namespace uwsim::camera {
namespace {

constexpr Kernels kKernels{&primary_rays,        &shaft_rays,     &start_paths,        &may_meet,
                           &locate_hits,         &write_geometry, &limit_to_sight,     &apply_water,
                           &refract_or_reflect,  &add_sky,        &shade_daylight,     &shade_lamp,
                           &add_unblocked_light, &add_glow,       &shaft_sample_point, &shaft_sample_light,
                           &write_radiance,      &develop_row};

}  // namespace
}  // namespace uwsim::camera
