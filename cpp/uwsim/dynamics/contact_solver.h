#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/body_groups.h"
#include "uwsim/dynamics/contact.h"
#include "uwsim/dynamics/island_solver.h"

namespace uwsim {

/// Solves contacts with each body's full inverse mass: no penetration (Signorini), Newton's restitution above a
/// threshold speed, Coulomb friction. Overlaps beyond a slop are relaxed through `push_body`.
///
/// Bodies that touch each other, directly or through others, form an island, which IslandSolver solves. Islands for
/// which it does not converge are solved by projected Gauss-Seidel on impulses, one tangent after the other (Catto
/// 2005; Erleben 2007).
class ContactSolver {
 public:
  /// Allocates in advance, so that solve() allocates nothing for this many contacts.
  void reserve(std::size_t bodies, std::size_t contacts);
  /// Changes velocity_body, impulse_body and push_body of `bodies`.
  void solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);
  /// The impulse of contact `index` from the last solve(), along its normal [N s], and on its body a [N s].
  double normal_impulse(std::size_t index) const { return impulses_[index][0]; }
  Eigen::Vector3d impulse_world(const Contact& contact, std::size_t index) const;

 private:
  using Four = Eigen::Array4d;  // along the normal and two tangents; the fourth is unused

  /// One end of a contact. The velocity along the three directions is `along` times the body's velocity; column k of
  /// `response` is the change in the body's velocity due to a unit impulse along direction k.
  struct End {
    int body;
    Eigen::Matrix<double, 4, 6> along, to_impulse;  ///< `to_impulse` is Rows::to_impulse times `along`
    Eigen::Matrix<double, 6, 3> response;
  };
  /// Gauss-Seidel updates the three directions in turn. Without limits, this is a single linear map from velocities to
  /// changes of the impulses: `to_impulse`, the inverse of the lower triangle of `response`.
  struct Rows {
    std::size_t contact;
    End a, b;
    Eigen::Matrix3d response;  ///< change in the velocities along the three directions due to unit impulses along them
    Eigen::Matrix3d to_impulse;
    Eigen::Array3d impulse = Eigen::Array3d::Zero();
    double friction;
    double target;    ///< velocity to reach along the normal; later, the push to reach
    double push = 0;  ///< along the normal, applied so far to reduce overlaps
  };

  static void make_end(std::span<const ContactBody> bodies, int body, const Contact& contact, double sign, End& end);
  static void make_rows(std::span<const ContactBody> bodies, const Contact& contact, Rows& rows);
  static Four velocity(std::span<const ContactBody> bodies, const Rows& rows, Vector6d ContactBody::*of);
  void solve_island(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);
  static Eigen::Array3d limited_impulse(std::span<const ContactBody> bodies, const Rows& rows);
  static bool solve_contact(std::span<ContactBody> bodies, Rows& rows);
  void solve_velocities(std::span<ContactBody> bodies);
  void solve_overlaps(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s);

  // Kept between steps to reuse memory.
  BodyGroups islands_;
  std::vector<std::uint32_t> island_;      // indices of the contacts of the island being solved
  std::vector<Rows> rows_;                 // of the contacts solved by Gauss-Seidel
  std::vector<Eigen::Vector3d> impulses_;  // of each contact, along the normal and the tangents
  IslandSolver newton_;
};

}  // namespace uwsim
