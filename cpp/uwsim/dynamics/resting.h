#pragma once

#include "uwsim/core/body_state.h"
#include "uwsim/core/state_archive.h"
#include "uwsim/dynamics/contact.h"

namespace uwsim {

/// A body at rest has zero velocity, and its pose does not change by a single bit.
///
/// Without this rule, the residual of a contact's constant force over a Runge-Kutta step, about 1e-5 m/s, would make a
/// vehicle creep over the bed by millimetres per hour, and a light vehicle would rock on two corners for a minute.
/// Therefore a group of bodies that press on each other and on the fixed world is stopped if no point of the bodies
/// moves faster than kSlow_m_s and if, once stopped, they would stay at rest: the contacts must reduce the acceleration
/// of each body to at most 2e-4 m/s^2 plus a fraction of the acceleration that they cancel. If a contact slides, the
/// fraction is 0.01, since static friction exceeds sliding friction by more than that (Rabinowicz 1951, J. Appl. Phys.
/// 22:1373). If none slides, it is 0.1, for rolling resistance: the coefficient of a tyre on sand is 0.1 to 0.2
/// (Carvill 1993, "Mechanical Engineer's Data Handbook"). Overlaps are still pushed apart.
inline constexpr double kSlow_m_s = 0.01;

/// The largest speed of any point within `radius_m` of a body's origin.
double fastest_m_s(const Vector6d& velocity_body, double radius_m);

/// How firmly contacts hold a body that was at rest at the start of the step. `solved` is the body as the contact
/// solver left it; without contacts it would move at `free_velocity_body`.
struct Hold {
  bool holds;
  bool is_firm;  ///< whether they also hold it under loads that differ by rounding error
  bool pushes;   ///< whether overlaps are still being pushed apart

  Hold(const ContactBody& solved, const Vector6d& free_velocity_body, double radius_m, double step_s);
};

/// Remembers a body at rest. While its loads and the bodies near it stay the same, so do its contacts, and they need
/// not be found again. This is only a cache and changes no motion; it is saved because the forces of contacts that are
/// found again differ by rounding.
class Resting {
 public:
  void begin(const Pose& world_from_body, const Vector6d& free_velocity_body, bool is_firm);
  /// Returns true if the body is known to stay in this state; without contacts it would move at this velocity.
  bool lasts(const BodyState& state, const Vector6d& free_velocity_body) const;
  void forget() { *this = {}; }
  /// Throws InvalidValue.
  void exchange_state(StateArchive& archive);

 private:
  bool is_known_ = false, is_firm_ = false;
  Pose world_from_body_ = {};
  Vector6d free_velocity_body_ = Vector6d::Zero();
};

}  // namespace uwsim
