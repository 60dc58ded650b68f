#include "uwsim/world/school.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/core/stream_name.h"

namespace uwsim {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kBend = 0.2;  // amplitude of the course's second harmonic, relative to the first
constexpr double kRise = 0.3;  // of the course, relative to the school's height
constexpr std::size_t kNeighbours = 8;
constexpr std::array kRhythms_hz = {0.11, 0.17, 0.23, 0.29};  // of the sway
constexpr double kSwaySpeed = 0.2;                            // largest, relative to the school's
constexpr double kFree = 16;   // widths above a bound, where its pressure is below 1e-7 of the width
constexpr double kSway = 0.2;  // largest amplitude, relative to the school's height

/// Points evenly spread in the unit ball: Roberts's additive sequence for three dimensions, without those outside.
std::vector<Eigen::Vector3d> points_in_ball(std::size_t count, double start) {
  constexpr double kPlastic = 1.22074408460575947536;  // the root of x^4 = x + 1
  const Eigen::Vector3d step(1 / kPlastic, 1 / (kPlastic * kPlastic), 1 / (kPlastic * kPlastic * kPlastic));
  std::vector<Eigen::Vector3d> points;
  for (double n = 0; points.size() < count; ++n) {
    Eigen::Vector3d point = Eigen::Vector3d::Constant(start) + n * step;
    for (double& x : point) x = 2 * (x - std::floor(x)) - 1;
    if (point.squaredNorm() < 1) points.push_back(point);
  }
  return points;
}

/// Orders points so that consecutive ones are near each other: halves, by the longest extent, down to a few.
void order_by_nearness(std::span<Eigen::Vector3d> points) {
  if (points.size() <= kNeighbours) return;
  Eigen::Vector3d low = points.front(), high = low;
  for (const Eigen::Vector3d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::ranges::stable_sort(points, {}, [axis](const Eigen::Vector3d& p) { return p[axis]; });
  const std::size_t half = (points.size() / 2 + kNeighbours - 1) / kNeighbours * kNeighbours;
  order_by_nearness(points.first(half));
  order_by_nearness(points.subspan(half));
}

/// Presses a value above a bound, smoothly within about `width`; scales its rate alike.
void press_above(double bound, double width, double& value, double& rate) {
  const double x = (value - bound) / width;
  if (!(x < kFree)) return;
  const double grown = std::exp(std::max(x, -30.0));
  value = bound + width * std::log1p(grown);
  rate *= grown / (1 + grown);
}

}  // namespace

void SchoolSpec::check() const {
  const std::string path = "life '" + name + "' ";
  require(count > 0, path + "count", count, "must be positive");
  require(!shapes_m.empty(), path + "shapes", "none", "must be one or more");
  for (const auto& phases : shapes_m) {
    require(!phases.empty() && phases.size() == shapes_m.front().size(), path + "phases", phases.size(),
            "must be as many for each size");
  }
  require(home_world_m.allFinite(), path + "position_m", home_world_m.transpose(), "must be finite");
  require(round_m > 0 && speed_m_s > 0 && clear_m > 0, path + "round_m, speed_m_s, clear_m", round_m,
          "must be positive");
  require((spread_m.array() > 0).all(), path + "spread_m", spread_m.transpose(), "must be positive");
  require(stroke_hz >= 0, path + "stroke_hz", stroke_hz, "must not be negative");
}

School::School(SchoolSpec spec, std::shared_ptr<const Heightfield> terrain)
    : spec_((spec.check(), std::move(spec))), terrain_(std::move(terrain)) {
  const RandomStream random(spec_.seed, stream_name("life", spec_.name));
  const auto draw = [&](std::uint64_t fish, std::uint32_t index) { return random.uniform(fish, index); };
  rate_rad_s_ = spec_.speed_m_s / (spec_.round_m * std::sqrt(1 + 4 * kBend * kBend));
  start_rad_ = kTurn * draw(0, 0);
  for (int k = 0; k < 3; ++k) {
    const double phase = kTurn * draw(0, static_cast<std::uint32_t>(1 + k));
    bend_cos_[k] = std::cos(phase), bend_sin_[k] = std::sin(phase);
  }
  sway_m_ = std::min(kSway * spec_.spread_m.z(), kSwaySpeed * spec_.speed_m_s / (kTurn * kRhythms_hz.back()));
  std::vector<Eigen::Vector3d> points = points_in_ball(spec_.count, draw(0, 4));
  for (Eigen::Vector3d& point : points) point = point.cwiseProduct(spec_.spread_m).eval();
  order_by_nearness(points);
  for (std::size_t k = 0; k < points.size(); ++k) {
    Place place;
    place.across_m = points[k].y(), place.up_m = points[k].z();
    const double lag_rad = -rate_rad_s_ * points[k].x() / spec_.speed_m_s;
    place.lag_cos = std::cos(lag_rad), place.lag_sin = std::sin(lag_rad);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const double phase = kTurn * draw(k + 1, axis);
      place.sway_cos[axis] = std::cos(phase), place.sway_sin[axis] = std::sin(phase);
    }
    place.stroke = draw(k + 1, 3);
    place.rhythm = static_cast<std::size_t>(draw(k + 1, 4) * kRhythms_hz.size());
    place.size = static_cast<std::size_t>(draw(k + 1, 5) * static_cast<double>(spec_.shapes_m.size()));
    places_.push_back(place);
  }
}

Eigen::Matrix3d Swimmer::rotation() const {
  const Eigen::Vector3d x = velocity_world.normalized(), y = Eigen::Vector3d(-x.y(), x.x(), 0).normalized();
  Eigen::Matrix3d columns;
  columns << x, y, x.cross(y);
  return columns;
}

double School::angle(double time_s) const { return std::fmod(start_rad_ + rate_rad_s_ * time_s, kTurn); }

School::Course School::course(double cosine, double sine) const {
  const double cos2 = cosine * cosine - sine * sine, sin2 = 2 * cosine * sine, r = spec_.round_m;
  Course at;
  at.position = spec_.home_world_m;
  at.position.x() += r * (cosine + kBend * (cos2 * bend_cos_[0] - sin2 * bend_sin_[0]));
  at.position.y() += r * (sine + kBend * (sin2 * bend_cos_[1] + cos2 * bend_sin_[1]));
  at.position.z() += kRise * spec_.spread_m.z() * (sine * bend_cos_[2] + cosine * bend_sin_[2]);
  at.by_angle.x() = r * (-sine - 2 * kBend * (sin2 * bend_cos_[0] + cos2 * bend_sin_[0]));
  at.by_angle.y() = r * (cosine + 2 * kBend * (cos2 * bend_cos_[1] - sin2 * bend_sin_[1]));
  return at;
}

double School::reach_m() const {
  const double level_m = spec_.round_m * (1 + kBend) + spec_.spread_m.y() + sway_m_;
  const double swum_m = (1 + kRise) * spec_.spread_m.z() + sway_m_, home_m = spec_.home_world_m.z();
  const double pressed_m = 2 * spec_.clear_m + (terrain_ ? std::max(0.0, terrain_->highest_m() - home_m) : 0);
  return std::hypot(std::sqrt(2.0) * level_m, swum_m + pressed_m + std::max(0.0, home_m));
}

void School::place(double time_s, std::span<Swimmer> fish) const {
  const double angle_rad = angle(time_s), cosine = std::cos(angle_rad), sine = std::sin(angle_rad);
  std::array<double, kRhythms_hz.size()> sway_cos, sway_sin;
  for (std::size_t k = 0; k < kRhythms_hz.size(); ++k) {
    const double phase = kTurn * std::fmod(kRhythms_hz[k] * time_s, 1.0);
    sway_cos[k] = std::cos(phase), sway_sin[k] = std::sin(phase);
  }
  const std::size_t last_phase = spec_.shapes_m.front().size() - 1;
  const double phases = static_cast<double>(last_phase + 1), stroke = std::fmod(spec_.stroke_hz * time_s, 1.0);
  const double free_m = terrain_ ? terrain_->highest_m() + (1 + kFree) * spec_.clear_m : 0;  // of the bed's pressure
  for (std::size_t k = 0; k < fish.size(); ++k) {
    const Place& place = places_[k];
    const double c = cosine * place.lag_cos + sine * place.lag_sin, s = sine * place.lag_cos - cosine * place.lag_sin;
    const Course at = course(c, s);
    Eigen::Vector3d sway, velocity;
    const std::size_t rhythm = place.rhythm;
    for (int axis = 0; axis < 3; ++axis) {
      const double beat_cos = sway_cos[rhythm] * place.sway_cos[axis] - sway_sin[rhythm] * place.sway_sin[axis];
      sway[axis] = sway_m_ * (sway_sin[rhythm] * place.sway_cos[axis] + sway_cos[rhythm] * place.sway_sin[axis]);
      velocity[axis] = kTurn * kRhythms_hz[rhythm] * sway_m_ * beat_cos;
    }
    const Eigen::Vector2d ahead = at.by_angle.normalized();
    Eigen::Vector3d position = at.position + sway;
    position.head<2>() += place.across_m * Eigen::Vector2d(-ahead.y(), ahead.x());
    position.z() += place.up_m;
    velocity.head<2>() += rate_rad_s_ * at.by_angle;
    double fall = -velocity.z(), depth = -position.z();
    press_above(spec_.clear_m, spec_.clear_m, depth, fall);
    position.z() = -depth, velocity.z() = -fall;
    if (terrain_ && position.z() < free_m) {
      const double bed_m = terrain_->height_at(position.x(), position.y());
      press_above(bed_m + spec_.clear_m, spec_.clear_m, position.z(),
                  velocity.z());  // NaN beyond the terrain: as it is
    }
    Swimmer& one = fish[k];
    one.position_world_m = position;
    one.velocity_world = velocity;
    one.size = place.size;
    const double beat = stroke + place.stroke;  // below 2
    one.phase = std::min(static_cast<std::size_t>((beat < 1 ? beat : beat - 1) * phases), last_phase);
  }
}

}  // namespace uwsim
