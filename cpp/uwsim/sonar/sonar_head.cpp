#include "uwsim/sonar/sonar_head.h"

#include <cmath>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {

SonarHead::SonarHead(const SonarSpec& spec, const Water& water, const RandomStream& stream)
    : name_(spec.name),
      multibeam_((spec.model.check(), spec.model), spec.strengths_db, spec.on),
      body_from_mount_(spec.body_from_mount) {
  aim(spec.elevation_rad);
  elevation_rad_ = aimed_rad_;
  if (spec.acoustics) acoustics_.emplace(spec.model, *spec.acoustics, water, water.bottom_depth_m, stream);
}

void SonarHead::aim(double elevation_rad) {
  require(std::abs(elevation_rad) <= std::numbers::pi / 2, "sonar.elevation_rad", elevation_rad,
          "must be in [-pi/2, pi/2] rad");
  aimed_rad_ = elevation_rad;
}

void SonarHead::advance(double duration_s) {
  const double most_rad = multibeam_.model().tilt_rate_rad_s * duration_s;
  const double left_rad = aimed_rad_ - elevation_rad_;
  elevation_rad_ = std::abs(left_rad) <= most_rad ? aimed_rad_ : elevation_rad_ + std::copysign(most_rad, left_rad);
}

Pose SonarHead::body_from_sonar() const {
  // A positive rotation about +y points the nose down, a positive elevation points it up.
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-elevation_rad_, Eigen::Vector3d::UnitY()));
  return body_from_mount_ * Pose{Eigen::Vector3d::Zero(), tilt};
}

void SonarHead::exchange_state(StateArchive& archive) {
  double elevation_rad = elevation_rad_, aimed_rad = aimed_rad_;
  archive(elevation_rad);
  archive(aimed_rad);
  aim(elevation_rad);  // validates it
  elevation_rad_ = elevation_rad;
  aim(aimed_rad);
}

void SonarHead::ping(const RayScene& scene, const Water& water, const Pose& world_from_body,
                     const PingRows& rows) const {
  multibeam_.ping(scene, water, world_from_body * body_from_sonar(), rows);
}

MultibeamPing SonarHead::ping(const RayScene& scene, const Water& water, const Pose& world_from_body) const {
  return multibeam_.ping(scene, water, world_from_body * body_from_sonar());
}

AcousticPing SonarHead::acoustic_ping(const RayScene& scene, const BodyState& body, std::uint64_t tick, int threads,
                                      const PingRequest& request) const {
  require(in_physics_mode(), "sonar.mode", "geometry", "must be physics");
  if (!multibeam_.is_on()) return AcousticPing::silent(multibeam_.beams());
  const Pose mounting = body_from_sonar();
  const Eigen::Vector3d rate_body = body.angular_body_rad_s();
  const Eigen::Vector3d velocity_body = body.linear_body_m_s() + rate_body.cross(mounting.position_m);
  const HeadMotion motion{body.world_from_body.direction(velocity_body), body.world_from_body.direction(rate_body)};
  return acoustics_->ping(scene, body.world_from_body * mounting, motion, tick, threads, request);
}

}  // namespace uwsim
