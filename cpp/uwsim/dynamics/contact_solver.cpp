#include "uwsim/dynamics/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

constexpr int kSweeps = 20;
constexpr double kSettled = 1e-15;  // stop when a sweep changes impulses by less than this fraction

/// Computed as two parallel sums, which is faster.
inline Eigen::Array4d product(const Eigen::Matrix<double, 4, 6>& matrix, const Vector6d& v) {
  const auto column = [&](Eigen::Index k) { return matrix.col(k).array(); };
  const Eigen::Array4d even = column(0) * v(0) + column(2) * v(2) + column(4) * v(4);
  const Eigen::Array4d odd = column(1) * v(1) + column(3) * v(3) + column(5) * v(5);
  return even + odd;
}

}  // namespace

/// Row k of `along` is the six-vector J such that J nu is `sign` times the velocity of the contact point along
/// direction k.
void ContactSolver::make_end(std::span<const ContactBody> bodies, int body, const Contact& contact, double sign,
                             End& end) {
  end.body = body;
  if (body == kFixedBody) return;
  const ContactBody& touched = bodies[static_cast<std::size_t>(body)];
  const Eigen::Matrix3d body_from_world = touched.world_from_body.rotation().transpose();
  const Eigen::Vector3d arm = body_from_world * (contact.point_world_m - touched.world_from_body.position_m);
  const Eigen::Matrix3d directions = contact.directions_world();
  end.along.row(3).setZero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Vector3d direction = sign * (body_from_world * directions.col(k));
    Vector6d j;
    j << direction, arm.cross(direction);
    end.along.row(k) = j;
    end.response.col(k).noalias() = touched.inverse_mass * j;
  }
}

void ContactSolver::make_rows(std::span<const ContactBody> bodies, const Contact& contact, Rows& rows) {
  make_end(bodies, contact.a, contact, 1, rows.a);
  make_end(bodies, contact.b, contact, -1, rows.b);
  rows.response.noalias() = rows.a.along.topRows<3>() * rows.a.response;
  if (contact.b != kFixedBody) rows.response.noalias() += rows.b.along.topRows<3>() * rows.b.response;
  const Eigen::Matrix3d& r = rows.response;
  const Eigen::Array3d mass = r.diagonal().array().inverse();
  const double second = -mass[1] * r(1, 0) * mass[0];
  rows.to_impulse << mass[0], 0, 0,  //
      second, mass[1], 0,            //
      -mass[2] * (r(2, 0) * mass[0] + r(2, 1) * second), -mass[2] * r(2, 1) * mass[1], mass[2];
  for (End* end : {&rows.a, &rows.b}) {
    if (end->body == kFixedBody) continue;
    end->to_impulse.topRows<3>().noalias() = rows.to_impulse * end->along.topRows<3>();
    end->to_impulse.row(3).setZero();
  }
  rows.friction = contact.friction;
}

/// The velocities along the normal and the tangents, of a relative to b.
ContactSolver::Four ContactSolver::velocity(std::span<const ContactBody> bodies, const Rows& rows,
                                            Vector6d ContactBody::*of) {
  Four sum = product(rows.a.along, bodies[static_cast<std::size_t>(rows.a.body)].*of);
  if (rows.b.body != kFixedBody) sum += product(rows.b.along, bodies[static_cast<std::size_t>(rows.b.body)].*of);
  return sum;
}

void ContactSolver::reserve(std::size_t bodies, std::size_t contacts) {
  islands_.reserve(bodies);
  island_.reserve(contacts);
  rows_.reserve(contacts);
  impulses_.reserve(contacts);
  newton_.reserve(bodies, contacts);
}

void ContactSolver::solve(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s) {
  impulses_.assign(contacts.size(), Eigen::Vector3d::Zero());
  islands_.separate(bodies.size());
  for (const Contact& contact : contacts) {
    if (contact.b != kFixedBody)
      islands_.join(static_cast<std::size_t>(contact.a), static_cast<std::size_t>(contact.b));
  }
  const auto island_of = [&](const Contact& contact) { return islands_.of(static_cast<std::size_t>(contact.a)); };
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    if (islands_.of(body) != body) continue;
    island_.clear();
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (island_of(contacts[k]) == body) island_.push_back(static_cast<std::uint32_t>(k));
    }
    if (!island_.empty()) solve_island(bodies, contacts, step_s);
  }
}

Eigen::Vector3d ContactSolver::impulse_world(const Contact& contact, std::size_t index) const {
  return contact.directions_world() * impulses_[index];
}

void ContactSolver::solve_island(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s) {
  if (newton_.solve(bodies, contacts, island_, step_s, impulses_)) return;
  rows_.clear();
  for (const std::uint32_t k : island_) {
    Rows& rows = rows_.emplace_back();
    rows.contact = k;
    make_rows(bodies, contacts[k], rows);
    rows.target = contacts[k].least_speed_m_s(velocity(bodies, rows, &ContactBody::start_velocity_body)[0],
                                              velocity(bodies, rows, &ContactBody::velocity_body)[0], step_s);
  }
  solve_velocities(bodies);
  for (const Rows& rows : rows_) impulses_[rows.contact] = rows.impulse;
  solve_overlaps(bodies, contacts, step_s);
}

/// The impulse after one Gauss-Seidel step, limited: the normal impulse never pulls, and the tangential impulses stay
/// within Coulomb's cone.
Eigen::Array3d ContactSolver::limited_impulse(std::span<const ContactBody> bodies, const Rows& rows) {
  const Four speed = velocity(bodies, rows, &ContactBody::velocity_body);
  const Eigen::Array3d& before = rows.impulse;
  Eigen::Array3d after;
  after[0] = std::max(0.0, before[0] + (rows.target - speed[0]) * rows.to_impulse(0, 0));
  const double limit = rows.friction * after[0];
  if (limit == 0) return {after[0], 0, 0};
  const double normal = after[0] - before[0];
  after[1] = before[1] - (speed[1] + rows.response(1, 0) * normal) * rows.to_impulse(1, 1);
  const double across = rows.response(2, 0) * normal + rows.response(2, 1) * (after[1] - before[1]);
  after[2] = before[2] - (speed[2] + across) * rows.to_impulse(2, 2);
  // Coulomb's cone is circular: both tangential impulses are solved first, then scaled to its radius together.
  const double size = after[1] * after[1] + after[2] * after[2];
  if (size > limit * limit) after.tail<2>() *= limit / std::sqrt(size);
  return after;
}

/// Performs one Gauss-Seidel step on the three impulses of a contact in turn. Returns whether it changed the velocities
/// by more than rounding.
bool ContactSolver::solve_contact(std::span<ContactBody> bodies, Rows& rows) {
  Vector6d& velocity_a = bodies[static_cast<std::size_t>(rows.a.body)].velocity_body;
  Four step = product(rows.a.to_impulse, velocity_a);
  if (rows.b.body != kFixedBody)
    step += product(rows.b.to_impulse, bodies[static_cast<std::size_t>(rows.b.body)].velocity_body);
  Eigen::Array3d change = rows.target * rows.to_impulse.col(0).array() - step.head<3>();
  const Eigen::Array3d after = rows.impulse + change;
  const double limit = rows.friction * after[0];
  const bool is_free = after[0] > 0 && after[1] * after[1] + after[2] * after[2] <= limit * limit;
  if (is_free) {
    rows.impulse = after;
  } else if (after[0] <= 0 && (rows.impulse == 0).all()) {
    return false;
  } else {
    const Eigen::Array3d limited = limited_impulse(bodies, rows);
    change = limited - rows.impulse;
    rows.impulse = limited;
    if ((change == 0).all()) return false;
  }
  velocity_a +=
      change[0] * rows.a.response.col(0) + change[1] * rows.a.response.col(1) + change[2] * rows.a.response.col(2);
  if (rows.b.body != kFixedBody)
    bodies[static_cast<std::size_t>(rows.b.body)].velocity_body += rows.b.response * change.matrix();
  return (change.abs() > kSettled * rows.impulse.matrix().lpNorm<Eigen::Infinity>()).any();
}

void ContactSolver::solve_velocities(std::span<ContactBody> bodies) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool changes = false;
    for (Rows& rows : rows_) changes |= solve_contact(bodies, rows);
    if (!changes) break;
  }
  for (const Rows& rows : rows_) {
    for (const End* end : {&rows.a, &rows.b}) {
      if (end->body == kFixedBody) continue;
      bodies[static_cast<std::size_t>(end->body)].impulse_body +=
          end->along.topRows<3>().transpose() * rows.impulse.matrix();
    }
  }
}

void ContactSolver::solve_overlaps(std::span<ContactBody> bodies, std::span<const Contact> contacts, double step_s) {
  bool any = false;
  for (Rows& rows : rows_) {
    rows.target = contacts[rows.contact].push_m_s(velocity(bodies, rows, &ContactBody::start_velocity_body)[0],
                                                  velocity(bodies, rows, &ContactBody::velocity_body)[0], step_s);
    any = any || rows.target > 0;
  }
  if (!any) return;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool changes = false;
    for (Rows& rows : rows_) {
      if (rows.target <= 0) continue;
      const double speed = velocity(bodies, rows, &ContactBody::push_body)[0];
      const double push = std::max(0.0, rows.push + (rows.target - speed) * rows.to_impulse(0, 0));
      const double change = push - rows.push;
      if (change == 0) continue;
      changes = true;
      rows.push = push;
      for (const End* end : {&rows.a, &rows.b}) {
        if (end->body == kFixedBody) continue;
        bodies[static_cast<std::size_t>(end->body)].push_body += change * end->response.col(0);
      }
    }
    if (!changes) break;
  }
}

}  // namespace uwsim
