#include "uwsim/dynamics/resting.h"

#include <algorithm>

namespace uwsim {
namespace {

constexpr double kStart_m_s = 1e-4;    // largest speed of any point of a body that may come to rest
constexpr double kAllowed_m_s = 1e-6;  // largest speed that its contacts may then allow
// Contacts are assumed to hold under loads that differ by no more than this fraction, provided friction has this
// fraction in reserve. Impulses follow the loads, amplified by the contact geometry, whose condition number may then be
// as poor as 10,000.
constexpr double kSameLoads = 1e-9, kGripLeft = 0.01;

double fastest_m_s(const Vector6d& velocity_body, double radius_m) {
  return velocity_body.head<3>().norm() + radius_m * velocity_body.tail<3>().norm();
}

}  // namespace

bool Resting::begins(const ContactBody& solved, const Vector6d& free_velocity_body, double radius_m) {
  is_known_ = false;
  const double start_m_s = fastest_m_s(solved.start_velocity_body, radius_m);
  // A push that merely cancels the effect of the initial speed does not count.
  const double push_m_s = std::max(0.0, fastest_m_s(solved.push_body, radius_m) - 2 * start_m_s);
  if (solved.grip < 0 || start_m_s > kStart_m_s ||
      fastest_m_s(solved.velocity_body, radius_m) + push_m_s > kAllowed_m_s)
    return false;
  if (solved.grip >= kGripLeft && solved.start_velocity_body.isZero(0)) {
    is_known_ = true;
    world_from_body_ = solved.world_from_body;
    free_velocity_body_ = free_velocity_body;
  }
  return true;
}

bool Resting::lasts(const BodyState& state, const Vector6d& free_velocity_body) const {
  return is_known_ && state.velocity_body.isZero(0) &&
         state.world_from_body.position_m == world_from_body_.position_m &&
         state.world_from_body.orientation.coeffs() == world_from_body_.orientation.coeffs() &&
         (free_velocity_body - free_velocity_body_).norm() <= kSameLoads * free_velocity_body_.norm();
}

}  // namespace uwsim
