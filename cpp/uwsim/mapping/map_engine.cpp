#include "uwsim/mapping/map_engine.h"

#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/mapping/morton.h"

namespace uwsim {
namespace {

/// A cube of more chunks than this is "all of them".
constexpr int kListedLevelsMax = 10;

}  // namespace

bool KeyBox::meets(const VoxelKey& corner, int levels) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (corner[axis] > high[axis] || corner[axis] + (1 << levels) <= low[axis]) return false;
  }
  return true;
}

KeyBox chunk_box(std::uint32_t chunk) {
  const VoxelKey low = morton::key(std::uint64_t{chunk} << 18);
  return {low, {low[0] + 63, low[1] + 63, low[2] + 63}};
}

void ChangedChunks::add(const VoxelKey& corner, int levels) {
  if (all) return;
  if (levels > kListedLevelsMax) {
    all = true;
    return;
  }
  const auto axis = [&](std::size_t i) { return static_cast<std::uint32_t>(corner[i]); };
  const auto first = static_cast<std::uint32_t>(morton::code(axis(0), axis(1), axis(2)) >> 18);
  const std::uint32_t count = levels <= 6 ? 1 : 1u << (3 * (levels - 6));
  for (std::uint32_t i = 0; i < count; ++i) codes.insert(codes.end(), first + i);
}

float OccupancyModel::log_odds(double probability) {
  return static_cast<float>(std::log(probability / (1 - probability)));
}

void OccupancyModel::check() const {
  require(hit >= 0.5 && hit < 1, "map.hit", hit, "must be in [0.5, 1)");
  require(miss > 0 && miss <= 0.5, "map.miss", miss, "must be in (0, 0.5]");
  require(clamping_min > 0 && clamping_min < 1, "map.clamping_min", clamping_min, "must be in (0, 1)");
  require(clamping_max > clamping_min && clamping_max < 1, "map.clamping_max", clamping_max,
          "must be greater than map.clamping_min and less than 1");
}

}  // namespace uwsim
