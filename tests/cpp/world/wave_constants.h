#pragma once

#include <numbers>

namespace uwsim {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kGravity = 9.80665;

}  // namespace uwsim
