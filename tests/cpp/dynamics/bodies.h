#pragma once

#include "uwsim/core/body_state.h"

namespace uwsim {

inline constexpr double kStep_s = 0.005;

/// A state at rest, upright.
inline BodyState at(double x, double y, double z) {
  BodyState state;
  state.world_from_body.position_m = {x, y, z};
  return state;
}

}  // namespace uwsim
