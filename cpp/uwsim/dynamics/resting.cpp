#include "uwsim/dynamics/resting.h"

namespace uwsim {
namespace {

// The largest residual acceleration of a body that its contacts hold, and what is allowed in addition, as a fraction of
// the acceleration that the contacts cancel.
constexpr double kLeast_m_s2 = 2e-4, kSliding = 0.01, kRolling = 0.1;
// If each limit has a margin of kLeft, the contacts also hold under loads that differ by the fraction kSameLoads: the
// impulses follow the loads, amplified by the contact geometry, whose condition number may then be as high as 10,000.
constexpr double kSameLoads = 1e-9, kLeft = 0.01;

}  // namespace

double fastest_m_s(const Vector6d& velocity_body, double radius_m) {
  return velocity_body.head<3>().norm() + radius_m * velocity_body.tail<3>().norm();
}

Hold::Hold(const ContactBody& solved, const Vector6d& free_velocity_body, double radius_m, double step_s) {
  const double taken_m_s = fastest_m_s(solved.velocity_body - free_velocity_body, radius_m);
  const double least_m_s = kLeast_m_s2 * step_s, left_m_s = fastest_m_s(solved.velocity_body, radius_m);
  const double allowed_m_s = least_m_s + (solved.slides ? kSliding : kRolling) * taken_m_s;
  holds = solved.grip >= 0 && left_m_s <= allowed_m_s;
  is_firm = solved.grip >= kLeft && left_m_s <= (1 - kLeft) * allowed_m_s;
  pushes = fastest_m_s(solved.push_body, radius_m) > least_m_s;
}

void Resting::begin(const Pose& world_from_body, const Vector6d& free_velocity_body, bool is_firm) {
  is_known_ = true;
  is_firm_ = is_firm;
  world_from_body_ = world_from_body;
  free_velocity_body_ = free_velocity_body;
}

void Resting::exchange_state(StateArchive& archive) {
  BodyState kept{world_from_body_, free_velocity_body_};
  archive(is_known_);
  archive(is_firm_);
  archive(kept);
  world_from_body_ = kept.world_from_body;
  free_velocity_body_ = kept.velocity_body;
}

bool Resting::lasts(const BodyState& state, const Vector6d& free_velocity_body) const {
  return is_known_ && state.velocity_body.isZero(0) &&
         state.world_from_body.position_m == world_from_body_.position_m &&
         state.world_from_body.orientation.coeffs() == world_from_body_.orientation.coeffs() &&
         (free_velocity_body - free_velocity_body_).norm() <= (is_firm_ ? kSameLoads : 0) * free_velocity_body_.norm();
}

}  // namespace uwsim
