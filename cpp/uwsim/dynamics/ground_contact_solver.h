#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/contact.h"

namespace uwsim {

/// Solves the contacts of one body with the fixed world by Newton's method, to rounding error.
///
/// The impulse p of each contact is the projection of `p - r m v` onto Coulomb's cone, where v is the velocity in
/// excess of the required one and m the effective mass along the normal; the cone's radius follows from the normal
/// component of p (Alart and Curnier 1991, Comput. Methods Appl. Mech. Eng. 92:353). Newton's method solves this for
/// all contacts simultaneously. A small compliance, which vanishes as the method converges, shares the load among
/// contacts that oppose the same motion. All quantities are in coordinates in which the body's mass is 1, and each
/// iteration solves six equations, regardless of the number of contacts.
class GroundContactSolver {
 public:
  void reserve(std::size_t contacts) { points_.reserve(contacts); }
  /// Changes velocity_body, impulse_body, push_body and grip of `body`, and sets the impulses along the normals [N s].
  /// If the method does not converge, returns false without changing anything.
  bool solve(ContactBody& body, std::span<const Contact> contacts, double step_s, std::span<double> normal_impulses);

 private:
  struct Point {
    Eigen::Matrix<double, 6, 3> columns;  ///< of the normal and two tangents, in coordinates of mass 1
    Eigen::Vector3d free_m_s;             ///< velocity without contacts; normal component in excess of the required one
    double demanded_m_s, start_m_s;       ///< along the normal
    double mass_kg;                       ///< effective mass for an impulse along the normal
    double friction;
    bool has_tangents = false;  ///< set once the contact presses
    Eigen::Vector3d impulse;
    /// In an iteration, the impulse changes by `shift` minus `slope` times the change of the velocity.
    Eigen::Vector3d shift;
    Eigen::Matrix3d slope;
  };
  struct Frame;

  void add_point(const Frame& frame, const ContactBody& body, const Contact& contact, double step_s);
  static void add_tangents(const Frame& frame, const ContactBody& body, const Contact& contact, Point& point);
  double linearize(const Frame& frame, const ContactBody& body, const Contact& contact, double weight,
                   Point& point) const;
  void improve();
  bool find_impulses(const Frame& frame, const ContactBody& body, std::span<const Contact> contacts, double weight);
  double grip() const;
  void separate_overlaps(const Frame& frame, ContactBody& body, std::span<const Contact> contacts, double step_s);

  std::vector<Point> points_;
  Vector6d change_ = Vector6d::Zero();  // of the velocity due to all impulses, in coordinates of mass 1
};

}  // namespace uwsim
