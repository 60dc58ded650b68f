#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/contact.h"

namespace uwsim {

/// Solves the contacts of one body with the fixed world, to rounding, by Newton's method.
///
/// The impulse p of each contact is the projection of `p - r m v` onto Coulomb's cone, whose radius follows from its
/// own normal part, where v is the velocity in excess of the demanded one and m the effective mass along the normal
/// (Alart and Curnier 1991, Comput. Methods Appl. Mech. Eng. 92:353). Newton's method solves that for all contacts at
/// once. A small compliance, which fades as it converges, shares the load among contacts that oppose the same motion.
/// All quantities are in coordinates in which the body's mass is 1, and a step of the method solves six equations,
/// however many contacts there are.
class GroundContactSolver {
 public:
  void reserve(std::size_t contacts) { points_.reserve(contacts); }
  /// Changes velocity_body, impulse_body, push_body and grip of `body`, and sets the impulses along the normals [N s].
  /// Returns false, changing nothing, if the method does not converge.
  bool solve(ContactBody& body, std::span<const Contact> contacts, double step_s, std::span<double> normal_impulses);

 private:
  struct Point {
    Eigen::Matrix<double, 6, 3> columns;  ///< of the normal and two tangents, in coordinates of mass 1
    Eigen::Vector3d free_m_s;             ///< velocity without contacts, along the normal in excess of the demanded one
    double demanded_m_s, start_m_s;       ///< along the normal
    double mass_kg;                       ///< effective mass for an impulse along the normal
    double friction;
    bool has_tangents = false;  ///< set once it presses
    Eigen::Vector3d impulse;
    /// In a step of Newton's method, the impulse changes by `shift` - `slope` (change of velocity).
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
