#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/dynamics/point_jacobian.h"
#include "uwsim/dynamics/tether.h"

// The part of Tether that finds the nodes' next positions.
namespace uwsim {
namespace {

constexpr int kIterations = 40;
constexpr int kFull = 12;  // iterations after which changes are halved, in case that they alternate
// If an iteration changes positions by more than kLost_m, or they are not found, the tether is made as soft as its
// nodes' inertia in a step, or softer, and then stiffer by stages.
constexpr double kLost_m = 1e6, kSofter = 100, kStiffer = 5;
constexpr int kStages = 30;
constexpr double kSolved_m = 1e-7;   // the change of an iteration after which positions are found
constexpr double kUnseen_m_s = 0.5;  // contacts are searched as far as forces may move a node in a step
constexpr double kLeast = 1e-12;     // m and m/s, below which a direction is arbitrary

Eigen::Matrix3d outer(const Eigen::Vector3d& v) { return v * v.transpose(); }

/// Returns the parts of `v` along and across a unit vector, times factors.
Eigen::Vector3d scaled(const Eigen::Vector3d& v, const Eigen::Vector3d& unit, double along, double across) {
  return across * v + (along - across) * unit.dot(v) * unit;
}

}  // namespace

void Tether::step(std::span<MovedBody> bodies, const WaterField& water, double time_s, double step_s) {
  ends_ = {end_of(spec_.first, bodies, water, time_s, step_s), end_of(spec_.second, bodies, water, time_s, step_s)};
  drum_ = drum(step_s);
  freeze(water, time_s, step_s);
  freeze_contacts(bodies, step_s, kUnseen_m_s * step_s, step_s);
  yield_hulls(bodies, water, time_s, step_s);
  find_next(step_s);
  push_hulls(bodies);
  for (std::size_t k = 0; k < 2; ++k) {
    const TetherEnd& at = k == 0 ? spec_.first : spec_.second;
    if (at.body == TetherEnd::kNoBody || ends_[k].is_fixed) continue;
    MovedBody& body = bodies[at.body];
    body.tether_world.head<3>() += end_forces_[k];
    body.tether_world.tail<3>() += body.state.world_from_body.direction(at.point_m).cross(end_forces_[k]);
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (next_[i].cwiseAbs().maxCoeff() < kDiverged) continue;  // false for NaN
    require(false, spec_.name, next_[i].transpose(), "the motion of its node " + std::to_string(i) + " diverged");
  }
}

Tether::End Tether::end_of(const TetherEnd& end, std::span<MovedBody> bodies, const WaterField& water, double time_s,
                           double step_s) const {
  End now;
  now.next = end_point(end, bodies);
  if (end.body == TetherEnd::kNoBody || bodies[end.body].held) return now;
  MovedBody& body = bodies[end.body];
  if (body.arm) body.arm->begin();
  const Pose& pose = body.state.world_from_body;
  const BodyState free = body.advanced(body.state, body.loads(Vector6d::Zero(), step_s), water, time_s, step_s);
  const Eigen::Matrix<double, 3, 6> j = point_jacobian(pose, end.point_m);
  now.is_fixed = false;
  now.next = free.world_from_body.point(end.point_m);
  now.mass = (j * body.inverse_mass(pose, water, time_s) * j.transpose()).inverse();
  return now;
}

void Tether::freeze(const WaterField& water, double time_s, double step_s) {
  const std::size_t last = elements();
  double passed = 0;
  for (std::size_t i = 0; i <= last; ++i) {
    points_[i] = nodes_[i].position;
    from_m_[i] = passed;
    if (i < last) passed += rest_m(i);
  }
  flow_.find({points_.data(), nodes_.size()}, {from_m_.data(), nodes_.size()}, water, time_s + step_s);
  for (std::size_t i = 0; i <= last; ++i) {
    Frozen& f = frozen_[i];
    const Node& node = nodes_[i];
    f.target = node.position + step_s * node.velocity;
    const std::size_t before = i == 0 || broken_ == i - 1 ? i : i - 1, after = i == last || broken_ == i ? i : i + 1;
    const Eigen::Vector3d along = nodes_[after].position - nodes_[before].position;
    const double length = along.norm();
    f.tangent = length > kLeast ? Eigen::Vector3d(along / length) : Eigen::Vector3d::UnitX();
    freeze_water(i, water, time_s + step_s);
    freeze_bed(i);
    f.stretch_m = i == last ? 0 : std::max(0.0, (nodes_[i + 1].position - node.position).norm() - rest_m(i));
  }
}

/// Mass, weight and the water's forces. A node is wet in proportion to what of its height lies below the surface.
void Tether::freeze_water(std::size_t i, const WaterField& water, double time_s) {
  Frozen& f = frozen_[i];
  const Eigen::Vector3d& at = nodes_[i].position;
  const double length = span_m(i), mass = mass_kg(i);
  double wet = at.z() < 0 ? 1 : 0;
  if (std::abs(at.z()) < length + spec_.diameter_m + water.wave_bound_m()) {
    const double height = spec_.diameter_m + std::abs(f.tangent.z()) * length;
    wet = std::clamp(0.5 + (water.surface_height_at(at.x(), at.y(), time_s) - at.z()) / height, 0.0, 1.0);
  }
  f.force = {0, 0, -mass * water.gravity()};
  f.flow.setZero();
  f.normal_mass = f.tangential_mass = mass;
  f.normal_drag = f.tangential_drag = 0;
  if (wet == 0) return;
  const double density = wet * water.density_at(at.z());
  const double displaced = density * std::numbers::pi / 4 * spec_.diameter_m * spec_.diameter_m * length;
  const WaterFlow& flow = flow_.at(i);
  const Eigen::Vector3d rate = flow.wave_acceleration_m_s2 + flow.current_acceleration_m_s2;
  f.flow = flow.velocity_m_s;
  f.force.z() += displaced * water.gravity();
  f.force += displaced * scaled(rate, f.tangent, 1 + spec_.tangential_added_mass, 1 + spec_.normal_added_mass);
  f.normal_mass += displaced * spec_.normal_added_mass;
  f.tangential_mass += displaced * spec_.tangential_added_mass;
  const double area = 0.5 * density * spec_.diameter_m * length;
  f.normal_drag = area * spec_.normal_drag;
  f.tangential_drag = area * std::numbers::pi * spec_.tangential_drag;
}

Tether::Drum Tether::drum(double step_s) const {
  Drum still{first_m_, first_m_, spec_.strongest_n};
  if (winch_.mode == WinchCommand::Mode::kHold || broken_ == 0) return still;
  const double most = first_m_ + std::max(0.0, spec_.most_m() - length_m());
  const double least = first_m_ - std::max(0.0, length_m() - spec_.least_m());
  const bool by_rate = winch_.mode == WinchCommand::Mode::kRate;
  const double rate = by_rate ? winch_.value : spec_.fastest_m_s;
  const double out = std::min(most, first_m_ + std::abs(rate) * step_s);
  const double in = std::max(least, first_m_ - std::abs(rate) * step_s);
  if (!by_rate) return {in, out, winch_.value};
  return winch_.value >= 0 ? Drum{out, out, spec_.strongest_n} : Drum{in, first_m_, spec_.strongest_n};
}

/// An element's tension grows linearly with its stretch, and damping cannot push. The drum keeps the tension of the
/// first element while that lasts: it is the middle one of its own and those at its lengths.
///
/// Which of these holds is judged by the tension of the last iteration and, as if the element were no stiffer than its
/// nodes' inertia, by how far its length is from the one at that tension (a primal-dual active set: Hintermueller, Ito
/// and Kunisch 2002, SIAM J. Optim. 13:865). By its length alone, a stiff element would be now slack, now overloaded.
Tether::Pull Tether::pull(std::size_t element, double distance_m, double step_s) const {
  if (element == broken_) return {0, 0};
  const Frozen& f = frozen_[element];
  const double damping = spec_.axial_damping_n_s / (rest_m(element) * step_s);
  const double stiffness = spec_.axial_stiffness_n / rest_m(element) + damping;
  const double inertia = std::min(stiffness, f.tangential_mass / (step_s * step_s));
  const double loaded_m = (f.tension_n + damping * f.stretch_m) / stiffness;
  const auto judged = [&](double rest) { return f.tension_n + inertia * (distance_m - rest - loaded_m); };
  const auto taut = [&](double rest) {
    return Pull{stiffness * (distance_m - rest) - damping * f.stretch_m, stiffness};
  };
  if (element > 0 || drum_.low_m == drum_.high_m) {
    const double rest = element == 0 ? drum_.low_m : rest_m(element);
    return judged(rest) > 0 ? taut(rest) : Pull{0, 0};
  }
  if (judged(drum_.high_m) > drum_.tension_n) return taut(drum_.high_m);
  if (judged(drum_.low_m) > drum_.tension_n) return {drum_.tension_n, 0};
  return judged(drum_.low_m) > 0 ? taut(drum_.low_m) : Pull{0, 0};
}

/// Newton's method for positions and tensions. Tensions are unknowns of their own, which each iteration eliminates, so
/// that its convergence does not depend on the stiffness once it is near. If it does not converge from the start, a
/// softer tether's positions are found first, whose stiffness then grows; the stiffest that has been found is taken.
/// Returns whether it has converged at the full stiffness.
bool Tether::find_next(double step_s) {
  const std::size_t rows = nodes_.size();
  const auto solve = [&](int iterations) {
    for (int iteration = 0; iteration < iterations; ++iteration) {
      const double share = iteration < kFull ? 1 : 0.5;
      assemble(step_s);
      for (std::size_t i = 0; i < rows; ++i) change_[i] = -gradient_[i];
      hessian_.solve(rows, change_);
      double largest = 0;
      for (std::size_t i = 0; i < rows; ++i) largest = std::max(largest, change_[i].cwiseAbs().maxCoeff());
      for (std::size_t i = 0; i < rows; ++i) next_[i] += share * change_[i];
      for (std::size_t i = 0; i + 1 < rows; ++i) {
        Frozen& f = frozen_[i];
        f.tension_n = std::max(0.0, f.pull.tension + f.pull.stiffness * f.unit.dot(change_[i + 1] - change_[i]));
      }
      press_contacts();
      if (largest <= kSolved_m) return true;
      if (!(largest < kLost_m)) return false;
    }
    return false;
  };
  const auto begin = [&] {
    for (std::size_t i = 0; i < rows; ++i) {
      next_[i] = frozen_[i].target;
      frozen_[i].tension_n = nodes_[i].tension_n;
    }
    next_.front() = ends_[0].next;
    next_.back() = ends_[1].next;
  };
  begin();
  bool is_solved = solve(kIterations);
  if (!is_solved) {
    const double stiffness = spec_.axial_stiffness_n, damping = spec_.axial_damping_n_s;
    const double inertia = mass_kg(rows / 2) / (step_s * step_s) * spec_.element_m();
    std::vector<Eigen::Vector3d> found;
    std::vector<double> tensions(rows);
    double share = std::min(1.0, inertia / (stiffness + damping / step_s));
    found.reserve(rows);
    for (int stage = 0; stage < kStages; ++stage) {
      if (found.empty()) {
        begin();
        for (std::size_t i = 0; i < rows; ++i) frozen_[i].tension_n *= share;
      }
      spec_.axial_stiffness_n = share * stiffness;
      spec_.axial_damping_n_s = share * damping;
      if (solve(kIterations)) {
        found.assign(next_.begin(), next_.begin() + static_cast<std::ptrdiff_t>(rows));
        for (std::size_t i = 0; i < rows; ++i) tensions[i] = frozen_[i].tension_n;
        is_solved = share == 1;
        if (is_solved) break;
        share = std::min(1.0, kStiffer * share);
      } else if (found.empty()) {
        share /= kSofter;
      } else {
        break;
      }
    }
    const bool flies = found.empty();
    if (flies) {
      begin();
      found.assign(next_.begin(), next_.begin() + static_cast<std::ptrdiff_t>(rows));
      std::ranges::fill(tensions, 0);
    }
    std::ranges::copy(found, next_.begin());
    for (std::size_t i = 0; i < rows; ++i) {
      frozen_[i].tension_n = tensions[i];
      change_[i].setZero();
    }
    if (flies) contacts_.clear();
    for (TetherContact& contact : contacts_) {  // their forces at these positions
      const Eigen::Vector3d slip = between(next_, contact) - contact.held_m;
      contact.is_pressed = true;
      contact.slide_n = contact.friction_stiffness * (slip - contact.normal_world.dot(slip) * contact.normal_world);
      contact.slide_stiffness.setZero();
    }
    press_contacts();
    spec_.axial_stiffness_n = stiffness;
    spec_.axial_damping_n_s = damping;
  }
  const double per_s2 = 1 / (step_s * step_s);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t row = k == 0 ? 0 : rows - 1, one = k == 0 ? 1 : rows - 2, two = k == 0 ? 2 : rows - 3;
    if (!ends_[k].is_fixed) {
      end_forces_[k] = per_s2 * ends_[k].mass * (next_[row] - ends_[k].next);
      continue;
    }
    end_forces_[k] =
        -end_gradient_[k] - (k == 0 ? end_next_[k] : Eigen::Matrix3d(end_next_[k].transpose())) * change_[one];
    if (rows > 2) end_forces_[k] -= end_second_[k] * change_[two];
  }
  return is_solved;
}

/// The gradient and the Hessian at next_.
void Tether::assemble(double step_s) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) add_node(i, step_s);
  for (std::size_t i = 0; i < elements(); ++i) add_element(i, step_s);
  if (spec_.bending_stiffness_n_m2 > 0) {
    for (std::size_t i = 1; i < elements(); ++i) add_bending(i);
  }
  add_contacts();
  add_ends(step_s);
}

void Tether::add_node(std::size_t i, double step_s) {
  const Frozen& f = frozen_[i];
  const double per_s2 = 1 / (step_s * step_s);
  const Eigen::Vector3d velocity = (next_[i] - nodes_[i].position) / step_s - f.flow;
  const Eigen::Matrix3d along = outer(f.tangent);
  const double forward = f.tangent.dot(velocity);
  const Eigen::Vector3d across = velocity - forward * f.tangent;
  const double speed = across.norm(), drag = f.normal_drag * speed / step_s;
  gradient_[i] = scaled(next_[i] - f.target, f.tangent, per_s2 * f.tangential_mass, per_s2 * f.normal_mass) - f.force +
                 f.normal_drag * speed * across + f.tangential_drag * std::abs(forward) * forward * f.tangent;
  Eigen::Matrix3d& h = hessian_.diagonal[i];
  const double normal = per_s2 * f.normal_mass + drag;
  h = (per_s2 * f.tangential_mass + 2 * f.tangential_drag * std::abs(forward) / step_s - normal) * along;
  h.diagonal().array() += normal;
  if (speed > kLeast) h += drag / (speed * speed) * outer(across);
  hessian_.next[i].setZero();
  hessian_.second[i] = 0;
  if (f.bed_stiffness == 0) return;
  const double depth = f.bed_level_m - f.bed_normal.dot(next_[i]);
  if (depth > 0) {
    gradient_[i] -= f.bed_stiffness * depth * f.bed_normal;
    h += f.bed_stiffness * outer(f.bed_normal);
  }
  if (f.friction_n == 0) return;
  Eigen::Vector3d slip = next_[i] - nodes_[i].grip;
  slip -= f.bed_normal.dot(slip) * f.bed_normal;
  const double distance = slip.norm(), most = f.friction_n / f.bed_stiffness;
  const double stiffness = f.bed_stiffness * (distance > most ? most / distance : 1);
  gradient_[i] += stiffness * slip;
  h += stiffness * (Eigen::Matrix3d::Identity() - outer(f.bed_normal));
  if (distance > most) h -= stiffness / (distance * distance) * outer(slip);
}

void Tether::add_element(std::size_t i, double step_s) {
  const Eigen::Vector3d between = next_[i + 1] - next_[i];
  const double distance = between.norm();
  Frozen& f = frozen_[i];
  f.pull = distance < kLeast ? Pull{0, 0} : pull(i, distance, step_s);
  f.unit = distance < kLeast ? Eigen::Vector3d::Zero() : Eigen::Vector3d(between / distance);
  if (f.pull.tension == 0 && f.pull.stiffness == 0) return;
  const double across = (f.pull.stiffness > 0 ? f.tension_n : f.pull.tension) / distance;
  Eigen::Matrix3d h = (f.pull.stiffness - across) * outer(f.unit);
  h.diagonal().array() += across;
  gradient_[i] -= f.pull.tension * f.unit;
  gradient_[i + 1] += f.pull.tension * f.unit;
  hessian_.diagonal[i] += h;
  hessian_.diagonal[i + 1] += h;
  hessian_.next[i] -= h;
}

/// The energy EI / 2 times the squared second difference of position along the tether, which is its curvature where it
/// is not stretched much.
void Tether::add_bending(std::size_t i) {
  if (i - 1 == broken_ || i == broken_) return;
  const double before = 1 / rest_m(i - 1), after = 1 / rest_m(i), here = -(before + after);
  const double stiffness = 2 * spec_.bending_stiffness_n_m2 / (rest_m(i - 1) + rest_m(i));
  const Eigen::Vector3d turn = stiffness * (before * next_[i - 1] + here * next_[i] + after * next_[i + 1]);
  gradient_[i - 1] += before * turn;
  gradient_[i] += here * turn;
  gradient_[i + 1] += after * turn;
  hessian_.diagonal[i - 1].diagonal().array() += stiffness * before * before;
  hessian_.diagonal[i].diagonal().array() += stiffness * here * here;
  hessian_.diagonal[i + 1].diagonal().array() += stiffness * after * after;
  hessian_.next[i - 1].diagonal().array() += stiffness * before * here;
  hessian_.next[i].diagonal().array() += stiffness * here * after;
  hessian_.second[i - 1] += stiffness * before * after;
}

/// A body's mass, or for a fixed end a row that keeps its node.
void Tether::add_ends(double step_s) {
  const double per_s2 = 1 / (step_s * step_s);
  const std::size_t last = elements();
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t row = k == 0 ? 0 : last, off = k == 0 ? 0 : last - 1;
    if (!ends_[k].is_fixed) {
      gradient_[row] += per_s2 * ends_[k].mass * (next_[row] - ends_[k].next);
      hessian_.diagonal[row] += per_s2 * ends_[k].mass;
      continue;
    }
    end_gradient_[k] = gradient_[row];
    end_next_[k] = hessian_.next[off];
    gradient_[row].setZero();
    hessian_.diagonal[row].setIdentity();
    hessian_.next[off].setZero();
    if (last < 2) continue;
    double& second = hessian_.second[k == 0 ? 0 : last - 2];
    end_second_[k] = second;
    second = 0;
  }
}

}  // namespace uwsim
