#pragma once

#include "uwsim/core/infinity.h"

namespace uwsim {

inline constexpr double kGrazing = 1.75e-3;  // sine of 0.1 degree, rounded up; no guarantees closer to tangency

}  // namespace uwsim
