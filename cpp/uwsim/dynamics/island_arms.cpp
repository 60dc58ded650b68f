#include <algorithm>
#include <cmath>

#include "uwsim/dynamics/island_solver.h"

// The part of IslandSolver for bodies with arms.
namespace uwsim {
namespace {

constexpr int kArmSweeps = 100;  // of Gauss-Seidel
constexpr double kArmsSettled = 1e-13;
constexpr double kDamper = 1e-4;  // mass per stiffness of the damper
constexpr int kHalvings = 60;
constexpr int kRounds = 8;  // of the method of multipliers
constexpr double kRoundsSettled = 1e-10;

}  // namespace

/// Sets `extended_` to the change of all coordinates of a body with an arm.
void IslandSolver::changed_by_arm(std::size_t member) {
  const ContactArm& arm = *members_[member].body->arm;
  extended_.resize(arm.size());
  for (Eigen::Index row = 0; row < arm.size(); ++row)
    extended_[row] = members_[member + static_cast<std::size_t>(row / 6)].change[row % 6];
}

std::size_t IslandSolver::blocks(const ContactBody& body) {
  return body.arm == nullptr ? 1 : static_cast<std::size_t>((body.arm->size() + 5) / 6);
}

/// Sets the columns of a body's ends for a contact's row, C^-1 J^T.
void IslandSolver::set_columns(std::span<End> ends, const ContactArm& arm, Eigen::Index direction) {
  arm.mass_factor.triangularView<Eigen::Lower>().solveInPlace(extended_);
  for (std::size_t block = 0; block < ends.size(); ++block) {
    for (Eigen::Index row = 0; row < 6; ++row) {
      const Eigen::Index at = static_cast<Eigen::Index>(6 * block) + row;
      ends[block].columns(row, direction) = at < arm.size() ? extended_[at] : 0;
    }
  }
}

/// Adds the laws of the joints of a body with an arm.
void IslandSolver::add_joints(std::size_t member) {
  const ContactArm& arm = *members_[member].body->arm;
  for (std::size_t k = 0; k < arm.joints.size(); ++k) {
    Point& point = points_.emplace_back();
    point.contact = nullptr;
    point.joint = &arm.joints[k];
    point.first_end = ends_.size();
    point.end_count = blocks(*members_[member].body);
    point.has_tangents = true;
    for (std::size_t block = 0; block < point.end_count; ++block)
      ends_.push_back({member + block, 1, kHull, Columns::Zero()});
    extended_.setZero(arm.size());
    extended_[6 + static_cast<Eigen::Index>(k)] = 1;
    const std::span<End> ends = touched(point);
    set_columns(ends, arm, 0);
    double response = 0;
    for (const End& end : ends) response += end.columns.col(0).squaredNorm();
    point.mass_kg = 1 / response;
    point.free_m_s = {arm.joints[k].speed, 0, 0};
  }
}

/// Returns the point of a joint's law at `mixed`, or that at a jump of the law between the last point and this one:
/// otherwise Newton's method could alternate between both sides of the jump for ever.
JointLaw::Point IslandSolver::next_on_law(Point& point, double mixed, double scale) {
  const JointLaw& law = point.joint->law;
  JointLaw::Point found = law.point_at(mixed, scale);
  if (point.is_flat && !found.at_jump) {
    const double before = law.point_at(point.mixed, scale).torque;
    double near = point.mixed;
    for (int halving = 0; halving < kHalvings && !found.at_jump && found.torque != before; ++halving) {
      const double middle = near + (mixed - near) / 2;
      const JointLaw::Point between = law.point_at(middle, scale);
      if (!between.at_jump && between.torque == before) {
        near = middle;
      } else {
        mixed = middle;
        found = between;
      }
    }
  }
  point.mixed = mixed;
  point.is_flat = !found.at_jump;
  return found;
}

/// As linearize(), for the law of a joint, whose impulse is counted from that without contacts. Through the damper, the
/// law's point is that of the speed + (impulse - given impulse) / stiffness.
double IslandSolver::linearize_joint(Point& point) const {
  point.slope.setZero();
  point.shift.setZero();
  if (!joints_give_) return 0;
  const double stiffness = point.mass_kg / kDamper, speed = excess_m_s(point, 0);
  const JointLaw::Point law = next_on_law(point, speed - point.given / stiffness, step_s_ / stiffness);
  const double impulse = law.at_jump ? point.given + stiffness * (law.speed - speed) : step_s_ * law.torque;
  point.slope(0, 0) = law.at_jump ? stiffness : 0;
  point.shift[0] = impulse - law_impulse(point);
  return std::abs(point.shift[0]) * (law.at_jump ? kDamper : 1);
}

bool IslandSolver::find_impulses_with_arms(double weight) {
  joints_give_ = false;
  if (!converge(weight)) return false;
  joints_give_ = true;
  for (int round = 0; round < kRounds; ++round) {
    for (Point& point : points_) {
      if (point.joint == nullptr) continue;
      point.given = law_impulse(point);
      point.is_flat = false;
    }
    if (!converge(weight)) return false;
    double change = 0, largest = 0;
    for (const Point& point : points_) {
      largest = std::max(largest, largest_impulse(point));
      if (point.joint != nullptr) change = std::max(change, std::abs(law_impulse(point) - point.given));
    }
    if (change <= kRoundsSettled * largest) break;
  }
  return true;
}

double IslandSolver::largest_impulse(const Point& point) const {
  if (point.joint != nullptr) return std::abs(law_impulse(point));
  return point.impulse.cwiseAbs().maxCoeff();
}

/// Projected Gauss-Seidel, one point after the other.
void IslandSolver::relax() {
  for (Member& member : members_) member.change.setZero();
  for (Point& point : points_) {
    point.impulse.setZero();
    if (!point.has_tangents) add_tangents(point);
  }
  for (int sweep = 0; sweep < kArmSweeps; ++sweep) {
    bool changes = false;
    for (Point& point : points_) changes = relax(point) || changes;
    if (!changes) break;
  }
  for (Point& point : points_) point.slope(0, 0) = point.impulse[0] > 0 ? 1 : 0;
}

/// Returns whether the impulse changed by more than rounding.
bool IslandSolver::relax(Point& point) {
  const Eigen::Vector3d before = point.impulse;
  if (point.joint != nullptr) {
    const double mass = point.mass_kg, impulse = law_impulse(point);
    const double mixed = excess_m_s(point, 0) - impulse / mass;
    const JointLaw::Point law = point.joint->law.point_at(mixed, step_s_ / mass);
    point.impulse[0] += (law.at_jump ? mass * (law.speed - mixed) : step_s_ * law.torque) - impulse;
  } else {
    point.impulse[0] = std::max(0.0, before[0] - point.mass_kg * excess_m_s(point, 0));
  }
  const auto give = [&](const Eigen::Vector3d& change) {
    if (change.isZero(0)) return;
    for (const End& end : touched(point)) members_[end.member].change += end.columns * change;
  };
  give(point.impulse - before);
  if (point.joint == nullptr) {
    const double limit = point.contact->friction * point.impulse[0];
    for (const Eigen::Index k : {1, 2}) {
      double response = 0;
      for (const End& end : touched(point)) response += end.columns.col(k).squaredNorm();
      point.impulse[k] -= excess_m_s(point, k) / response;
    }
    const double size = point.impulse.tail<2>().norm();
    if (size > limit) point.impulse.tail<2>() *= limit / size;
    give({0, point.impulse[1] - before[1], point.impulse[2] - before[2]});
  }
  return (point.impulse - before).cwiseAbs().maxCoeff() > kArmsSettled * largest_impulse(point);
}

}  // namespace uwsim
