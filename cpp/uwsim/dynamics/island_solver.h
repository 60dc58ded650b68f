#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "uwsim/core/body_state.h"
#include "uwsim/dynamics/contact.h"

namespace uwsim {

/// Solves the contacts of an island (bodies that touch each other and the fixed world) to rounding error, by Newton's
/// method.
///
/// The impulse p of each contact is the projection of `p - r m v` onto Coulomb's cone, whose radius is determined by
/// the normal component of `p - r m v`. Here v is the velocity in excess of the required velocity, and m is the
/// effective mass along the normal (Alart and Curnier 1991, Comput. Methods Appl. Mech. Eng. 92:353). Newton's method
/// solves this for all contacts simultaneously. A small compliance, whose effect vanishes as the method converges,
/// distributes the load among contacts that oppose the same motion. All quantities are in coordinates in which each
/// body's mass is 1. A Newton step solves six equations per body, regardless of the number of contacts.
///
/// A body with an arm has as many coordinates more as it has joints, in blocks of six. The laws of its joints
/// (ContactArm) are solved with the contacts: first each has the impulse that it has without contacts, then it follows
/// its law as if through a stiff damper, whose effect the method of multipliers removes (Rockafellar 1976, SIAM J.
/// Control Optim. 14:877). A motor therefore gives way where a contact needs more than it has. Where Newton's method
/// does not converge for such an island, or it is too large, projected Gauss-Seidel solves the same equations.
class IslandSolver {
 public:
  /// The limit for one island; the work grows with the cube of the number of bodies.
  static constexpr std::size_t kMostBodies = 16;

  void reserve(std::size_t bodies, std::size_t contacts);
  /// `island`: indices of the island's contacts. Changes velocity_body, impulse_body, push_body and grip of its bodies,
  /// and sets the impulses of its contacts along the normal and two tangents [N s]. Returns false, changing nothing, if
  /// the method does not converge or there are too many bodies; never if one has an arm.
  bool solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, std::span<const std::uint32_t> island,
             double step_s, std::span<Eigen::Vector3d> impulses);

 private:
  using Columns = Eigen::Matrix<double, 6, 3>;
  static constexpr double kCompliance = 1e-5;  // of a contact, relative to 1 / mass
  static constexpr int kMostRows = 6 * static_cast<int>(kMostBodies);
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostRows, kMostRows>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostRows, 1>;

  /// A body, or a further six of the coordinates of the body with an arm before it.
  struct Member {
    ContactBody* body;  ///< null for further coordinates
    Eigen::Matrix3d body_from_world;
    Matrix6d factor;  ///< L of the inverse mass L L^T; unused with an arm
    Vector6d change;  ///< of the velocity due to all impulses, in coordinates of mass 1
  };
  struct End {
    std::size_t member;
    double sign;      ///< 1 for body a of the contact, -1 for b
    int link;         ///< of the body's arm, or kHull
    Columns columns;  ///< of the normal and two tangents, in coordinates of mass 1
  };
  /// A contact, or the law of a joint, whose impulse is along its first direction alone.
  struct Point {
    const Contact* contact;  ///< null for a joint
    const ContactArm::Joint* joint;
    std::size_t index;
    std::size_t first_end, end_count;
    Eigen::Vector3d free_m_s;        ///< velocity without contacts; along the normal, relative to the required velocity
    double demanded_m_s, start_m_s;  ///< along the normal
    double mass_kg;                  ///< effective mass for an impulse along the normal
    bool has_tangents;               ///< set once the contact is loaded
    Eigen::Vector3d impulse;
    // For a joint:
    double given;  ///< the impulse of its law from which it gives way
    double mixed;  ///< where on its law it was last
    bool is_flat;  ///< whether that was between two jumps; false at first
    /// In a Newton step, the impulse changes by `shift` - `slope` (change of velocity).
    Eigen::Vector3d shift;
    Eigen::Matrix3d slope;
  };
  /// For islands of more than one body.
  struct Equations {
    Square slope;
    Column shift, step;
    Eigen::PartialPivLU<Square> lu;
  };

  std::span<End> touched(const Point& point) { return std::span(ends_).subspan(point.first_end, point.end_count); }
  std::span<const End> touched(const Point& point) const {
    return std::span(ends_).subspan(point.first_end, point.end_count);
  }
  std::size_t member_of(std::span<ContactBody> bodies, int body);
  void add_joints(std::size_t member);
  static std::size_t blocks(const ContactBody& body);
  Vector6d row(const End& end, const Contact& contact, const Eigen::Vector3d& direction_world) const;
  void set_columns(std::span<End> ends, const ContactArm& arm, Eigen::Index direction);
  void add_point(std::span<ContactBody> bodies, const Contact& contact, std::size_t index, double step_s);
  void add_tangents(Point& point);
  double excess_m_s(const Point& point, Eigen::Index direction) const;
  double linearize(double weight, Point& point);
  double linearize_joint(Point& point) const;
  static JointLaw::Point next_on_law(Point& point, double mixed, double scale);
  double largest_impulse(const Point& point) const;
  template <typename Matrix, typename Vector>
  void assemble(Matrix& slope, Vector& shift) const;
  template <typename Vector>
  void apply(const Vector& step);
  void improve();
  bool find_impulses(double weight);
  bool find_impulses_with_arms(double weight);
  bool converge(double weight);
  double law_impulse(const Point& point) const { return step_s_ * point.joint->torque + point.impulse[0]; }
  void relax();
  bool relax(Point& point);
  void move_bodies();
  void changed_by_arm(std::size_t member);
  void find_grip();
  void separate_overlaps(double step_s);

  std::vector<Member> members_;
  std::vector<std::uint32_t> members_of_bodies_;  // by body: its index in members_, valid if that member is this body
  std::vector<Point> points_;
  std::vector<End> ends_;  // of the points
  double step_s_ = 0;
  bool has_arm_ = false, joints_give_ = false;
  Eigen::VectorXd extended_;  // kept so that steps allocate nothing
  std::unique_ptr<Equations> equations_;
};

}  // namespace uwsim
