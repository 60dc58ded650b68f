#pragma once

#include <Eigen/Core>

#include "bindings/core/arrays.h"
#include "uwsim/camera/water_optics.h"

/// Values of the three bands, (3,) in the order red, green, blue.
namespace uwsim::bindings {

inline Bands as_bands(const py::object& object, const char* name) { return as_vector3(object, name).array(); }
inline Eigen::Vector3d bands_out(const Bands& bands) { return bands.matrix(); }

}  // namespace uwsim::bindings
