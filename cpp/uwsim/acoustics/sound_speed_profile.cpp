#include "uwsim/acoustics/sound_speed_profile.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

constexpr double kSlowest_m_s = 1300, kFastest_m_s = 1900;

void check(std::span<const double> depths_m, std::span<const double> speeds_m_s) {
  require(!depths_m.empty(), "sound_speed_profile.depths_m", "none", "must have at least one level");
  require(speeds_m_s.size() == depths_m.size(), "sound_speed_profile.speeds_m_s.size", speeds_m_s.size(),
          "must be one for each depth, " + std::to_string(depths_m.size()));
  for (std::size_t k = 0; k < depths_m.size(); ++k) {
    const auto path = [k](const char* field) {
      return std::string("sound_speed_profile.") + field + "[" + std::to_string(k) + "]";
    };
    require(depths_m[k] >= 0 && depths_m[k] <= 12000, path("depths_m"), with_unit(depths_m[k], "m"),
            "must be in [0, 12000] m");
    require(k == 0 || depths_m[k] > depths_m[k - 1], path("depths_m"), with_unit(depths_m[k], "m"),
            "must be deeper than the level before");
    require(speeds_m_s[k] >= kSlowest_m_s && speeds_m_s[k] <= kFastest_m_s, path("speeds_m_s"),
            with_unit(speeds_m_s[k], "m/s"), "must be in [1300, 1900] m/s");
  }
}

}  // namespace

SoundSpeedProfile::SoundSpeedProfile(std::span<const double> depths_m, std::span<const double> speeds_m_s) {
  check(depths_m, speeds_m_s);
  layers_.push_back({-kInfinity, depths_m.front(), depths_m.front(), speeds_m_s.front(), 0});
  for (std::size_t k = 1; k < depths_m.size(); ++k) {
    const double gradient = (speeds_m_s[k] - speeds_m_s[k - 1]) / (depths_m[k] - depths_m[k - 1]);
    layers_.push_back({depths_m[k - 1], depths_m[k], depths_m[k - 1], speeds_m_s[k - 1], gradient});
    steepest_1_s_ = std::max(steepest_1_s_, std::abs(gradient));
  }
  layers_.push_back({depths_m.back(), kInfinity, depths_m.back(), speeds_m_s.back(), 0});
}

SoundSpeedProfile SoundSpeedProfile::even(double speed_m_s) {
  const double depth = 0;
  return SoundSpeedProfile({&depth, 1}, {&speed_m_s, 1});
}

std::size_t SoundSpeedProfile::layer_at(double depth_m) const {
  const auto end = std::upper_bound(layers_.begin() + 1, layers_.end(), depth_m,
                                    [](double depth, const SoundLayer& layer) { return depth < layer.top_m; });
  return static_cast<std::size_t>(end - layers_.begin()) - 1;
}

}  // namespace uwsim
