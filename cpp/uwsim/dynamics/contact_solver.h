#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "uwsim/core/body_state.h"

namespace uwsim {

inline constexpr int kFixedBody = -1;

/// A point at which body `a` touches body `b` or the fixed world.
struct Contact {
  int a = 0;
  int b = kFixedBody;
  Eigen::Vector3d point_world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitZ();  ///< unit, from b towards a
  double gap_m = 0;                                         ///< negative where they overlap
  double friction = 0;
  double restitution = 0;
};

/// A body, for the contact solver.
struct ContactBody {
  Pose world_from_body;
  /// In: at the end of the step without contacts. Out: what the contacts allow.
  Vector6d velocity_body = Vector6d::Zero();
  Vector6d start_velocity_body = Vector6d::Zero();  ///< at the start of the step
  Matrix6d inverse_mass = Matrix6d::Zero();         ///< full (M_RB + M_A)^-1
  /// Out: impulse of all its contacts about its origin [N s, N m s].
  Vector6d impulse_body = Vector6d::Zero();
  /// Out: a velocity that changes this step's pose only, to separate overlaps without adding energy (split impulse).
  Vector6d push_body = Vector6d::Zero();
};

/// Solves contacts by projected Gauss-Seidel on impulses, with each body's full inverse mass: no approach
/// (Signorini), Newton's restitution above a threshold speed, Coulomb friction in two tangent directions (Catto 2005;
/// Erleben 2007). Overlaps beyond a slop are relaxed through `push_body`.
class ContactSolver {
 public:
  /// Allocates beforehand, so that solve() allocates nothing for as many contacts.
  void reserve(std::size_t contacts) { rows_.reserve(3 * contacts); }
  /// Changes velocity_body, impulse_body and push_body of `bodies`.
  void solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);
  /// The impulse along the normal of `contact` from the last solve() [N s].
  double normal_impulse(std::size_t contact) const { return rows_[3 * contact].impulse; }

 private:
  /// One direction of one contact. A unit impulse along it changes the velocities of a and b by their `response`.
  struct Row {
    Vector6d direction_a, direction_b;
    Vector6d response_a, response_b;
    double inverse_effective_mass;
    double target;  // velocity to reach along the row; later the push to reach
    double impulse;
    double push;  // applied against overlaps so far
    int a, b;
  };

  Row make_row(std::span<const ContactBody> bodies, const Contact& contact,
               const Eigen::Vector3d& direction_world) const;
  static double target_push_m_s(std::span<const ContactBody> bodies, const Contact& contact, const Row& normal,
                                double step_s);
  void solve_velocities(std::span<ContactBody> bodies, std::span<const Contact> contacts);
  void solve_overlaps(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);

  std::vector<Row> rows_;  // three for each contact: normal, two tangents; kept so that steps allocate nothing
};

}  // namespace uwsim
