#include "uwsim/dynamics/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

constexpr int kSweeps = 20;
constexpr double kBounceThreshold_m_s = 0.05;  // slower impacts do not bounce, so that bodies come to rest
constexpr double kSlop_m = 1e-3;
constexpr double kOverlapShare = 0.2;  // fraction of the overlap beyond the slop that a step removes
constexpr double kPushMax_m_s = 2;     // limit of the push out of deep overlaps

/// The six-vector J with J nu = velocity of the contact point along `direction_world`.
Vector6d point_direction(const ContactBody& body, const Eigen::Vector3d& point_world_m,
                         const Eigen::Vector3d& direction_world) {
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  const Eigen::Vector3d direction = body_from_world * direction_world;
  const Eigen::Vector3d arm = body_from_world * (point_world_m - body.world_from_body.position_m);
  Vector6d j;
  j << direction, arm.cross(direction);
  return j;
}

}  // namespace

ContactSolver::Row ContactSolver::make_row(std::span<const ContactBody> bodies, const Contact& contact,
                                           const Eigen::Vector3d& direction_world) const {
  Row row{};
  row.a = contact.a;
  row.b = contact.b;
  const ContactBody& a = bodies[static_cast<std::size_t>(row.a)];
  row.direction_a = point_direction(a, contact.point_world_m, direction_world);
  row.response_a = a.inverse_mass * row.direction_a;
  double inverse = row.direction_a.dot(row.response_a);
  if (row.b != kFixedBody) {
    const ContactBody& b = bodies[static_cast<std::size_t>(row.b)];
    row.direction_b = point_direction(b, contact.point_world_m, -direction_world);
    row.response_b = b.inverse_mass * row.direction_b;
    inverse += row.direction_b.dot(row.response_b);
  }
  row.inverse_effective_mass = inverse;
  return row;
}

void ContactSolver::solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s) {
  rows_.clear();
  for (const Contact& contact : contacts) {
    const Eigen::Vector3d& n = contact.normal_world;
    const Eigen::Vector3d t1 = n.unitOrthogonal();
    for (const Eigen::Vector3d& direction : {n, t1, n.cross(t1).eval()})
      rows_.push_back(make_row(bodies, contact, direction));
    Row& normal = *(rows_.end() - 3);
    const auto along_normal = [&](Vector6d ContactBody::*velocity) {
      double speed = normal.direction_a.dot(bodies[static_cast<std::size_t>(normal.a)].*velocity);
      if (normal.b != kFixedBody) speed += normal.direction_b.dot(bodies[static_cast<std::size_t>(normal.b)].*velocity);
      return speed;
    };
    const double gap = std::max(0.0, contact.gap_m);
    const bool arrives = along_normal(&ContactBody::velocity_body) * step_s + gap < 0;
    // Speed before the step: what gravity adds within it must not bounce.
    const double approach_m_s = along_normal(&ContactBody::start_velocity_body);
    const bool bounces = arrives && approach_m_s < -kBounceThreshold_m_s;
    normal.target = bounces ? -contact.restitution * approach_m_s : -gap / step_s;
  }
  solve_velocities(bodies, contacts);
  solve_overlaps(bodies, contacts, step_s);
}

void ContactSolver::solve_velocities(std::span<ContactBody> bodies, std::span<const Contact> contacts) {
  const auto apply = [&](Row& row, double impulse) {
    const double change = impulse - row.impulse;
    row.impulse = impulse;
    ContactBody& a = bodies[static_cast<std::size_t>(row.a)];
    a.velocity_body += change * row.response_a;
    a.impulse_body += change * row.direction_a;
    if (row.b == kFixedBody) return;
    ContactBody& b = bodies[static_cast<std::size_t>(row.b)];
    b.velocity_body += change * row.response_b;
    b.impulse_body += change * row.direction_b;
  };
  const auto impulse_to_target = [&](const Row& row) {
    double speed = row.direction_a.dot(bodies[static_cast<std::size_t>(row.a)].velocity_body);
    if (row.b != kFixedBody) speed += row.direction_b.dot(bodies[static_cast<std::size_t>(row.b)].velocity_body);
    return row.impulse + (row.target - speed) / row.inverse_effective_mass;
  };
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      Row& normal = rows_[3 * k];
      apply(normal, std::max(0.0, impulse_to_target(normal)));
      // Coulomb's cone is round: both tangents are solved first, then scaled to its radius together.
      const double limit = contacts[k].friction * normal.impulse;
      Row &first = rows_[3 * k + 1], &second = rows_[3 * k + 2];
      apply(first, impulse_to_target(first));
      apply(second, impulse_to_target(second));
      const double size = std::hypot(first.impulse, second.impulse);
      if (size <= limit) continue;
      apply(first, first.impulse * limit / size);
      apply(second, second.impulse * limit / size);
    }
  }
}

/// The push removes a fraction of the present overlap and all of what this step would add to it: impulses act
/// throughout the step, so a body that is stopped still moves at the mean of its old and its new speed.
double ContactSolver::target_push_m_s(std::span<const ContactBody> bodies, const Contact& contact, const Row& normal,
                                      double step_s) {
  const auto mean_speed = [](const ContactBody& body, const Vector6d& direction) {
    return 0.5 * direction.dot(body.start_velocity_body + body.velocity_body);
  };
  double speed_m_s = mean_speed(bodies[static_cast<std::size_t>(normal.a)], normal.direction_a);
  if (normal.b != kFixedBody) speed_m_s += mean_speed(bodies[static_cast<std::size_t>(normal.b)], normal.direction_b);
  const double added_m = -std::max(0.0, contact.gap_m) - speed_m_s * step_s;
  const double present_m = std::max(0.0, -contact.gap_m - kSlop_m);
  return std::max(0.0, added_m) / step_s + std::min(kOverlapShare * present_m / step_s, kPushMax_m_s);
}

void ContactSolver::solve_overlaps(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s) {
  bool any = false;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    Row& row = rows_[3 * k];
    row.target = target_push_m_s(bodies, contacts[k], row, step_s);
    any = any || row.target > 0;
  }
  if (!any) return;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      Row& row = rows_[3 * k];
      if (row.target <= 0) continue;
      double speed = row.direction_a.dot(bodies[static_cast<std::size_t>(row.a)].push_body);
      if (row.b != kFixedBody) speed += row.direction_b.dot(bodies[static_cast<std::size_t>(row.b)].push_body);
      const double push = std::max(0.0, row.push + (row.target - speed) / row.inverse_effective_mass);
      bodies[static_cast<std::size_t>(row.a)].push_body += (push - row.push) * row.response_a;
      if (row.b != kFixedBody) bodies[static_cast<std::size_t>(row.b)].push_body += (push - row.push) * row.response_b;
      row.push = push;
    }
  }
}

}  // namespace uwsim
