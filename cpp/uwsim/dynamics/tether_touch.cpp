#include <algorithm>
#include <cmath>

#include "uwsim/dynamics/point_jacobian.h"
#include "uwsim/dynamics/tether.h"

// The part of Tether that touches the bed, solids and hulls.
namespace uwsim {
namespace {

constexpr double kMoves = 1.5;         // the search distance, relative to what a node moves in a step
constexpr double kOverlap = 0.5;       // of a radius, under twice the breaking load
constexpr double kMostStrain = 0.024;  // at which a tether without a breaking load counts as about to break
constexpr double kMost_n = 1e5;        // a greater load than this overlaps by more
constexpr double kCreep_m_s = 1e-4;    // the speed at which friction is complete
constexpr double kParts_m_s = 0.5;     // the greatest speed at which overlaps are removed
constexpr double kLeast_n = 1e-9;

}  // namespace

Eigen::Vector3d Tether::place(const std::vector<Eigen::Vector3d>& nodes, const TetherContact& contact) {
  return (1 - contact.share) * nodes[contact.element] + contact.share * nodes[contact.element + 1];
}

/// Finds the contacts of the step, after freeze(), from the nodes' positions and where they would go.
void Tether::freeze_contacts(std::span<const MovedBody> bodies, double step_s, double least_reach_m, double moving_s) {
  const double radius = spec_.diameter_m / 2;
  for (std::size_t i = 0; i < nodes_.size(); ++i) line_.targets[i] = frozen_[i].target;
  for (std::size_t i = 0; i < elements(); ++i) {
    const double moves =
        std::max((line_.targets[i] - line_.points[i]).norm(), (line_.targets[i + 1] - line_.points[i + 1]).norm());
    line_.reach_m[i] = 2 * radius + kMoves * moves + least_reach_m;
  }
  const TetherLine line{{line_.points.data(), nodes_.size()},
                        {line_.reach_m.data(), elements()},
                        {line_.along_m.data(), nodes_.size()},
                        broken_,
                        moving_s};
  finder_.find(line, bodies, contacts_);
  for (TetherContact& contact : contacts_) freeze_contact(contact, step_s);
  std::erase_if(contacts_, [&](const TetherContact& contact) {  // those that it would not reach
    const Eigen::Vector3d target = place(line_.targets, contact);
    const double spare_m = least_reach_m + 0.5 * (target - place(line_.points, contact)).norm();
    return contact.normal_world.dot(target) > contact.level_m + spare_m;
  });
}

void Tether::freeze_contact(TetherContact& contact, double step_s) {
  const double radius = spec_.diameter_m / 2;
  const double most_n = std::min({spec_.breaking_load_n, kMostStrain * spec_.axial_stiffness_n, kMost_n});
  const Eigen::Vector3d at = place(line_.points, contact), &normal = contact.normal_world;
  const double depth =
      std::min(normal.dot(contact.point_world_m - at) + radius, std::max(kOverlap * radius, kParts_m_s * step_s));
  contact.stiffness = 2 * most_n / (kOverlap * radius);
  contact.level_m = normal.dot(at + contact.moves_m) + depth;
  contact.force_n = contact.stiffness * std::max(0.0, depth);
  contact.friction_n = spec_.friction * contact.force_n;
  contact.friction_stiffness = contact.friction_n / (kCreep_m_s * step_s);
  contact.held_m = at + contact.moves_m;
  contact.grip_n.setZero();
  const double share = contact.share;
  const double mass =
      (1 - share) * frozen_[contact.element].normal_mass + share * frozen_[contact.element + 1].normal_mass;
  contact.inertia = mass / (step_s * step_s);
}

/// A hull gives way in the step like a spring in series, as stiff as its mass is inert. Those of its contacts share
/// that.
void Tether::yield_hulls(std::span<const MovedBody> bodies, const WaterField& water, double time_s, double step_s) {
  Matrix6d inverse_mass;
  std::uint64_t known = TetherEnd::kNoBody;
  for (TetherContact& contact : contacts_) {
    if (contact.body == TetherEnd::kNoBody) continue;
    const MovedBody& body = bodies[contact.body];
    const Pose& pose = body.state.world_from_body;
    if (contact.body != known) inverse_mass = body.spec.craft->inverse_mass(pose, water, time_s);
    known = contact.body;
    const auto shares = static_cast<double>(
        std::ranges::count_if(contacts_, [&](const TetherContact& other) { return other.body == known; }));
    const Eigen::Matrix<double, 3, 6> j =
        point_jacobian(pose, pose.rotation().transpose() * (contact.point_world_m - pose.position_m));
    const Eigen::Matrix3d mobility = shares * step_s * step_s * (j * inverse_mass * j.transpose());
    const auto in_series = [](double stiffness, double yields) { return stiffness / (1 + stiffness * yields); };
    const double rigid = contact.stiffness;
    contact.stiffness = in_series(rigid, contact.normal_world.dot(mobility * contact.normal_world));
    contact.force_n *= contact.stiffness / rigid;  // what it bore at rest
    contact.friction_n *= contact.stiffness / rigid;
    contact.friction_stiffness = in_series(contact.friction_stiffness * contact.stiffness / rigid, mobility.trace());
  }
}

/// A contact presses, and its friction slides, as pull() judges of elements: by the force of the last iteration, and,
/// as if it were no stiffer than the tether's inertia, by how far its place is from the one at that force.
void Tether::add_contacts(bool with_hessian) {
  for (TetherContact& c : contacts_) {
    const Eigen::Vector3d at = place(next_, c);
    const double weights[] = {1 - c.share, c.share}, depth = c.level_m - c.normal_world.dot(at);
    const double inertia = std::min(c.stiffness, c.inertia);
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    const double judged_n = c.force_n + inertia * (depth - c.force_n / c.stiffness);
    is_same_ = is_same_ && c.is_pressed == (judged_n > 0);
    c.is_pressed = judged_n > 0;
    if (c.is_pressed) {
      force += c.stiffness * depth * c.normal_world;
      h += c.stiffness * c.normal_world * c.normal_world.transpose();
    }
    const bool slid = c.slides;
    c.slides = false;
    if (c.friction_n > kLeast_n) {
      Eigen::Vector3d slip = at - c.held_m;
      slip -= c.normal_world.dot(slip) * c.normal_world;
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - c.normal_world * c.normal_world.transpose();
      const double along = std::min(c.friction_stiffness, c.inertia);
      const Eigen::Vector3d trial = c.grip_n + along * (slip - c.grip_n / c.friction_stiffness);
      const double size = trial.norm();
      c.slides = size > c.friction_n;
      if (c.slides) {
        const Eigen::Vector3d way = trial / size;
        c.slide_n = c.friction_n * way;
        c.slide_stiffness = c.friction_n / size * along * (across - way * way.transpose());
      } else {
        c.slide_n = c.friction_stiffness * slip;
        c.slide_stiffness = c.friction_stiffness * across;
      }
      force -= c.slide_n;
      h += c.slide_stiffness;
    }
    is_same_ = is_same_ && c.slides == slid;
    for (const std::size_t k : {0u, 1u}) gradient_[c.element + k] -= weights[k] * force;
    if (!with_hessian) continue;
    for (const std::size_t k : {0u, 1u}) {
      hessian_.diagonal[c.element + k] += weights[k] * weights[k] * h;
    }
    hessian_.next[c.element] += weights[0] * weights[1] * h;
  }
}

/// After an iteration.
void Tether::press_contacts() {
  for (TetherContact& c : contacts_) {
    const double depth = c.level_m - c.normal_world.dot(place(next_, c));
    c.force_n = c.is_pressed ? std::max(0.0, c.stiffness * depth) : 0;
    if (c.friction_n <= kLeast_n) continue;
    c.grip_n = c.slide_n + c.slide_stiffness * place(change_, c);
    const double size = c.grip_n.norm();
    if (size > c.friction_n) c.grip_n *= c.friction_n / size;
  }
}

void Tether::push_hulls(std::span<MovedBody> bodies) {
  for (const TetherContact& c : contacts_) {
    if (c.body == TetherEnd::kNoBody) continue;
    const Eigen::Vector3d force = c.grip_n - c.force_n * c.normal_world;
    MovedBody& body = bodies[c.body];
    body.tether_world.head<3>() += force;
    body.tether_world.tail<3>() += (c.point_world_m - body.state.world_from_body.position_m).cross(force);
  }
}

/// The bed below a node, as a plane.
void Tether::freeze_bed(std::size_t i) {
  Frozen& f = frozen_[i];
  const Eigen::Vector3d& at = nodes_[i].position;
  f.bed_stiffness = f.friction_n = 0;
  if ((i == 0 && ends_[0].is_fixed) || (i == elements() && ends_[1].is_fixed)) return;
  const double spacing = terrain_ ? terrain_->spacing_m() : 0;
  if (!terrain_ || at.z() > terrain_->highest_m() + spacing) return;
  const double height = terrain_->height_at(at.x(), at.y());
  if (!std::isfinite(height) || at.z() > height + spacing) return;
  const double step = 1e-3 * spacing;
  const auto slope = [&](double dx, double dy) {
    const double ahead = terrain_->height_at(at.x() + dx, at.y() + dy);
    const double behind = terrain_->height_at(at.x() - dx, at.y() - dy);
    return std::isfinite(ahead) && std::isfinite(behind) ? (ahead - behind) / (2 * step) : 0;
  };
  f.bed_normal = Eigen::Vector3d(-slope(step, 0), -slope(0, step), 1).normalized();
  f.bed_level_m = f.bed_normal.dot(Eigen::Vector3d(at.x(), at.y(), height)) + spec_.diameter_m / 2;
  f.bed_stiffness = spec_.bed_stiffness_pa_m * spec_.diameter_m * span_m(i);
  f.friction_n = spec_.friction * f.bed_stiffness * std::max(0.0, f.bed_level_m - f.bed_normal.dot(at));
}

std::string Tether::first_crossed() const {
  if (!may_meet_solids(nodes_.front().position, nodes_.back().position)) return "";
  for (std::size_t i = 0; i < elements(); ++i) {
    if (i == broken_) continue;
    std::string name = finder_.crossed(nodes_[i].position, nodes_[i + 1].position);
    if (!name.empty()) return name;
  }
  return "";
}

bool Tether::crosses_cover() const {
  for (std::size_t i = 0; i < elements(); ++i) {
    if (i != broken_ && finder_.crosses_cover(nodes_[i].position, nodes_[i + 1].position)) return true;
  }
  return false;
}

/// False only if it is too short to meet a solid when its ends are here.
bool Tether::may_meet_solids(const Eigen::Vector3d& first, const Eigen::Vector3d& second) const {
  const Eigen::Vector3d middle = 0.5 * (first + second);
  return finder_.may_touch({middle.array() - length_m(), middle.array() + length_m()});
}

}  // namespace uwsim
