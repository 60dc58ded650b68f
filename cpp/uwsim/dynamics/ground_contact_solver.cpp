#include "uwsim/dynamics/ground_contact_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

constexpr int kMostSteps = 12;  // of Newton's method; more than 9 have never helped
constexpr int kPushSweeps = 20;
constexpr double kWeights[] = {1, 0.5};  // values of r; the second is tried if the first does not converge
constexpr double kCompliance = 1e-5;     // of a contact, as a fraction of 1 / mass
// Smallest impulse that counts as helping to hold a body.
constexpr double kPresses = 1e-5;  // relative to the largest impulse
// Error of the impulses relative to the largest one: the target, and the value that is accepted when a further step
// gains no digit.
constexpr double kAim = 1e-13, kGoodEnough = 1e-9;

}  // namespace

/// The body's axes, and the factor L of the inverse mass L L^T.
struct GroundContactSolver::Frame {
  Eigen::Matrix3d body_from_world;
  Matrix6d factor;

  explicit Frame(const ContactBody& body)
      : body_from_world(body.world_from_body.rotation().transpose()), factor(body.inverse_mass.llt().matrixL()) {}

  /// The row vector whose product with the body's velocity is the contact point's velocity along a direction.
  Vector6d row(const ContactBody& body, const Contact& contact, const Eigen::Vector3d& direction_world) const {
    const Eigen::Vector3d direction = body_from_world * direction_world;
    const Eigen::Vector3d arm = body_from_world * (contact.point_world_m - body.world_from_body.position_m);
    Vector6d row;
    row << direction, arm.cross(direction);
    return row;
  }
  Vector6d on_unit_mass(const Vector6d& row) const { return factor.transpose() * row; }
};

bool GroundContactSolver::solve(ContactBody& body, std::span<const Contact> contacts, double step_s,
                                std::span<double> normal_impulses) {
  const Frame frame(body);
  points_.clear();
  for (const Contact& contact : contacts) add_point(frame, body, contact, step_s);
  const auto found = [&](double weight) { return find_impulses(frame, body, contacts, weight); };
  if (std::ranges::none_of(kWeights, found)) return false;
  for (std::size_t k = 0; k < points_.size(); ++k) {  // the remaining impulse of an open contact is rounding error
    normal_impulses[k] = points_[k].slope(0, 0) > 0 ? points_[k].impulse[0] : 0;
  }
  body.velocity_body += frame.factor * change_;
  body.impulse_body += frame.factor.transpose().triangularView<Eigen::Upper>().solve(change_);
  body.grip = grip();
  separate_overlaps(frame, body, contacts, step_s);
  return true;
}

double GroundContactSolver::grip() const {
  double largest = 0, least = 1;
  for (const Point& point : points_) largest = std::max(largest, point.impulse[0]);
  for (const Point& point : points_) {
    if (!(point.slope(0, 0) > 0)) continue;
    const double limit = point.friction * point.impulse[0];
    if (point.impulse[0] < kPresses * largest || !(limit > 0)) return 0;
    least = std::min(least, 1 - point.impulse.tail<2>().norm() / limit);
  }
  return std::max(least, 0.0);
}

void GroundContactSolver::add_point(const Frame& frame, const ContactBody& body, const Contact& contact,
                                    double step_s) {
  const Vector6d row = frame.row(body, contact, contact.normal_world);
  Point& point = points_.emplace_back();
  point.columns.col(0) = frame.on_unit_mass(row);
  point.mass_kg = 1 / point.columns.col(0).squaredNorm();
  point.friction = contact.friction;
  const double end_m_s = row.dot(body.velocity_body);
  point.start_m_s = row.dot(body.start_velocity_body);
  point.demanded_m_s = contact.least_speed_m_s(point.start_m_s, end_m_s, step_s);
  point.free_m_s[0] = end_m_s - point.demanded_m_s;
}

void GroundContactSolver::add_tangents(const Frame& frame, const ContactBody& body, const Contact& contact,
                                       Point& point) {
  const Eigen::Vector3d one = contact.normal_world.unitOrthogonal(), two = contact.normal_world.cross(one);
  for (const Eigen::Index k : {1, 2}) {
    const Vector6d row = frame.row(body, contact, k == 1 ? one : two);
    point.columns.col(k) = frame.on_unit_mass(row);
    point.free_m_s[k] = row.dot(body.velocity_body);
  }
  point.has_tangents = true;
}

/// Sets `shift` and `slope`, and returns the difference between the impulse and its projection P. With r m v = `force`,
/// the slope is (1 - P' + compliance P')^-1 r m P', where P' = 0 for a contact that opens, 1 for one that sticks, and
/// (1, 0; friction d, c Q) for one that slides along d, with Q = 1 - d d^T.
double GroundContactSolver::linearize(const Frame& frame, const ContactBody& body, const Contact& contact,
                                      double weight, Point& point) const {
  const double mass = weight * point.mass_kg;
  const double normal_force = mass * (point.free_m_s[0] + point.columns.col(0).dot(change_));
  const double normal = point.impulse[0] - normal_force;
  point.slope.setZero();
  if (!(normal > 0)) {
    point.shift = -point.impulse;
    return point.impulse.cwiseAbs().maxCoeff();
  }
  if (!point.has_tangents) add_tangents(frame, body, contact, point);
  const Eigen::Vector2d force = mass * (point.free_m_s.tail<2>() + point.columns.rightCols<2>().transpose() * change_);
  const Eigen::Vector2d tangent = point.impulse.tail<2>() - force;
  const double stiffness = mass / kCompliance, limit = point.friction * normal, size = tangent.norm();
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
  point.slope.bottomLeftCorner<2, 1>() = stiffness * point.friction * along;
  point.slope.bottomRightCorner<2, 2>() = mass * share / (1 - rest) * across;
  point.shift.tail<2>() =
      (1 - kCompliance) * point.friction * point.shift[0] * along - error - rest / (1 - rest) * (across * error);
  return std::max(std::abs(normal_force), error.cwiseAbs().maxCoeff());
}

/// Performs one Newton step. Contacts that are open before and after the step cost nothing.
void GroundContactSolver::improve() {
  Matrix6d slope = Matrix6d::Identity();
  Vector6d shift = Vector6d::Zero();
  for (const Point& point : points_) {
    if (!point.has_tangents) continue;
    shift += point.columns * point.shift;
    if (point.slope(0, 0) == 0) continue;
    const Eigen::Matrix<double, 3, 6> turned = point.slope * point.columns.transpose();
    slope.noalias() += point.columns * turned;
  }
  const Vector6d step = slope.partialPivLu().solve(shift);
  change_.setZero();
  for (Point& point : points_) {
    if (!point.has_tangents) continue;
    point.impulse += point.shift - point.slope * (point.columns.transpose() * step);
    change_ += point.columns * point.impulse;
  }
}

/// Finds the impulses and `change_`.
bool GroundContactSolver::find_impulses(const Frame& frame, const ContactBody& body, std::span<const Contact> contacts,
                                        double weight) {
  change_.setZero();
  for (Point& point : points_) point.impulse.setZero();
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= kMostSteps; ++step) {
    double error = 0, largest = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      error = std::max(error, linearize(frame, body, contacts[k], weight, points_[k]));
      largest = std::max(largest, points_[k].impulse.cwiseAbs().maxCoeff());
    }
    const bool settled = error <= kGoodEnough * largest && error > 0.1 * last;
    if (error <= kAim * largest || settled) return true;
    last = error;
    improve();
  }
  return false;
}

void GroundContactSolver::separate_overlaps(const Frame& frame, ContactBody& body, std::span<const Contact> contacts,
                                            double step_s) {
  bool any = false;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Point& point = points_[k];
    const double end_m_s = point.demanded_m_s + point.free_m_s[0] + point.columns.col(0).dot(change_);
    point.demanded_m_s = contacts[k].push_m_s(point.start_m_s, end_m_s, step_s);
    point.impulse[0] = 0;
    any = any || point.demanded_m_s > 0;
  }
  if (!any) return;
  Vector6d push = Vector6d::Zero();
  for (int sweep = 0; sweep < kPushSweeps; ++sweep) {
    bool changes = false;
    for (Point& point : points_) {
      if (point.demanded_m_s <= 0) continue;
      const auto& column = point.columns.col(0);
      const double after = std::max(0.0, point.impulse[0] + (point.demanded_m_s - column.dot(push)) * point.mass_kg);
      const double change = after - point.impulse[0];
      if (change == 0) continue;
      changes = true;
      point.impulse[0] = after;
      push += change * column;
    }
    if (!changes) break;
  }
  body.push_body += frame.factor * push;
}

}  // namespace uwsim
