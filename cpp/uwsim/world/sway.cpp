#include "uwsim/world/sway.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwsim {
namespace {

constexpr double kWhere = 2.0 / 3;  // of the height: where drag that is even along a rod acts by its moment
constexpr double kStill_m_s = 1e-6;

}  // namespace

std::shared_ptr<const Sway> Sway::of(const World& world, double time_s) {
  const Water& water = world.water;
  const bool moves = water.waves || !water.currents.empty() || !water.current_world_m_s.isZero(0);
  if (!moves || std::ranges::none_of(world.cover(), [](const auto& layer) { return layer->sways(); })) return nullptr;
  return std::make_shared<const Sway>(water, time_s);
}

Sway::Sway(const Water& water, double time_s)
    : current_(water), waves_(water.waves), time_s_(time_s), level_m_(water.still_level_m(time_s)) {
  current_.waves = nullptr;
}

bool Sway::same_as(const Sway& other) const {
  return time_s_ == other.time_s_ && waves_ == other.waves_ && current_.currents == other.current_.currents &&
         current_.tide == other.current_.tide && current_.current_world_m_s == other.current_.current_world_m_s;
}

Eigen::Vector2d Sway::lean(const CoverLayer& layer, const Eigen::Vector3d& foot_world_m) const {
  const double height_m = std::sqrt(layer.size_m.low * layer.size_m.high), own = layer.leans_at_m_s;
  Eigen::Vector3d at = foot_world_m + kWhere * height_m * Eigen::Vector3d::UnitZ();
  const Eigen::Vector2d current = current_.flow_at(at, time_s_).velocity_m_s.head<2>();
  at.z() -= level_m_;
  const double square = waves_ ? waves_->mean_square_m2_s2(at.z()) : 0;
  const double passes = std::sqrt(current.squaredNorm() + 8 / std::numbers::pi * square);
  if (passes < kStill_m_s) return Eigen::Vector2d::Zero();
  const double rate = own * own / (passes * height_m);
  Eigen::Vector2d moved = current / rate;
  if (waves_) moved += waves_->held_m(at, time_s_, rate);
  return moved / height_m;
}

}  // namespace uwsim
