#pragma once

#include <limits>

namespace uwsim {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace uwsim
