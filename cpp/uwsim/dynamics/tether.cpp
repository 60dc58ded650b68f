#include "uwsim/dynamics/tether.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

constexpr double kShort = 0.5, kLong = 1.5;  // lengths of the first element, relative to the others'
constexpr double kMostElements = 1000;
constexpr std::size_t kKeptContacts = 1024;  // with more, a step allocates memory
constexpr double kReach = 1 + 1e-9;          // for rounding
// A tether that is laid settles in steps, each from rest, which grow while they can be solved.
constexpr double kFirstSettling_s = 0.02, kLastSettling_s = 20, kGrows = 1.5, kShrinks = 0.3, kSettled_m = 1e-6;
constexpr int kSettlings = 400;
constexpr double kSettlingReach_m = 0.2;

/// Returns true if its stiffness exceeds its inertia in a long step so much that its equations need solve_stiff().
bool is_stiff(const TetherSpec& spec) {
  constexpr double kLongStep_s = 0.02, kMostRatio = 1e4;
  const double element_m = spec.element_m();
  const double axial = (spec.axial_stiffness_n + spec.axial_damping_n_s / kLongStep_s) / element_m;
  const double bending = 16 * spec.bending_stiffness_n_m2 / (element_m * element_m * element_m);
  return axial + bending > kMostRatio * spec.mass_kg_m * element_m / (kLongStep_s * kLongStep_s);
}

void require_positive(const std::string& name, const char* key, double value) {
  require(std::isfinite(value) && value > 0, name + "." + key, value, "must be positive");
}

void require_not_negative(const std::string& name, const char* key, double value) {
  require(std::isfinite(value) && value >= 0, name + "." + key, value, "must not be negative");
}

/// Half of the angle of an arc whose chord is this fraction of its length.
double half_angle(double chord) {
  double low = 0, high = std::numbers::pi;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (std::sin(middle) > chord * middle ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

void TetherSpec::check() const {
  require_positive(name, "length_m", length_m);
  require(elements >= 1 && static_cast<double>(elements) <= kMostElements, name + ".elements", elements,
          "must be in [1, 1000]");
  require_positive(name, "diameter_m", diameter_m);
  require_positive(name, "mass_kg_m", mass_kg_m);
  require_positive(name, "axial_stiffness_n", axial_stiffness_n);
  require_not_negative(name, "bending_stiffness_n_m2", bending_stiffness_n_m2);
  require_not_negative(name, "axial_damping_n_s", axial_damping_n_s);
  require_not_negative(name, "normal_drag", normal_drag);
  require_not_negative(name, "tangential_drag", tangential_drag);
  require_not_negative(name, "normal_added_mass", normal_added_mass);
  require_not_negative(name, "tangential_added_mass", tangential_added_mass);
  require_not_negative(name, "friction", friction);
  require_not_negative(name, "bed_stiffness_pa_m", bed_stiffness_pa_m);
  require(breaking_load_n > 0, name + ".breaking_load_n", breaking_load_n, "must be positive");
  require_not_negative(name, "fastest_m_s", fastest_m_s);
  require_positive(name, "strongest_n", strongest_n);
  require(most_m() >= length_m, name + ".longest_m", longest_m, "must be at least the length");
  require(least_m() >= element_m() && least_m() <= length_m, name + ".shortest_m", shortest_m,
          "must be at least one element, and at most the length");
  require(most_m() <= kMostElements * element_m(), name + ".longest_m", longest_m, "must be at most 1000 elements");
  require(first.body != second.body || first.body == TetherEnd::kNoBody, name, "one body", "must join two");
}

void Tether::Line::resize(std::size_t most) {
  for (std::vector<Eigen::Vector3d>* vectors : {&points, &targets}) vectors->resize(most);
  for (std::vector<double>* values : {&along_m, &half_heights_m, &reach_m}) values->resize(most);
}

void Tether::Search::resize(std::size_t most) {
  for (std::vector<Eigen::Vector3d>* vectors : {&found, &from, &way}) vectors->resize(most);
}

Tether::Tether(const TetherSpec& spec, const World& world, std::span<const MovedBody> bodies)
    : spec_((spec.check(), spec)),
      terrain_(world.terrain()),
      finder_(world, spec_, bodies),
      is_stiff_(is_stiff(spec_)),
      first_m_(spec.element_m()) {
  const std::size_t most = spec_.tubes() - 1;
  nodes_.reserve(most);
  nodes_.resize(spec_.elements + 1);
  frozen_.resize(most);
  for (std::vector<Eigen::Vector3d>* vectors : {&next_, &gradient_, &change_}) vectors->resize(most);
  line_.resize(most);
  search_.resize(most);
  contacts_.reserve(kKeptContacts);
  hessian_.resize(most);
  flow_.resize(most);
  for (Eigen::Vector3d& force : end_forces_) force.setZero();
  for (const TetherEnd* end : {&spec_.first, &spec_.second}) {
    const Eigen::Vector3d at = end_point(*end, bodies);
    require(at.allFinite(), spec_.name + " end", at.transpose(), "must be finite");
    const double bed = terrain_ ? terrain_->height_at(at.x(), at.y()) : at.z() - 1;
    require(!(at.z() < bed), spec_.name + " end", at.transpose(), "must be above the bed");
    const Solid* const solid = end->body == TetherEnd::kNoBody ? world.solid_around(at) : nullptr;
    require(solid == nullptr, spec_.name + " end", at.transpose(),
            "must be outside '" + (solid == nullptr ? "" : solid->name) + "'");
  }
  require_length(bodies);
}

Eigen::Vector3d Tether::end_point(const TetherEnd& end, std::span<const MovedBody> bodies) const {
  return end.body == TetherEnd::kNoBody ? end.point_m : bodies[end.body].state.world_from_body.point(end.point_m);
}

void Tether::require_reaches(std::span<const MovedBody> bodies, const WaterField& water, double time_s) const {
  if (broken()) return;
  require_length(bodies);
  if (may_meet_solids(end_point(spec_.first, bodies), end_point(spec_.second, bodies)))
    Tether(*this).lay(bodies, water, time_s);
}

void Tether::require_length(std::span<const MovedBody> bodies) const {
  const double distance = (end_point(spec_.first, bodies) - end_point(spec_.second, bodies)).norm();
  require(distance <= length_m() * kReach, spec_.name + " length_m", length_m(),
          "must be at least the distance of its ends, " + printed_number(distance) + " m");
}

double Tether::span_m(std::size_t node) const {
  return 0.5 * ((node == 0 ? 0 : rest_m(node - 1)) + (node == elements() ? 0 : rest_m(node)));
}

std::optional<std::size_t> Tether::broken() const {
  return broken_ == kWhole ? std::nullopt : std::optional<std::size_t>(broken_);
}

void Tether::lay(std::span<const MovedBody> bodies, const WaterField& water, double time_s) {
  const Eigen::Vector3d start = end_point(spec_.first, bodies), between = end_point(spec_.second, bodies) - start;
  const double length = length_m();
  const Eigen::Vector3d along = between.norm() > 0 ? Eigen::Vector3d(between.normalized()) : Eigen::Vector3d::UnitX();
  const double volume_m2 = std::numbers::pi / 4 * spec_.diameter_m * spec_.diameter_m;
  const bool floats = water.density_at((start + 0.5 * between).z()) * volume_m2 > spec_.mass_kg_m;
  Eigen::Vector3d sag = (floats ? 1 : -1) * Eigen::Vector3d::UnitZ();
  sag -= along.dot(sag) * along;
  if (sag.norm() < 1e-6) sag = along.unitOrthogonal();
  sag.normalize();
  const Eigen::Vector3d beside = along.cross(sag);
  bool is_clear = false;
  for (const bool may_cross_cover : {false, true}) {
    for (const Eigen::Vector3d& way : {sag, Eigen::Vector3d(-sag), beside, Eigen::Vector3d(-beside)}) {
      if (is_clear) break;
      lay_arc(start, between, way);
      is_clear = first_crossed().empty() && (may_cross_cover || !crosses_cover());
    }
  }
  if (first_crossed().empty()) settle(bodies, water, time_s);
  const std::string solid = first_crossed();
  require(solid.empty(), spec_.name,
          printed_number(length) + " m from [" + printed_number(start.x()) + " " + printed_number(start.y()) + " " +
              printed_number(start.z()) + "] m",
          "passes through '" + solid + "' wherever it is laid: move an end, or use another length");
}

/// Nodes on an arc that is as long as the tether, on the side `sag` of its chord.
void Tether::lay_arc(const Eigen::Vector3d& start, const Eigen::Vector3d& between, const Eigen::Vector3d& sag) {
  const double length = length_m(), chord = std::min(1.0, between.norm() / length);
  const Eigen::Vector3d along = between.norm() > 0 ? Eigen::Vector3d(between.normalized()) : Eigen::Vector3d::UnitX();
  const double half = half_angle(chord), radius = length / (2 * half);
  double passed = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const double angle = half * (2 * passed / length - 1);
    nodes_[i].position = start + chord * length / 2 * along + radius * std::sin(angle) * along +
                         radius * (std::cos(angle) - std::cos(half)) * sag;
    if (half < 1e-6) nodes_[i].position = start + passed * along;
    nodes_[i].velocity.setZero();
    nodes_[i].grip = nodes_[i].position;
    nodes_[i].tension_n = 0;
    if (i < elements()) passed += rest_m(i);
  }
}

/// Each of these steps is a step towards equilibrium, with the bodies where they are.
void Tether::settle(std::span<const MovedBody> bodies, const WaterField& water, double time_s) {
  for (std::size_t k = 0; k < 2; ++k)
    ends_[k] = {.is_fixed = true, .next = end_point(k == 0 ? spec_.first : spec_.second, bodies)};
  drum_ = {first_m_, first_m_, spec_.strongest_n};
  double step_s = kFirstSettling_s;
  const bool is_near = may_meet_solids(nodes_.front().position, nodes_.back().position);
  for (int k = 0; k < kSettlings; ++k) {
    freeze(water, time_s - step_s, step_s);
    for (std::size_t i = 0; i < nodes_.size(); ++i) frozen_[i].friction_n = 0;
    freeze_contacts(bodies, step_s, kSettlingReach_m, 0);
    for (TetherContact& contact : contacts_) contact.friction_n = 0;
    const bool is_found = find_next(step_s);
    double farthest = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      farthest = std::max(farthest, (next_[i] - nodes_[i].position).norm());
    if (!is_found || (is_near && farthest > 0.5 * kSettlingReach_m)) {  // else it could pass through a solid
      step_s *= kShrinks;
      continue;
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Node& node = nodes_[i];
      node.position = node.grip = next_[i];
      node.tension_n = frozen_[i].tension_n;
    }
    if (step_s == kLastSettling_s && farthest < kSettled_m) break;
    step_s = std::min(kLastSettling_s, kGrows * step_s);
  }
}

void Tether::moved(std::span<const MovedBody> bodies, double step_s) {
  for (std::size_t i = 0; i < elements(); ++i) nodes_[i].tension_n = frozen_[i].tension_n;
  const std::array at = {&spec_.first, &spec_.second};
  for (std::size_t k = 0; k < 2; ++k) next_[k == 0 ? 0 : elements()] = end_point(*at[k], bodies);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].velocity = (next_[i] - nodes_[i].position) / step_s;
    nodes_[i].position = next_[i];
    grip(i);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    if (at[k]->body == TetherEnd::kNoBody) continue;
    const BodyState& state = bodies[at[k]->body].state;
    nodes_[k == 0 ? 0 : elements()].velocity =
        state.world_from_body.direction(state.linear_body_m_s() + state.angular_body_rad_s().cross(at[k]->point_m));
  }
  break_if_overloaded();
  wind(step_s);
}

/// Moves the point where friction holds a node: to the node without friction, else after it, as far as it slipped.
void Tether::grip(std::size_t i) {
  const Frozen& f = frozen_[i];
  Node& node = nodes_[i];
  if (f.friction_n == 0) {
    node.grip = node.position;
    return;
  }
  const Eigen::Vector3d slip = node.position - node.grip;
  const double most = f.friction_n / f.bed_stiffness, distance = slip.norm();
  if (distance > most) node.grip = node.position - most / distance * slip;
}

void Tether::break_if_overloaded() {
  if (broken()) return;
  std::size_t weakest = 0;
  for (std::size_t i = 1; i < elements(); ++i) {
    if (nodes_[i].tension_n > nodes_[weakest].tension_n) weakest = i;
  }
  if (nodes_[weakest].tension_n > std::min(spec_.breaking_load_n, weakened_n_)) broken_ = weakest;
}

void Tether::cut(double at_m) {
  require(at_m >= 0 && at_m <= length_m(), spec_.name + " at_m", at_m, "must be at most the length that is out");
  if (broken()) return;
  std::size_t element = 0;
  for (double passed = first_m_; passed < at_m && element + 1 < elements(); ++element) passed += rest_m(element + 1);
  broken_ = element;
}

void Tether::weaken(double load_n) {
  require(load_n > 0, spec_.name + " load_n", load_n, "must be positive");
  weakened_n_ = load_n;
}

/// Takes over the first element's length from the drum, and makes of it one more or one less element.
void Tether::wind(double step_s) {
  const double before = first_m_, tension = nodes_[0].tension_n;
  if (tension < drum_.tension_n) {
    first_m_ = drum_.low_m;
  } else if (tension > drum_.tension_n) {
    first_m_ = drum_.high_m;
  } else {
    const double distance = (nodes_[1].position - nodes_[0].position).norm();
    first_m_ = std::clamp(distance - tension * first_m_ / spec_.axial_stiffness_n, drum_.low_m, drum_.high_m);
  }
  rate_m_s_ = (first_m_ - before) / step_s;
  const double usual = spec_.element_m();
  if (first_m_ > kLong * usual) {
    Node added = nodes_[1];
    const double share = usual / first_m_;
    added.position += share * (nodes_[0].position - nodes_[1].position);
    added.velocity += share * (nodes_[0].velocity - nodes_[1].velocity);
    added.grip = added.position;
    added.tension_n = nodes_[0].tension_n;
    nodes_.insert(nodes_.begin() + 1, added);
    first_m_ -= usual;
    if (broken()) ++broken_;
  } else if (first_m_ < kShort * usual && elements() > 1 && broken_ != 0 && broken_ != 1) {
    nodes_.erase(nodes_.begin() + 1);
    first_m_ += usual;
    if (broken()) --broken_;
  }
}

void Tether::command(const WinchCommand& command) {
  const std::string path = spec_.name + " winch";
  require(spec_.fastest_m_s > 0, path, command.value, "has none");
  require(std::isfinite(command.value), path, command.value, "must be finite");
  if (command.mode == WinchCommand::Mode::kRate)
    require(std::abs(command.value) <= spec_.fastest_m_s, path, command.value,
            "must be at most " + printed_number(spec_.fastest_m_s) + " m/s");
  if (command.mode == WinchCommand::Mode::kTension)
    require(command.value >= 0 && command.value <= spec_.strongest_n, path, command.value,
            "must be in [0, " + printed_number(spec_.strongest_n) + "] N");
  winch_ = command;
}

void Tether::exchange_state(StateArchive& archive) {
  const auto exchange = [&](Eigen::Vector3d& vector) {
    for (double& value : vector) archive(value);
  };
  const std::size_t most = frozen_.size();
  archive.list(nodes_, [&](Node& node) {
    exchange(node.position);
    exchange(node.velocity);
    exchange(node.grip);
    archive(node.tension_n);
  });
  require(nodes_.size() >= 2 && nodes_.size() <= most, "state.tether.nodes", nodes_.size(), "must suit its length");
  archive(first_m_);
  require(first_m_ > 0 && length_m() <= spec_.most_m() + spec_.element_m(), "state.tether.length_m", length_m(),
          "must suit its winch");
  archive(rate_m_s_);
  archive(broken_);
  require(broken_ == kWhole || broken_ < elements(), "state.tether.broken", broken_, "must be one of its elements");
  auto mode = static_cast<std::uint64_t>(winch_.mode);
  archive(mode);
  require(mode <= 2, "state.tether.winch", mode, "must be a mode");
  winch_.mode = static_cast<WinchCommand::Mode>(mode);
  archive(winch_.value);
  for (Eigen::Vector3d& force : end_forces_) exchange(force);
}

}  // namespace uwsim
