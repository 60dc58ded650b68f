#include "uwsim/dynamics/island_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

constexpr int kMostSteps = 12;  // of Newton's method, for one body; more than 9 never helped
constexpr int kMostStepsWithArm = 40;
constexpr int kStepsPerBody = 4;
constexpr int kPushSweeps = 20;
constexpr double kWeights[] = {1, 0.5};  // r; the second is tried if the first does not converge
// The smallest impulse of a contact that counts as holding a body.
constexpr double kPresses = 1e-5;   // relative to the largest
constexpr double kRounding = 1e-9;  // relative, of an impulse
// The largest permitted error of an impulse, relative to the largest impulse: the target, and the value that is
// accepted once a step no longer gains a digit.
constexpr double kAim = 1e-13, kGoodEnough = 1e-9;

}  // namespace

void IslandSolver::reserve(std::size_t bodies, std::size_t contacts) {
  members_.reserve(std::min(bodies, kMostBodies + 1));
  members_of_bodies_.resize(bodies);
  points_.reserve(contacts);
  ends_.reserve(2 * contacts);
  if (bodies > 1 && !equations_) equations_ = std::make_unique<Equations>();
}

bool IslandSolver::solve(std::span<ContactBody> bodies, std::span<const Contact> contacts,
                         std::span<const std::uint32_t> island, double step_s, std::span<Eigen::Vector3d> impulses) {
  members_.clear();
  points_.clear();
  ends_.clear();
  step_s_ = step_s;
  reserve(bodies.size(), island.size());
  const auto armed = [&](int body) {
    return body != kFixedBody && bodies[static_cast<std::size_t>(body)].arm != nullptr;
  };
  has_arm_ = std::ranges::any_of(
      island, [&](std::uint32_t index) { return armed(contacts[index].a) || armed(contacts[index].b); });
  if (has_arm_ && !equations_) equations_ = std::make_unique<Equations>();
  for (const std::uint32_t index : island) {
    add_point(bodies, contacts[index], index, step_s);
    if (members_.size() > kMostBodies && !has_arm_) return false;
  }
  for (std::size_t k = 0; has_arm_ && k < members_.size(); ++k) {
    if (members_[k].body != nullptr && members_[k].body->arm != nullptr) add_joints(k);
  }
  const bool too_large = members_.size() > kMostBodies;
  if (too_large || std::ranges::none_of(kWeights, [&](double weight) { return find_impulses(weight); })) {
    if (!has_arm_) return false;
    relax();
  } else {
    find_grip();
  }
  for (const Point& point : points_) {  // any impulse that is left at an open contact is rounding error
    if (point.contact != nullptr && point.slope(0, 0) > 0) impulses[point.index] = point.impulse;
  }
  move_bodies();
  separate_overlaps(step_s);
  return true;
}

void IslandSolver::move_bodies() {
  for (std::size_t k = 0; k < members_.size(); ++k) {
    Member& member = members_[k];
    if (member.body == nullptr) continue;
    if (member.body->arm != nullptr) {
      changed_by_arm(k);
      const Matrix6d factor = member.body->arm->mass_factor.topLeftCorner<6, 6>();
      const Vector6d change = extended_.head<6>();
      member.body->impulse_body += factor.triangularView<Eigen::Lower>() * change;
      continue;
    }
    member.body->velocity_body += member.factor * member.change;
    member.body->impulse_body += member.factor.transpose().triangularView<Eigen::Upper>().solve(member.change);
  }
}

std::size_t IslandSolver::member_of(std::span<ContactBody> bodies, int body) {
  const auto index = static_cast<std::size_t>(body);
  const std::size_t known = members_of_bodies_[index];
  if (known < members_.size() && members_[known].body == &bodies[index]) return known;
  Member& member = members_.emplace_back();
  member.body = &bodies[index];
  member.body_from_world = bodies[index].world_from_body.rotation().transpose();
  const std::size_t found = members_.size() - 1;
  members_of_bodies_[index] = static_cast<std::uint32_t>(found);
  if (bodies[index].arm == nullptr) {
    member.factor = bodies[index].inverse_mass.llt().matrixL();
  } else {
    for (std::size_t further = 1; further < blocks(bodies[index]); ++further) members_.emplace_back().body = nullptr;
  }
  return found;
}

/// The row whose product with the body's velocity is this end's contribution to the contact's velocity in `direction`.
Vector6d IslandSolver::row(const End& end, const Contact& contact, const Eigen::Vector3d& direction_world) const {
  const Member& member = members_[end.member];
  const Eigen::Vector3d direction = member.body_from_world * (end.sign * direction_world);
  const Eigen::Vector3d arm =
      member.body_from_world * (contact.point_world_m - member.body->world_from_body.position_m);
  Vector6d row;
  row << direction, arm.cross(direction);
  return row;
}

void IslandSolver::add_point(std::span<ContactBody> bodies, const Contact& contact, std::size_t index, double step_s) {
  Point& point = points_.emplace_back();
  point.contact = &contact;
  point.joint = nullptr;
  point.index = index;
  point.first_end = ends_.size();
  point.has_tangents = false;
  point.start_m_s = 0;
  double end_m_s = 0, response = 0;
  for (const bool is_a : {true, false}) {
    if (!is_a && contact.b == kFixedBody) continue;
    const std::size_t first = ends_.size(), member = member_of(bodies, is_a ? contact.a : contact.b);
    const ContactBody& body = *members_[member].body;
    const int link = is_a ? contact.link_a : contact.link_b;
    for (std::size_t block = 0; block < blocks(body); ++block) {
      End& end = ends_.emplace_back();
      end.member = member + block;
      end.sign = is_a ? 1 : -1;
      end.link = link;
    }
    const std::span<End> ends = std::span(ends_).subspan(first);
    const Vector6d normal = row(ends[0], contact, contact.normal_world);
    end_m_s += normal.dot(body.velocity_body);
    point.start_m_s += normal.dot(body.start_velocity_body);
    if (body.arm == nullptr) {
      ends[0].columns.col(0) = members_[member].factor.transpose() * normal;
    } else {
      body.arm->extend(normal, link, extended_);
      set_columns(ends, *body.arm, 0);
      end_m_s += body.arm->speed_along(normal, link, &ContactArm::Joint::speed);
      point.start_m_s += body.arm->speed_along(normal, link, &ContactArm::Joint::start_speed);
    }
    for (const End& end : ends) response += end.columns.col(0).squaredNorm();
  }
  point.end_count = ends_.size() - point.first_end;
  point.mass_kg = 1 / response;
  point.demanded_m_s = contact.least_speed_m_s(point.start_m_s, end_m_s, step_s);
  point.free_m_s[0] = end_m_s - point.demanded_m_s;
}

void IslandSolver::add_tangents(Point& point) {
  const Eigen::Matrix3d directions = point.contact->directions_world();
  point.free_m_s.tail<2>().setZero();
  const std::span<End> ends = touched(point);
  for (std::size_t at = 0; at < ends.size(); ++at) {
    End& end = ends[at];
    const Member& member = members_[end.member];
    if (member.body == nullptr) continue;  // set with the block before it
    const ContactArm* const arm = member.body->arm;
    for (const Eigen::Index k : {1, 2}) {
      const Vector6d tangent = row(end, *point.contact, directions.col(k));
      point.free_m_s[k] += tangent.dot(member.body->velocity_body);
      if (arm == nullptr) {
        end.columns.col(k) = member.factor.transpose() * tangent;
      } else {
        arm->extend(tangent, end.link, extended_);
        set_columns(ends.subspan(at, blocks(*member.body)), *arm, k);
        point.free_m_s[k] += arm->speed_along(tangent, end.link, &ContactArm::Joint::speed);
      }
    }
  }
  point.has_tangents = true;
}

/// The velocity due to the present impulses; along the normal, relative to the required velocity.
double IslandSolver::excess_m_s(const Point& point, Eigen::Index direction) const {
  double sum = point.free_m_s[direction];
  for (const End& end : touched(point)) sum += end.columns.col(direction).dot(members_[end.member].change);
  return sum;
}

/// Sets `shift` and `slope`, and returns by how much the impulse differs from its projection P. With r m v = `force`,
/// the slope is (1 - P' + compliance P')^-1 r m P', where P' = 0 for a contact that opens, 1 for one that sticks, and
/// (1, 0; friction d, c Q) for one that slides along d, with Q = 1 - d d^T.
double IslandSolver::linearize(double weight, Point& point) {
  if (point.joint != nullptr) return linearize_joint(point);
  const double mass = weight * point.mass_kg;
  const double normal_force = mass * excess_m_s(point, 0);
  const double normal = point.impulse[0] - normal_force;
  point.slope.setZero();
  if (!(normal > 0)) {
    point.shift = -point.impulse;
    return point.impulse.cwiseAbs().maxCoeff();
  }
  if (!point.has_tangents) add_tangents(point);
  const double friction = point.contact->friction;
  const Eigen::Vector2d force = mass * Eigen::Vector2d(excess_m_s(point, 1), excess_m_s(point, 2));
  const Eigen::Vector2d tangent = point.impulse.tail<2>() - force;
  const double stiffness = mass / kCompliance, limit = friction * normal, size = tangent.norm();
  point.shift[0] = -normal_force / kCompliance;
  if (size <= limit) {
    point.slope.diagonal().setConstant(stiffness);
    point.shift.tail<2>() = -force / kCompliance;
    return std::max(std::abs(normal_force), force.cwiseAbs().maxCoeff());
  }
  const Eigen::Vector2d along = tangent / size, error = point.impulse.tail<2>() - limit * along;
  const Eigen::Matrix2d across = Eigen::Matrix2d::Identity() - along * along.transpose();
  const double share = limit / size, rest = (1 - kCompliance) * share;
  point.slope(0, 0) = stiffness;
  point.slope.bottomLeftCorner<2, 1>() = stiffness * friction * along;
  point.slope.bottomRightCorner<2, 2>() = mass * share / (1 - rest) * across;
  point.shift.tail<2>() =
      (1 - kCompliance) * friction * point.shift[0] * along - error - rest / (1 - rest) * (across * error);
  return std::max(std::abs(normal_force), error.cwiseAbs().maxCoeff());
}

/// The equations of a Newton step. Contacts that are open both before and after the step add no cost.
template <typename Matrix, typename Vector>
void IslandSolver::assemble(Matrix& slope, Vector& shift) const {
  slope.setIdentity();
  shift.setZero();
  for (const Point& point : points_) {
    if (!point.has_tangents) continue;
    for (const End& end : touched(point)) {
      const auto at = static_cast<Eigen::Index>(6 * end.member);
      shift.template segment<6>(at) += end.columns * point.shift;
      if (point.slope(0, 0) == 0) continue;
      const Eigen::Matrix<double, 3, 6> turned = point.slope * end.columns.transpose();
      for (const End& other : touched(point)) {
        slope.template block<6, 6>(static_cast<Eigen::Index>(6 * other.member), at).noalias() += other.columns * turned;
      }
    }
  }
}

/// Updates the impulses by a Newton step, given the change in velocity of all members.
template <typename Vector>
void IslandSolver::apply(const Vector& step) {
  for (Member& member : members_) member.change.setZero();
  for (Point& point : points_) {
    if (!point.has_tangents) continue;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    for (const End& end : touched(point)) {
      velocity += end.columns.transpose() * step.template segment<6>(static_cast<Eigen::Index>(6 * end.member));
    }
    point.impulse += point.shift - point.slope * velocity;
    for (const End& end : touched(point)) members_[end.member].change += end.columns * point.impulse;
  }
}

void IslandSolver::improve() {
  if (members_.size() == 1) {  // sizes known to the compiler
    Matrix6d slope;
    Vector6d shift;
    assemble(slope, shift);
    apply(slope.partialPivLu().solve(shift).eval());
    return;
  }
  Equations& all = *equations_;
  const auto rows = static_cast<Eigen::Index>(6 * members_.size());
  all.slope.resize(rows, rows);
  all.shift.resize(rows);
  assemble(all.slope, all.shift);
  all.step = all.lu.compute(all.slope).solve(all.shift);
  apply(all.step);
}

bool IslandSolver::find_impulses(double weight) {
  for (Member& member : members_) member.change.setZero();
  for (Point& point : points_) point.impulse.setZero();
  return has_arm_ ? find_impulses_with_arms(weight) : converge(weight);
}

/// Newton's method, from the present impulses.
bool IslandSolver::converge(double weight) {
  const int for_one = has_arm_ ? kMostStepsWithArm : kMostSteps;
  const int most_steps = for_one + kStepsPerBody * (static_cast<int>(members_.size()) - 1);
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= most_steps; ++step) {
    double error = 0, largest = 0;
    for (Point& point : points_) {
      error = std::max(error, linearize(weight, point));
      largest = std::max(largest, largest_impulse(point));
    }
    const bool settled = error <= kGoodEnough * largest && error > 0.1 * last;
    if (error <= kAim * largest || settled) return true;
    last = error;
    improve();
  }
  return false;
}

void IslandSolver::find_grip() {
  double largest = 0, least = 1;
  bool slides = false;
  for (const Point& point : points_) largest = std::max(largest, point.joint == nullptr ? point.impulse[0] : 0);
  for (const Point& point : points_) {
    if (point.joint != nullptr || !(point.slope(0, 0) > 0)) continue;
    const double limit = point.contact->friction * point.impulse[0], used = point.impulse.tail<2>().norm();
    const bool hardly_presses = point.impulse[0] < kPresses * largest;
    slides = slides || (!hardly_presses && used >= (1 - kRounding) * limit);
    least = hardly_presses || !(limit > 0) ? 0 : std::min(least, 1 - used / limit);
  }
  for (Member& member : members_) {
    if (member.body == nullptr) continue;
    member.body->grip = std::max(least, 0.0);
    member.body->slides = slides;
  }
}

void IslandSolver::separate_overlaps(double step_s) {
  bool any = false;
  for (Point& point : points_) {
    if (point.joint != nullptr) continue;
    const double end_m_s = point.demanded_m_s + excess_m_s(point, 0);
    point.demanded_m_s = point.contact->push_m_s(point.start_m_s, end_m_s, step_s);
    point.impulse[0] = 0;
    any = any || point.demanded_m_s > 0;
  }
  if (!any) return;
  for (Member& member : members_) member.change.setZero();  // from here on, due to the pushes
  for (int sweep = 0; sweep < kPushSweeps; ++sweep) {
    bool changes = false;
    for (Point& point : points_) {
      if (point.joint != nullptr || point.demanded_m_s <= 0) continue;
      double speed_m_s = 0;
      for (const End& end : touched(point)) speed_m_s += end.columns.col(0).dot(members_[end.member].change);
      const double after = std::max(0.0, point.impulse[0] + (point.demanded_m_s - speed_m_s) * point.mass_kg);
      const double change = after - point.impulse[0];
      if (change == 0) continue;
      changes = true;
      point.impulse[0] = after;
      for (const End& end : touched(point)) members_[end.member].change += change * end.columns.col(0);
    }
    if (!changes) break;
  }
  for (std::size_t k = 0; k < members_.size(); ++k) {
    const Member& member = members_[k];
    if (member.body == nullptr) continue;
    if (member.body->arm == nullptr) {
      member.body->push_body += member.factor * member.change;
      continue;
    }
    changed_by_arm(k);
    ContactArm& arm = *member.body->arm;
    arm.mass_factor.triangularView<Eigen::Lower>().transpose().solveInPlace(extended_);
    member.body->push_body += extended_.head<6>();
    for (std::size_t j = 0; j < arm.joints.size(); ++j)
      arm.joints[j].push_speed = extended_[6 + static_cast<Eigen::Index>(j)];
  }
}

}  // namespace uwsim
