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
class IslandSolver {
 public:
  /// The limit for one island; the work grows with the cube of the number of bodies.
  static constexpr std::size_t kMostBodies = 16;

  void reserve(std::size_t bodies, std::size_t contacts);
  /// `island`: indices of the island's contacts. Changes velocity_body, impulse_body, push_body and grip of its bodies,
  /// and sets the impulses of its contacts along the normal and two tangents [N s]. Returns false, changing nothing, if
  /// the method does not converge or there are too many bodies.
  bool solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, std::span<const std::uint32_t> island,
             double step_s, std::span<Eigen::Vector3d> impulses);

 private:
  using Columns = Eigen::Matrix<double, 6, 3>;
  static constexpr int kMostRows = 6 * static_cast<int>(kMostBodies);
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostRows, kMostRows>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostRows, 1>;

  struct Member {
    ContactBody* body;
    Eigen::Matrix3d body_from_world;
    Matrix6d factor;  ///< L of the inverse mass L L^T
    Vector6d change;  ///< of the velocity due to all impulses, in coordinates of mass 1
  };
  struct End {
    std::size_t member;
    double sign;      ///< 1 for body a of the contact, -1 for b
    Columns columns;  ///< of the normal and two tangents, in coordinates of mass 1
  };
  struct Point {
    const Contact* contact;
    std::size_t index;
    std::size_t end_count;
    End ends[2];
    Eigen::Vector3d free_m_s;        ///< velocity without contacts; along the normal, relative to the required velocity
    double demanded_m_s, start_m_s;  ///< along the normal
    double mass_kg;                  ///< effective mass for an impulse along the normal
    bool has_tangents;               ///< set once the contact is loaded
    Eigen::Vector3d impulse;
    /// In a Newton step, the impulse changes by `shift` - `slope` (change of velocity).
    Eigen::Vector3d shift;
    Eigen::Matrix3d slope;

    std::span<End> touched() { return {ends, end_count}; }
    std::span<const End> touched() const { return {ends, end_count}; }
  };
  /// For islands of more than one body.
  struct Equations {
    Square slope;
    Column shift, step;
    Eigen::PartialPivLU<Square> lu;
  };

  std::size_t member_of(std::span<ContactBody> bodies, int body);
  Vector6d row(const End& end, const Contact& contact, const Eigen::Vector3d& direction_world) const;
  void add_point(std::span<ContactBody> bodies, const Contact& contact, std::size_t index, double step_s);
  void add_tangents(Point& point) const;
  double excess_m_s(const Point& point, Eigen::Index direction) const;
  double linearize(double weight, Point& point) const;
  template <typename Matrix, typename Vector>
  void assemble(Matrix& slope, Vector& shift) const;
  template <typename Vector>
  void apply(const Vector& step);
  void improve();
  bool find_impulses(double weight);
  void find_grip();
  void separate_overlaps(double step_s);

  std::vector<Member> members_;
  std::vector<std::uint32_t> members_of_bodies_;  // by body: its index in members_, valid if that member is this body
  std::vector<Point> points_;
  std::unique_ptr<Equations> equations_;
};

}  // namespace uwsim
