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
  void reserve(std::size_t contacts) { rows_.reserve(contacts); }
  /// Changes velocity_body, impulse_body and push_body of `bodies`.
  void solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);
  /// The impulse along the normal of `contact` from the last solve() [N s].
  double normal_impulse(std::size_t contact) const { return rows_[contact].impulse[0]; }

 private:
  using Four = Eigen::Array4d;  // along the normal, two tangents, and nothing

  /// One end of a contact. The velocity along the three directions is `along` times the body's velocity; column k of
  /// `response` is the change of the body's velocity by a unit impulse along direction k.
  struct End {
    int body;
    Eigen::Matrix<double, 4, 6> along, to_impulse;  ///< `to_impulse` is Rows::to_impulse times `along`
    Eigen::Matrix<double, 6, 3> response;
  };
  /// Gauss-Seidel takes the three directions in turn. Without limits that is one linear map from speeds to changes of
  /// impulses, `to_impulse`, the inverse of the lower triangle of `response`.
  struct Rows {
    End a, b;
    Eigen::Matrix3d response;  ///< of the velocities along the three directions to impulses along them
    Eigen::Matrix3d to_impulse;
    Eigen::Array3d impulse = Eigen::Array3d::Zero();
    double friction;
    double target;    ///< velocity to reach along the normal; later the push to reach
    double push = 0;  ///< along the normal, applied against overlaps so far
  };

  static void make_end(std::span<const ContactBody> bodies, int body, const Contact& contact, double sign, End& end);
  static void make_rows(std::span<const ContactBody> bodies, const Contact& contact, Rows& rows);
  static Four velocity(std::span<const ContactBody> bodies, const Rows& rows, Vector6d ContactBody::*of);
  static double target_m_s(std::span<const ContactBody> bodies, const Contact& contact, const Rows& rows,
                           double step_s);
  static double target_push_m_s(std::span<const ContactBody> bodies, const Contact& contact, const Rows& rows,
                                double step_s);
  static Eigen::Array3d limited_impulse(std::span<const ContactBody> bodies, const Rows& rows);
  static bool solve_contact(std::span<ContactBody> bodies, Rows& rows);
  void solve_velocities(std::span<ContactBody> bodies);
  void solve_overlaps(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);

  std::vector<Rows> rows_;  // one for each contact; kept so that steps allocate nothing
};

}  // namespace uwsim
