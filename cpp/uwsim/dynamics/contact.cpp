#include "uwsim/dynamics/contact.h"

#include <algorithm>

namespace uwsim {
namespace {

// A smaller gap counts as closed, so that a body at rest does not fall into a gap left by a step's rounding error.
constexpr double kClosed_m = 1e-6;
constexpr double kSlop_m = 1e-3;
constexpr double kOverlapShare = 0.2;     // fraction of the overlap beyond the slop removed in one step
constexpr double kPushMax_m_s = 2;        // limits the push out of deep overlaps
constexpr double kLeastPush_m_s = 1e-12;  // rounding error in a body at rest

}  // namespace

Eigen::Matrix3d Contact::directions_world() const {
  Eigen::Matrix3d directions;
  directions.col(0) = normal_world;
  directions.col(1) = normal_world.unitOrthogonal();
  directions.col(2) = normal_world.cross(directions.col(1));
  return directions;
}

double Contact::least_speed_m_s(double start_m_s, double end_m_s, double step_s) const {
  const double open_m = gap_m > kClosed_m ? gap_m : 0;
  const bool arrives = end_m_s * step_s + open_m < 0;
  // Use the speed before the step: the speed that gravity adds within the step must not cause a bounce.
  const bool bounces = arrives && start_m_s < -kBounceThreshold_m_s;
  return bounces ? -restitution * start_m_s : -open_m / step_s;
}

double Contact::push_m_s(double start_m_s, double end_m_s, double step_s) const {
  const double added_m = -std::max(0.0, gap_m) - 0.5 * (start_m_s + end_m_s) * step_s;
  const double present_m = std::max(0.0, -gap_m - kSlop_m);
  const double push_m_s = std::max(0.0, added_m) / step_s + std::min(kOverlapShare * present_m / step_s, kPushMax_m_s);
  return push_m_s > kLeastPush_m_s ? push_m_s : 0;
}

}  // namespace uwsim
