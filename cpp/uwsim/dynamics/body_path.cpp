#include "uwsim/dynamics/body_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

/// The index of the piece that contains a value, between ascending breaks.
std::size_t piece_at(const std::vector<double>& breaks, double value) {
  const auto after = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, value);
  return static_cast<std::size_t>(after - breaks.begin()) - 1;
}

void require_ascending(const char* name, const std::vector<double>& breaks, std::size_t pieces) {
  require(pieces > 0 && breaks.size() == pieces + 1, name, breaks.size(), "must be one more than the pieces");
  for (std::size_t k = 0; k < pieces; ++k)
    require(std::isfinite(breaks[k + 1]) && breaks[k] < breaks[k + 1], name, breaks[k + 1], "must ascend");
}

/// Heading and climb of the horizontal's axis system, and their rates by the curve's parameter.
struct Direction {
  double heading_rad = 0, climb_rad = 0, turn = 0, pull_up = 0;

  Direction() = default;
  Direction(const Eigen::Vector3d& first, const Eigen::Vector3d& second, bool climbs)
      : heading_rad(std::atan2(first.y(), first.x())) {
    const double level2 = first.head<2>().squaredNorm();
    if (!(level2 > 0)) return;
    turn = (first.x() * second.y() - first.y() * second.x()) / level2;
    if (!climbs) return;
    const double level = std::sqrt(level2), level_rate = first.head<2>().dot(second.head<2>()) / level;
    climb_rad = std::atan2(first.z(), level);
    pull_up = (level * second.z() - first.z() * level_rate) / first.squaredNorm();
  }
};

}  // namespace

void BodyPathSpec::check() const {
  require_ascending("path.breaks", breaks, curve_m.size());
  require_ascending("path.times_s", times_s, progress.size());
  require(times_s.front() == 0, "path.times_s", times_s.front(), "must begin at 0 s");
  for (const auto& piece : curve_m) require(piece.allFinite(), "path.curve_m", "non-finite", "must be finite");
  for (const auto& piece : progress) require(piece.allFinite(), "path.progress", "non-finite", "must be finite");
}

BodyPath::BodyPath(BodyPathSpec spec) : spec_((spec.check(), std::move(spec))) {}

bool BodyPath::stands() const {
  return std::ranges::all_of(spec_.progress, [](const Eigen::Vector4d& piece) { return piece.isZero(0); });
}

BodyState BodyPath::at(double time_s) const {
  const double end_s = spec_.times_s.back();
  const bool ended = !spec_.closed && time_s >= end_s;
  const double now_s = ended ? end_s : std::fmod(time_s, end_s);
  const std::size_t step = piece_at(spec_.times_s, now_s);
  const double t = now_s - spec_.times_s[step];
  const Eigen::Vector4d& c = spec_.progress[step];
  const double u = std::clamp(c[0] + t * (c[1] + t * (c[2] + t * c[3])), spec_.breaks.front(), spec_.breaks.back());
  const double rate = ended ? 0 : c[1] + t * (2 * c[2] + t * 3 * c[3]);  // du/dt

  const std::size_t k = piece_at(spec_.breaks, u);
  const double h = u - spec_.breaks[k];
  const Eigen::Matrix<double, 4, 3>& p = spec_.curve_m[k];
  const Eigen::Vector3d position = p.row(0) + h * (p.row(1) + h * (p.row(2) + h * p.row(3)));
  const Eigen::Vector3d first = p.row(1) + h * (2 * p.row(2) + h * 3 * p.row(3));
  const Eigen::Vector3d second = 2 * p.row(2) + h * 6 * p.row(3);
  const Direction along = spec_.turns ? Direction(first, second, spec_.climbs) : Direction();

  const Eigen::Quaterniond level(Eigen::AngleAxisd(along.heading_rad, Eigen::Vector3d::UnitZ()));
  const Pose world_from_path{position, level * Eigen::AngleAxisd(-along.climb_rad, Eigen::Vector3d::UnitY())};
  BodyState state;
  state.world_from_body = world_from_path * spec_.path_from_body;
  const Eigen::Vector3d turning_rad_s =
      rate * (along.turn * Eigen::Vector3d::UnitZ() - along.pull_up * (level * Eigen::Vector3d::UnitY()));
  const Eigen::Vector3d arm = state.world_from_body.position_m - position;
  const Eigen::Quaterniond body_from_world = state.world_from_body.orientation.conjugate();
  state.velocity_body << body_from_world * (rate * first + turning_rad_s.cross(arm)), body_from_world * turning_rad_s;
  return state;
}

}  // namespace uwsim
