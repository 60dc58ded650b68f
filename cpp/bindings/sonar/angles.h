#pragma once

#include <cmath>
#include <vector>

#include "bindings/core/arrays.h"
#include "uwsim/core/check.h"

namespace uwsim::bindings {

/// Converts angles (n,) to doubles. Throws InvalidValue unless they are finite.
inline std::vector<double> as_angles(const py::object& angles_rad) {
  const auto array = as_array<double>(angles_rad, "angles_rad", {-1});
  std::vector<double> angles(array.data(), array.data() + array.size());
  for (const double angle : angles) require(std::isfinite(angle), "angles_rad", angle, "must be finite");
  return angles;
}

}  // namespace uwsim::bindings
