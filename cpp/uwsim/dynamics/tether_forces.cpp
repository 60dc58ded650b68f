#include <algorithm>
#include <cmath>

#include "uwsim/dynamics/tether.h"

// The part of Tether that finds the forces, as the gradient of a convex function, and their derivatives.
namespace uwsim {
namespace {

constexpr double kShortest = 1e-12;  // m and m/s, below which a direction is arbitrary

Eigen::Matrix3d outer(const Eigen::Vector3d& v) { return v * v.transpose(); }

}  // namespace

/// An element's tension grows linearly with its stretch, and damping cannot push. The drum keeps the tension of the
/// first element while that lasts: it is the middle one of its own and those at its lengths.
///
/// Which of these holds is judged by the tension of the last iteration and, as if the element were no stiffer than its
/// nodes' inertia, by how far its length is from the one at that tension (a primal-dual active set: Hintermueller, Ito
/// and Kunisch 2002, SIAM J. Optim. 13:865). By its length alone, a stiff element would be now slack, now overloaded.
Tether::Pull Tether::pull(std::size_t element, double distance_m, double step_s) const {
  if (element == broken_) return {0, 0};
  const Frozen& f = frozen_[element];
  const double inertia = std::min(f.stiffness, f.tangential_mass / (step_s * step_s));
  const double loaded_m = (f.tension_n + f.damping * f.stretch_m) / f.stiffness;
  const auto judged = [&](double rest) { return f.tension_n + inertia * (distance_m - rest - loaded_m); };
  if (element > 0 || drum_.low_m == drum_.high_m) {
    const double rest = element == 0 ? drum_.low_m : rest_m(element);
    return judged(rest) > 0 ? taut(f, distance_m - rest) : Pull{0, 0};
  }
  if (judged(drum_.high_m) > drum_.tension_n) return taut(f, distance_m - drum_.high_m);
  if (judged(drum_.low_m) > drum_.tension_n) return {drum_.tension_n, 0};
  return judged(drum_.low_m) > 0 ? taut(f, distance_m - drum_.low_m) : Pull{0, 0};
}

Tether::Pull Tether::taut(const Frozen& f, double stretch_m) {
  return {f.stiffness * stretch_m - f.damping * f.stretch_m, f.stiffness};
}

/// Gives elements and contacts the forces that they have at next_.
void Tether::be_consistent() {
  for (std::size_t i = 0; i < elements(); ++i) {
    Frozen& f = frozen_[i];
    const double distance_m = (next_[i + 1] - next_[i]).norm();
    double tension_n = taut(f, distance_m - (i == 0 ? drum_.low_m : rest_m(i))).tension;
    if (i == 0 && drum_.low_m != drum_.high_m)
      tension_n = std::max(std::min(tension_n, drum_.tension_n), taut(f, distance_m - drum_.high_m).tension);
    f.tension_n = i == broken_ ? 0 : std::max(0.0, tension_n);
  }
  for (TetherContact& c : contacts_) {
    const Eigen::Vector3d at = place(next_, c), slip = at - c.held_m;
    c.force_n = std::max(0.0, c.stiffness * (c.level_m - c.normal_world.dot(at)));
    c.grip_n = c.friction_stiffness * (slip - c.normal_world.dot(slip) * c.normal_world);
    const double size = c.grip_n.norm();
    if (size > c.friction_n) c.grip_n *= c.friction_n / size;
  }
}

/// The gradient and the Hessian at next_, or only the gradient, and whether the Hessian still has the parts that it
/// should.
void Tether::assemble(double step_s, bool with_hessian) {
  is_same_ = true;
  for (std::size_t i = 0; i < nodes_.size(); ++i) add_node(i, step_s, with_hessian);
  for (std::size_t i = 0; i < elements(); ++i) add_element(i, step_s, with_hessian);
  if (spec_.bending_stiffness_n_m2 > 0) {
    const Bending usual = bending(2);
    for (std::size_t i = 1; i < elements(); ++i) add_bending(i, i == 1 ? bending(1) : usual, with_hessian);
  }
  add_contacts(with_hessian);
  add_ends(step_s, with_hessian);
}

void Tether::add_node(std::size_t i, double step_s, bool with_hessian) {
  Frozen& f = frozen_[i];
  const Eigen::Vector3d velocity = (next_[i] - nodes_[i].position) / step_s - f.flow;
  const double forward = f.tangent.dot(velocity);
  const Eigen::Vector3d across = velocity - forward * f.tangent;
  const double speed = across.norm();
  gradient_[i].noalias() = f.inertia * (next_[i] - f.target);
  gradient_[i] +=
      f.normal_drag * speed * across + f.tangential_drag * std::abs(forward) * forward * f.tangent - f.force;
  Eigen::Matrix3d& h = hessian_.diagonal[i];
  if (with_hessian) {
    const double drag = f.normal_drag * speed / step_s;
    h = f.inertia + (2 * f.tangential_drag * std::abs(forward) / step_s - drag) * outer(f.tangent);
    h.diagonal().array() += drag;
    if (speed > kShortest) h += drag / (speed * speed) * outer(across);
    hessian_.next[i].setZero();
    hessian_.second[i] = 0;
  }
  if (f.bed_stiffness == 0) return;
  const double depth = f.bed_level_m - f.bed_normal.dot(next_[i]);
  is_same_ = is_same_ && f.is_on_bed == (depth > 0);
  f.is_on_bed = depth > 0;
  if (depth > 0) {
    gradient_[i] -= f.bed_stiffness * depth * f.bed_normal;
    if (with_hessian) h += f.bed_stiffness * outer(f.bed_normal);
  }
  if (f.friction_n == 0) return;
  Eigen::Vector3d slip = next_[i] - nodes_[i].grip;
  slip -= f.bed_normal.dot(slip) * f.bed_normal;
  const double distance = slip.norm(), most = f.friction_n / f.bed_stiffness;
  const double stiffness = f.bed_stiffness * (distance > most ? most / distance : 1);
  gradient_[i] += stiffness * slip;
  is_same_ = is_same_ && f.slides == (distance > most);
  f.slides = distance > most;
  if (!with_hessian) return;
  h += stiffness * (Eigen::Matrix3d::Identity() - outer(f.bed_normal));
  if (distance > most) h -= stiffness / (distance * distance) * outer(slip);
}

void Tether::add_element(std::size_t i, double step_s, bool with_hessian) {
  const Eigen::Vector3d between = next_[i + 1] - next_[i];
  const double distance = between.norm();
  Frozen& f = frozen_[i];
  const Pull last = f.pull;
  f.pull = distance < kShortest ? Pull{0, 0} : pull(i, distance, step_s);
  f.unit = distance < kShortest ? Eigen::Vector3d::Zero() : Eigen::Vector3d(between / distance);
  is_same_ = is_same_ && last.stiffness == f.pull.stiffness && (last.tension == 0) == (f.pull.tension == 0);
  if (f.pull.tension == 0 && f.pull.stiffness == 0) return;
  gradient_[i] -= f.pull.tension * f.unit;
  gradient_[i + 1] += f.pull.tension * f.unit;
  if (!with_hessian) return;
  const double across = (f.pull.stiffness > 0 ? f.tension_n : f.pull.tension) / distance;
  Eigen::Matrix3d h = (f.pull.stiffness - across) * outer(f.unit);
  h.diagonal().array() += across;
  hessian_.diagonal[i] += h;
  hessian_.diagonal[i + 1] += h;
  hessian_.next[i] -= h;
}

/// The energy EI / 2 times the squared second difference of position along the tether, which is its curvature where it
/// is not stretched much.
Tether::Bending Tether::bending(std::size_t i) const {
  const double before = i == 1 ? rest_m(0) : spec_.element_m(), after = spec_.element_m();
  const double root = std::sqrt(2 * spec_.bending_stiffness_n_m2 / (before + after));
  return {root / before, -(root / before + root / after), root / after};
}

void Tether::add_bending(std::size_t i, const Bending& bending, bool with_hessian) {
  if (i - 1 == broken_ || i == broken_) return;
  const auto [before, here, after] = bending;
  const Eigen::Vector3d turn = before * next_[i - 1] + here * next_[i] + after * next_[i + 1];
  gradient_[i - 1] += before * turn;
  gradient_[i] += here * turn;
  gradient_[i + 1] += after * turn;
  if (!with_hessian) return;
  hessian_.diagonal[i - 1].diagonal().array() += before * before;
  hessian_.diagonal[i].diagonal().array() += here * here;
  hessian_.diagonal[i + 1].diagonal().array() += after * after;
  hessian_.next[i - 1].diagonal().array() += before * here;
  hessian_.next[i].diagonal().array() += here * after;
  hessian_.second[i - 1] += before * after;
}

/// A body's mass, or for a fixed end a row that keeps its node.
void Tether::add_ends(double step_s, bool with_hessian) {
  const double per_s2 = 1 / (step_s * step_s);
  const std::size_t last = elements();
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t row = k == 0 ? 0 : last, off = k == 0 ? 0 : last - 1;
    if (!ends_[k].is_fixed) {
      gradient_[row] += per_s2 * ends_[k].mass * (next_[row] - ends_[k].next);
      if (with_hessian) hessian_.diagonal[row] += per_s2 * ends_[k].mass;
      continue;
    }
    end_gradient_[k] = gradient_[row];
    gradient_[row].setZero();
    if (!with_hessian) continue;
    end_next_[k] = hessian_.next[off];
    hessian_.diagonal[row].setIdentity();
    hessian_.next[off].setZero();
    if (last < 2) continue;
    double& second = hessian_.second[k == 0 ? 0 : last - 2];
    end_second_[k] = second;
    second = 0;
  }
}

}  // namespace uwsim
