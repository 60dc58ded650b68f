#include "uwsim/control/path_follower.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

constexpr double kSlowDown_s = 0.5, kSpeedUp_s = 20;  // to change by the full speed
constexpr double kSlowest = 0.1;                      // lowest fraction of the full speed

}  // namespace

PathFollower::PathFollower(std::vector<Eigen::Vector3d> points_m, double lookahead_m, double integral_m_s,
                           double period_s)
    : points_m_(std::move(points_m)), lookahead_m_(lookahead_m), integral_m_s_(integral_m_s), period_s_(period_s) {
  require(points_m_.size() >= 2, "points_m", points_m_.size(), "must be at least two points");
  require(std::isfinite(lookahead_m) && lookahead_m > 0, "lookahead_m", with_unit(lookahead_m, "m"),
          "must be positive");
  require(std::isfinite(integral_m_s) && integral_m_s >= 0, "integral_m_s", with_unit(integral_m_s, "m/s"),
          "must not be negative");
  require(std::isfinite(period_s) && period_s > 0, "period_s", with_unit(period_s, "s"), "must be positive");
  starts_m_ = {0.0};
  for (std::size_t k = 0; k + 1 < points_m_.size(); ++k) {
    const double step_m = (points_m_[k + 1] - points_m_[k]).head<2>().norm();
    require(step_m > 1e-6, "points_m[" + std::to_string(k + 1) + "]", points_m_[k + 1].transpose(),
            "must be beside the point before, not above or under it");
    starts_m_.push_back(starts_m_.back() + step_m);
  }
}

Guidance PathFollower::guide(const Eigen::Vector3d& position_world_m) {
  Guidance guidance;
  double along_m = 0, across_m = 0;
  for (;; ++segment) {
    const Eigen::Vector2d start_m = points_m_[segment].head<2>(), end_m = points_m_[segment + 1].head<2>();
    const Eigen::Vector2d ahead = (end_m - start_m) / length_m(segment);
    const Eigen::Vector2d from_start = position_world_m.head<2>() - start_m;
    along_m = ahead.dot(from_start);
    across_m = ahead.x() * from_start.y() - ahead.y() * from_start.x();
    guidance.path_rad = std::atan2(ahead.y(), ahead.x());
    const bool is_last = segment + 2 == points_m_.size();
    guidance.is_done = is_last && along_m >= length_m(segment);
    if (is_last || along_m < length_m(segment)) break;
    integral_s = 0;  // the old integral belongs to another segment
  }
  const double aim_m = across_m + integral_m_s_ * integral_s;
  guidance.course_rad = guidance.path_rad - std::atan(aim_m / lookahead_m_);
  guidance.cross_track_m = across_m;
  guidance.along_m = starts_m_[segment] + along_m;
  guidance.left_m = std::max(0.0, starts_m_.back() - guidance.along_m);
  const double share = std::clamp(along_m / length_m(segment), 0.0, 1.0);
  guidance.z_world_m = points_m_[segment].z() + share * (points_m_[segment + 1].z() - points_m_[segment].z());
  integral_s += period_s_ * lookahead_m_ * across_m / (aim_m * aim_m + lookahead_m_ * lookahead_m_);
  return guidance;
}

Eigen::Vector2d PathFollower::pace(double course_rad, double speed_m_s, double force_share) {
  const double lacking = 1 - force_share;
  const double change = lacking > 1e-6 ? -lacking / kSlowDown_s : 1 / kSpeedUp_s;
  speed_share = std::min(std::max(speed_share + period_s_ * change, kSlowest), 1.0);
  const double speed = speed_share * speed_m_s;
  return {speed * std::cos(course_rad), speed * std::sin(course_rad)};
}

}  // namespace uwsim
