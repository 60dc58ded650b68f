#include "uwsim/sonar/water_targets.h"

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"
#include "uwsim/core/random.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {

void WaterTargets::check(const std::string& path) const {
  require(position_m.allFinite(), path + ".position_m", position_m.transpose(), "must be finite");
  require(size_m.minCoeff() > 0 && size_m.maxCoeff() <= 1e4, path + ".size_m", size_m.transpose(),
          "must be in (0, 10000] m");
  require(count >= 1 && count <= 10'000, path + ".count", count, "must be in [1, 10000]");
  require(target_strength_db >= -120 && target_strength_db <= 40, path + ".target_strength_db",
          with_unit(target_strength_db, "dB"), "must be in [-120, 40] dB");
  require(rise_m_s >= 0 && rise_m_s <= 10, path + ".rise_m_s", with_unit(rise_m_s, "m/s"), "must be in [0, 10] m/s");
}

MovingTargets::MovingTargets(const WaterTargets& group, std::uint64_t seed)
    : group_(group), unit_(3, group.count), cross_section_m2_(std::pow(10, group.target_strength_db / 10)) {
  const RandomStream random(seed, "water_targets/" + group.name);
  for (int k = 0; k < group.count; ++k) {
    const auto draw = [&](std::uint32_t which) { return random.uniform(static_cast<std::uint64_t>(k), which); };
    const double around_rad = 2 * std::numbers::pi * draw(0);
    if (group.rises) {
      const double radius = std::sqrt(draw(1));
      unit_.col(k) << radius * std::cos(around_rad), radius * std::sin(around_rad), draw(2);
    } else {
      const double radius = std::cbrt(draw(1)), height = 2 * draw(2) - 1, flat = std::sqrt(1 - height * height);
      unit_.col(k) = radius * Eigen::Vector3d(flat * std::cos(around_rad), flat * std::sin(around_rad), height);
    }
  }
}

Eigen::Matrix3Xd MovingTargets::at(double time_s) const {
  Eigen::Matrix3Xd places = unit_;
  for (Eigen::Index k = 0; k < places.cols(); ++k) {
    Eigen::Vector3d scale = 0.5 * group_.size_m;
    if (group_.rises) {
      const double turns = places(2, k) + time_s * group_.rise_m_s / group_.size_m.z();
      places(2, k) = turns - std::floor(turns);
      scale = {scale.x() * places(2, k), scale.y() * places(2, k), group_.size_m.z()};
    }
    places.col(k) = group_.position_m + places.col(k).cwiseProduct(scale);
  }
  return places;
}

}  // namespace uwsim
