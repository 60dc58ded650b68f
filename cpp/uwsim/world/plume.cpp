#include "uwsim/world/plume.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/stream_name.h"

namespace uwsim {
namespace {

constexpr double kSourceRadius_m = 0.01;
constexpr double kFarthest = 2;                          // radii, which a cluster does not exceed
const double kSpread = 1 / std::sqrt(2 * std::log(10));  // standard deviation, in radii: 90 % are within one

}  // namespace

void PlumeSpec::check() const {
  const std::string path = "plume '" + name + "' ";
  require(count > 0, path + "count", count, "must be positive");
  require(!shapes_m.empty(), path + "shapes", "none", "must be one or more");
  for (const auto& phases : shapes_m) {
    require(!phases.empty() && phases.size() == shapes_m.front().size(), path + "phases", phases.size(),
            "must be as many for each size");
  }
  require(source_world_m.allFinite() && drift_m_s.allFinite(), path + "source_world_m", source_world_m.transpose(),
          "must be finite");
  require(top_z_m > source_world_m.z(), path + "top_z_m", top_z_m, "must be above the source");
  require(rise_m_s > 0 && widens >= 0, path + "rise_m_s", rise_m_s, "must be positive");
}

Plume::Plume(PlumeSpec spec)
    : spec_((spec.check(), std::move(spec))), random_(spec_.seed, stream_name("plume", spec_.name)) {}

Eigen::Vector3d Plume::middle_world_m() const {
  return spec_.source_world_m + 0.5 * height_m() * (Eigen::Vector3d::UnitZ() + spec_.drift_m_s / spec_.rise_m_s);
}

double Plume::reach_m() const {
  const double widest_m = kFarthest * (kSourceRadius_m + spec_.widens * height_m());
  return 0.5 * height_m() * std::hypot(1.0, spec_.drift_m_s.norm() / spec_.rise_m_s) + widest_m;
}

/// Clusters in order of their start, so that consecutive ones are neighbours.
void Plume::place(double time_s, std::span<Swimmer> bodies) const {
  const double way_s = height_m() / spec_.rise_m_s, ways = time_s / way_s;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const double since = ways + (static_cast<double>(k) + random_.uniform(k, 0)) / static_cast<double>(bodies.size());
    const double passed = std::floor(since), share = since - passed;
    const auto draw = [&](std::uint32_t index) {
      return random_.uniform(static_cast<std::uint64_t>(passed) * bodies.size() + k, 1 + index);
    };
    const double radius_m = kSourceRadius_m + spec_.widens * share * height_m();
    const double off = std::min(kSpread * std::sqrt(-2 * std::log(1 - draw(0))), kFarthest);
    const double turn = 2 * std::numbers::pi * draw(1), heading = 2 * std::numbers::pi * draw(2);
    Swimmer& one = bodies[k];
    one.position_world_m =
        spec_.source_world_m + share * way_s * spec_.drift_m_s +
        Eigen::Vector3d(off * radius_m * std::cos(turn), off * radius_m * std::sin(turn), share * height_m());
    one.velocity_world = {std::cos(heading), std::sin(heading), 0};
    one.size = std::min(static_cast<std::size_t>(share * static_cast<double>(spec_.shapes_m.size())),
                        spec_.shapes_m.size() - 1);
    const auto phases = static_cast<double>(spec_.shapes_m.front().size());
    one.phase = std::min(static_cast<std::size_t>(draw(3) * phases), spec_.shapes_m.front().size() - 1);
  }
}

}  // namespace uwsim
