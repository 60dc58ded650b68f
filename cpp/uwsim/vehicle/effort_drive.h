#pragma once

#include "uwsim/core/body_state.h"

namespace uwsim {

/// The paper's propulsion: force along and torque about each body axis, proportional to an effort in [-1, 1].
struct EffortDrive {
  /// Full effort along and about the body axes [N, N m].
  Vector6d full_wrench_body = Vector6d::Zero();

  Vector6d wrench_body(const Vector6d& effort) const { return full_wrench_body.cwiseProduct(effort); }
};

}  // namespace uwsim
