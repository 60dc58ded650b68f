#include "uwsim/sonar/multibeam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "uwsim/acoustics/sea_water.h"
#include "uwsim/core/check.h"
#include "uwsim/sonar/beam_kernels.h"

namespace uwsim {
namespace {

constexpr double kBottomStrength_db = -30;

double sound_speed_at(const Water& water, double z_world_m) {
  const double given_m_s = water.given_sound_speed_m_s(z_world_m);
  return given_m_s > 0 ? given_m_s
                       : sound_speed_m_s(water.temperature_deg_c(z_world_m), water.salinity_at_psu(z_world_m),
                                         std::max(0.0, Water::depth_m(z_world_m)));
}

constexpr std::size_t kTogether = 4;  // packets

/// A fan's last packet's results before they go to their places: it need not be full.
struct PacketEchoes {
  alignas(64) std::array<float, kPacketRays> range_m, incidence_rad, intensity_db;
  alignas(64) std::array<Label, kPacketRays> label;
  alignas(64) std::array<std::uint8_t, kPacketRays> valid;
  alignas(64) std::array<float, 3 * kPacketRays> point;
};

/// Some packets of a fan on their way from the head and back.
class FanPart {
 public:
  explicit FanPart(const Pose& world_from_sonar)
      : head_(world_from_sonar.position_m), rotation_(world_from_sonar.rotation()) {
    for (ExactRays& rays : rays_) {
      rays.origin_x.fill(head_.x());
      rays.origin_y.fill(head_.y());
      rays.origin_z.fill(head_.z());
    }
  }

  void cast(const RayScene& scene, const EchoRule& rule, const double* ahead, const double* aside, std::size_t count) {
    const std::size_t packets = (count + kPacketRays - 1) / kPacketRays;
    for (std::size_t p = 0; p < packets; ++p) {
      ExactRays& rays = rays_[p];
      kernels_.directions(rotation_.col(0).data(), rotation_.col(1).data(), ahead + p * kPacketRays,
                          aside + p * kPacketRays, rays.direction_x.data(), rays.direction_y.data(),
                          rays.direction_z.data());
      kernels_.reach(head_.z(), rule.range_max_m, rays.direction_z.data(), rays.far_m.data());
      for (std::size_t k = 0; k < kPacketRays; ++k) rays.active[k] = p * kPacketRays + k < count ? -1 : 0;
    }
    scene.cast(std::span(rays_).first(packets), std::span(hits_).first(packets));
  }

  void store(const EchoRule& rule, const double* ahead, const double* aside, std::size_t count, const PingRows& rows,
             std::size_t first) {
    for (std::size_t done = 0; done < count; done += kPacketRays) {
      const ExactRays& rays = rays_[done / kPacketRays];
      const ExactHits& hits = hits_[done / kPacketRays];
      const BeamHits met{hits.distance_m.data(),  hits.normal_x.data(),    hits.normal_y.data(),
                         hits.normal_z.data(),    rays.direction_x.data(), rays.direction_y.data(),
                         rays.direction_z.data(), hits.label.data()};
      const std::size_t at = first + done, full = std::min(kPacketRays, count - done);
      const BeamEchoes places{rows.ranges_m + at, rows.incidence_rad + at, rows.intensity_db + at, rows.labels + at,
                              rows.valid + at};
      if (full == kPacketRays) {
        kernels_.echoes(met, rule, places);
        kernels_.points(hits.distance_m.data(), ahead + done, aside + done, places.range_m,
                        rows.points_sonar_m + 3 * at);
      } else {
        echo_some(met, rule, full, places);
        kernels_.points(hits.distance_m.data(), ahead + done, aside + done, echoes_.range_m.data(),
                        echoes_.point.data());
        std::copy_n(echoes_.point.begin(), 3 * full, rows.points_sonar_m + 3 * at);
      }
    }
  }

 private:
  /// The kernel writes sixteen; so by a place of our own to those that are there.
  void echo_some(const BeamHits& met, const EchoRule& rule, std::size_t count, const BeamEchoes& places) {
    kernels_.echoes(met, rule,
                    {echoes_.range_m.data(), echoes_.incidence_rad.data(), echoes_.intensity_db.data(),
                     echoes_.label.data(), echoes_.valid.data()});
    std::copy_n(echoes_.range_m.begin(), count, places.range_m);
    std::copy_n(echoes_.incidence_rad.begin(), count, places.incidence_rad);
    std::copy_n(echoes_.intensity_db.begin(), count, places.intensity_db);
    std::copy_n(echoes_.label.begin(), count, places.label);
    std::copy_n(echoes_.valid.begin(), count, places.valid);
  }

  Eigen::Vector3d head_;
  Eigen::Matrix3d rotation_;
  const BeamKernels& kernels_ = beam_kernels();
  std::array<ExactRays, kTogether> rays_;
  std::array<ExactHits, kTogether> hits_;
  PacketEchoes echoes_;
};

}  // namespace

PingRows PingRows::row(std::size_t ping, std::size_t beams) const {
  const std::size_t skip = ping * beams;
  return {ranges_m + skip, points_sonar_m + 3 * skip, incidence_rad + skip, intensity_db + skip, labels + skip,
          valid + skip};
}

Multibeam::Multibeam(const MultibeamModel& model, const Pose& body_from_mount)
    : model_(model), body_from_mount_(body_from_mount) {
  const auto beams = static_cast<std::size_t>(model_.beams);
  const std::size_t lanes = (beams + kPacketRays - 1) / kPacketRays * kPacketRays;
  for (std::size_t k = 0; k < lanes; ++k) {
    const double angle_rad = model_.angle_rad(static_cast<int>(std::min(k, beams - 1)));
    if (k < beams) angles_rad_.push_back(static_cast<float>(angle_rad));
    ahead_.push_back(std::cos(angle_rad));
    aside_.push_back(std::sin(angle_rad));
  }
}

void Multibeam::aim(double elevation_rad) {
  require(std::abs(elevation_rad) <= std::numbers::pi / 2, "sonar.elevation_rad", elevation_rad,
          "must be in [-pi/2, pi/2] rad");
  aimed_rad_ = elevation_rad;
}

void Multibeam::point(double elevation_rad) {
  aim(elevation_rad);
  elevation_rad_ = elevation_rad;
}

void Multibeam::advance(double duration_s) {
  const double most_rad = model_.tilt_rate_rad_s * duration_s;
  const double left_rad = aimed_rad_ - elevation_rad_;
  elevation_rad_ = std::abs(left_rad) <= most_rad ? aimed_rad_ : elevation_rad_ + std::copysign(most_rad, left_rad);
}

void Multibeam::exchange_state(StateArchive& archive) {
  double elevation_rad = elevation_rad_, aimed_rad = aimed_rad_;
  archive(elevation_rad);
  archive(aimed_rad);
  point(elevation_rad);
  aim(aimed_rad);
}

Pose Multibeam::body_from_sonar() const {
  // A turn about +y is nose down, so positive elevation turns the other way.
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(-elevation_rad_, Eigen::Vector3d::UnitY()));
  return body_from_mount_ * Pose{Eigen::Vector3d::Zero(), tilt};
}

double Multibeam::ping_rate_max_hz(const Water& water, double head_z_m) const {
  return std::min(model_.ping_rate_max_hz, sound_speed_at(water, head_z_m) / (2 * model_.range_max_m));
}

MultibeamPing Multibeam::ping(const RayScene& scene, const Water& water, const Pose& world_from_body) const {
  const std::size_t n = beams();
  MultibeamPing result{std::vector<float>(n), std::vector<float>(3 * n), std::vector<float>(n),
                       std::vector<float>(n), std::vector<Label>(n),     std::vector<std::uint8_t>(n)};
  ping(scene, water, world_from_body,
       {result.ranges_m.data(), result.points_sonar_m.data(), result.incidence_rad.data(), result.intensity_db.data(),
        result.labels.data(), result.valid.data()});
  return result;
}

void Multibeam::ping(const RayScene& scene, const Water& water, const Pose& world_from_body,
                     const PingRows& rows) const {
  const Pose world_from_sonar = world_from_body * body_from_sonar();
  const Eigen::Vector3d& head = world_from_sonar.position_m;
  const bool deaf = !(head.z() <= 0) || scene.under_ground(head);
  const EchoRule rule{head.z(), deaf ? 0 : model_.range_max_m, kBottomStrength_db,
                      absorption_db_km(model_.frequency_hz, water.temperature_deg_c(head.z()),
                                       water.salinity_at_psu(head.z()), std::max(0.0, Water::depth_m(head.z()))) /
                          1000};
  FanPart part(world_from_sonar);
  for (std::size_t first = 0; first < beams(); first += kTogether * kPacketRays) {
    const std::size_t count = std::min(kTogether * kPacketRays, beams() - first);
    part.cast(scene, rule, &ahead_[first], &aside_[first], count);
    part.store(rule, &ahead_[first], &aside_[first], count, rows, first);
  }
}

}  // namespace uwsim
