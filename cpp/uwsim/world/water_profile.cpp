#include "uwsim/world/water_profile.h"

#include <algorithm>
#include <limits>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

void check(const WaterLevel& level, const std::string& path) {
  const auto require_in = [&path](double value, double low, double high, const char* name, const char* rule) {
    require(value >= low && value <= high, path + "." + name, value, rule);
  };
  require_in(level.depth_m, 0, 12000, "depth_m", "must be in [0, 12000] m");
  require_in(level.temperature_deg_c, -2, 40, "temperature_deg_c", "must be in [-2, 40] deg C");
  require_in(level.salinity_psu, 0, 45, "salinity_psu", "must be in [0, 45] psu");
  require_in(level.density_kg_m3, 900, 1300, "density_kg_m3", "must be in [900, 1300] kg/m3");
  if (level.sound_speed_m_s != 0)
    require_in(level.sound_speed_m_s, 1300, 1900, "sound_speed_m_s", "must be in [1300, 1900] m/s");
}

double interpolated(double a, double b, double fraction) { return a + fraction * (b - a); }

}  // namespace

WaterProfile::WaterProfile(std::span<const WaterLevel> levels) : levels_(levels.begin(), levels.end()) {
  require(!levels_.empty(), "water.profile.levels", 0, "must have at least one level");
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const WaterLevel& level = levels_[k];
    const std::string path = "water.profile.levels[" + std::to_string(k) + "]";
    check(level, path);
    require((level.sound_speed_m_s == 0) == (levels_[0].sound_speed_m_s == 0), path + ".sound_speed_m_s",
            level.sound_speed_m_s, "must be given at all levels or at none");
    if (k == 0) {
      columns_kg_m2_.push_back(level.depth_m * level.density_kg_m3);
      continue;
    }
    const WaterLevel& upper = levels_[k - 1];
    require(level.depth_m > upper.depth_m, path + ".depth_m", with_unit(level.depth_m, "m"),
            "must be deeper than the level before");
    columns_kg_m2_.push_back(columns_kg_m2_.back() +
                             0.5 * (level.density_kg_m3 + upper.density_kg_m3) * (level.depth_m - upper.depth_m));
    even_ = even_ && level.density_kg_m3 == upper.density_kg_m3;
  }
  set_layers();
}

void WaterProfile::set_layers() {
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const WaterLevel& deeper = levels_[k];
    DensityLayer layer{
        .low_m = -deeper.depth_m, .reference_m = -deeper.depth_m, .density_kg_m3 = deeper.density_kg_m3, .number = k};
    if (k > 0) {
      const WaterLevel& upper = levels_[k - 1];
      layer.high_m = -upper.depth_m;
      layer.gradient_kg_m4 = (upper.density_kg_m3 - deeper.density_kg_m3) / (deeper.depth_m - upper.depth_m);
    }
    layers_.push_back(layer);
  }
  const WaterLevel& deepest = levels_.back();
  layers_.push_back({.high_m = -deepest.depth_m, .density_kg_m3 = deepest.density_kg_m3, .number = levels_.size()});
}

std::size_t WaterProfile::first_below(double depth_m) const {
  const auto end = std::upper_bound(levels_.begin(), levels_.end(), depth_m,
                                    [](double depth, const WaterLevel& level) { return depth < level.depth_m; });
  return static_cast<std::size_t>(end - levels_.begin());
}

WaterLevel WaterProfile::at(double z_world_m) const {
  const double depth = -z_world_m;
  const std::size_t k = first_below(depth);
  if (k == 0) return levels_.front();
  if (k == levels_.size()) return levels_.back();
  const WaterLevel &a = levels_[k - 1], &b = levels_[k];
  const double fraction = (depth - a.depth_m) / (b.depth_m - a.depth_m);
  return {depth, interpolated(a.temperature_deg_c, b.temperature_deg_c, fraction),
          interpolated(a.salinity_psu, b.salinity_psu, fraction),
          interpolated(a.density_kg_m3, b.density_kg_m3, fraction),
          interpolated(a.sound_speed_m_s, b.sound_speed_m_s, fraction)};
}

double WaterProfile::density_at(double z_world_m) const {
  const double depth = -z_world_m;
  const std::size_t k = first_below(depth);
  if (k == 0) return levels_.front().density_kg_m3;
  if (k == levels_.size()) return levels_.back().density_kg_m3;
  const WaterLevel &a = levels_[k - 1], &b = levels_[k];
  return interpolated(a.density_kg_m3, b.density_kg_m3, (depth - a.depth_m) / (b.depth_m - a.depth_m));
}

/// A layer contains z in [low, high): a boundary belongs to the layer above it.
DensityLayer WaterProfile::density_layer_at(double z_world_m) const {
  const auto deeper = std::lower_bound(levels_.begin(), levels_.end(), -z_world_m,
                                       [](const WaterLevel& level, double depth) { return level.depth_m < depth; });
  return layers_[static_cast<std::size_t>(deeper - levels_.begin())];
}

double WaterProfile::column_kg_m2(double z_world_m) const {
  const double depth = -z_world_m;
  const std::size_t k = first_below(depth);
  if (k == 0) return levels_.front().density_kg_m3 * depth;
  const WaterLevel& a = levels_[k - 1];
  return columns_kg_m2_[k - 1] + 0.5 * (a.density_kg_m3 + at(z_world_m).density_kg_m3) * (depth - a.depth_m);
}

}  // namespace uwsim
