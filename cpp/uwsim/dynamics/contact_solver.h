#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "uwsim/core/body_state.h"

namespace uwsim {

inline constexpr int kFixedBody = -1;

/// A place where body `a` touches body `b`, or the fixed world.
struct Contact {
  int a = 0;
  int b = kFixedBody;
  Eigen::Vector3d point_world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitZ();  ///< unit, from b towards a
  double gap_m = 0;                                         ///< negative where they overlap
  double friction = 0;
  double restitution = 0;
};

/// A body as its contacts see it.
struct ContactBody {
  Pose world_from_body;
  Vector6d velocity_body =
      Vector6d::Zero();  ///< that free motion would end the step with; changed to what contacts allow
  Vector6d start_velocity_body = Vector6d::Zero();  ///< that it starts the step with
  Matrix6d inverse_mass = Matrix6d::Zero();         ///< full (M_RB + M_A)^-1
  /// What the contacts gave it, about its origin [N s, N m s].
  Vector6d impulse_body = Vector6d::Zero();
  /// Velocity for this step's pose only: pushes overlaps apart without adding energy (split impulse).
  Vector6d push_body = Vector6d::Zero();
};

/// Solves contacts by projected Gauss-Seidel on impulses, with each body's full inverse mass: no approach
/// (Signorini), Newton's restitution above a threshold speed, Coulomb friction in two tangent directions (Catto 2005;
/// Erleben 2007). Overlaps beyond a slop are relaxed through `push_body`.
class ContactSolver {
 public:
  /// So that as many contacts are solved without taking memory.
  void reserve(std::size_t contacts) { rows_.reserve(3 * contacts); }
  /// Changes velocity_body, impulse_body and push_body of `bodies`.
  void solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);
  /// What the last solve() gave `contact` along its normal [N s].
  double normal_impulse(std::size_t contact) const { return rows_[3 * contact].impulse; }

 private:
  /// One direction of one contact: impulse along it changes the velocities of a and b by `response`.
  struct Row {
    Vector6d direction_a, direction_b;
    Vector6d response_a, response_b;
    double inverse_effective_mass;
    double target;  // wanted velocity along the row, then wanted push
    double impulse;
    double push;  // of the relaxation of overlaps
    int a, b;
  };

  Row make_row(std::span<const ContactBody> bodies, const Contact& contact,
               const Eigen::Vector3d& direction_world) const;
  static double wanted_push_m_s(std::span<const ContactBody> bodies, const Contact& contact, const Row& normal,
                                double step_s);
  void solve_velocities(std::span<ContactBody> bodies, std::span<const Contact> contacts);
  void solve_overlaps(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);

  std::vector<Row> rows_;  // three a contact: normal, two tangents; kept to spare allocation
};

}  // namespace uwsim
