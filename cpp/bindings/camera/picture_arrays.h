#pragma once

#include "bindings/core/arrays.h"
#include "uwsim/camera/picture.h"
#include "uwsim/camera/ray_record.h"

namespace uwsim::bindings {

/// A picture as read-only NumPy arrays, which own the picture's memory.
struct PictureArrays {
  PictureArrays(Picture&& picture, const RayRecord& record);

  py::array rgb, radiance, depth_m, normals_world, labels, classes, pieces;
  double gain;
  py::bytes packets;
};

}  // namespace uwsim::bindings
