#include "uwsim/sonar/multibeam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

#include "uwsim/acoustics/absorption.h"
#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"
#include "uwsim/sonar/beam_kernels.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim {
namespace {

constexpr std::size_t kPacketsAtOnce = 4;

/// Buffer for the results of a fan's last packet, which may be incomplete.
struct PacketEchoes {
  alignas(64) std::array<float, kPacketRays> range_m, incidence_rad, intensity_db;
  alignas(64) std::array<Label, kPacketRays> label;
  alignas(64) std::array<std::uint8_t, kPacketRays> valid;
  alignas(64) std::array<float, 3 * kPacketRays> point;
};

/// Casts several packets of a fan at a time and stores their echoes.
class FanCaster {
 public:
  FanCaster(const Pose& world_from_sonar, std::span<const float> strengths_db)
      : head_(world_from_sonar.position_m), rotation_(world_from_sonar.rotation()), strengths_db_(strengths_db) {
    for (ExactRays& rays : rays_) {
      rays.origin_x.fill(head_.x());
      rays.origin_y.fill(head_.y());
      rays.origin_z.fill(head_.z());
    }
  }

  void cast(const RayScene& scene, const EchoRule& rule, const double* cosines, const double* sines,
            std::size_t count) {
    const std::size_t packets = (count + kPacketRays - 1) / kPacketRays;
    for (std::size_t p = 0; p < packets; ++p) {
      ExactRays& rays = rays_[p];
      kernels_.directions(rotation_.col(0).data(), rotation_.col(1).data(), cosines + p * kPacketRays,
                          sines + p * kPacketRays, rays.direction_x.data(), rays.direction_y.data(),
                          rays.direction_z.data());
      kernels_.reach(head_.z(), rule.range_max_m, rays.direction_z.data(), rays.far_m.data());
      for (std::size_t k = 0; k < kPacketRays; ++k) rays.active[k] = p * kPacketRays + k < count ? -1 : 0;
    }
    scene.cast(std::span(rays_).first(packets), std::span(hits_).first(packets));
  }

  void store(const EchoRule& rule, const double* cosines, const double* sines, std::size_t count, const PingRows& rows,
             std::size_t first) {
    for (std::size_t done = 0; done < count; done += kPacketRays) {
      const ExactRays& rays = rays_[done / kPacketRays];
      const ExactHits& hits = hits_[done / kPacketRays];
      alignas(64) std::array<float, kPacketRays> strength_db;
      for (std::size_t k = 0; k < kPacketRays; ++k) {
        strength_db[k] = strengths_db_[std::min<std::size_t>(hits.label[k], strengths_db_.size() - 1)];
      }
      const BeamHits met{hits.distance_m.data(),  hits.normal_x.data(),    hits.normal_y.data(),
                         hits.normal_z.data(),    rays.direction_x.data(), rays.direction_y.data(),
                         rays.direction_z.data(), hits.label.data(),       strength_db.data()};
      const std::size_t at = first + done, full = std::min(kPacketRays, count - done);
      const BeamEchoes out{rows.ranges_m + at, rows.incidence_rad + at, rows.intensity_db + at, rows.labels + at,
                           rows.valid + at};
      if (full == kPacketRays) {
        kernels_.echoes(met, rule, out);
        kernels_.points(hits.distance_m.data(), cosines + done, sines + done, out.range_m,
                        rows.points_sonar_m + 3 * at);
      } else {
        store_incomplete(met, rule, full, out);
        kernels_.points(hits.distance_m.data(), cosines + done, sines + done, echoes_.range_m.data(),
                        echoes_.point.data());
        std::copy_n(echoes_.point.begin(), 3 * full, rows.points_sonar_m + 3 * at);
      }
    }
  }

 private:
  /// The kernel always writes sixteen beams, so it writes to a buffer from which the beams that exist are copied.
  void store_incomplete(const BeamHits& met, const EchoRule& rule, std::size_t count, const BeamEchoes& out) {
    kernels_.echoes(met, rule,
                    {echoes_.range_m.data(), echoes_.incidence_rad.data(), echoes_.intensity_db.data(),
                     echoes_.label.data(), echoes_.valid.data()});
    std::copy_n(echoes_.range_m.begin(), count, out.range_m);
    std::copy_n(echoes_.incidence_rad.begin(), count, out.incidence_rad);
    std::copy_n(echoes_.intensity_db.begin(), count, out.intensity_db);
    std::copy_n(echoes_.label.begin(), count, out.label);
    std::copy_n(echoes_.valid.begin(), count, out.valid);
  }

  Eigen::Vector3d head_;
  Eigen::Matrix3d rotation_;
  std::span<const float> strengths_db_;
  const BeamKernels& kernels_ = beam_kernels();
  std::array<ExactRays, kPacketsAtOnce> rays_;
  std::array<ExactHits, kPacketsAtOnce> hits_;
  PacketEchoes echoes_;
};

}  // namespace

PingRows PingRows::row(std::size_t ping, std::size_t beams) const {
  const std::size_t skip = ping * beams;
  return {ranges_m + skip, points_sonar_m + 3 * skip, incidence_rad + skip, intensity_db + skip, labels + skip,
          valid + skip};
}

Multibeam::Multibeam(const MultibeamModel& model, std::span<const double> strengths_db, bool on)
    : model_(model), on_(on) {
  for (std::size_t label = 0; label < strengths_db.size(); ++label) {
    const double strength_db = strengths_db[label];
    require(strength_db >= -100 && strength_db <= 30, "sonar.strengths_db[" + std::to_string(label) + "]",
            with_unit(strength_db, "dB"), "must be in [-100, 30] dB");
    strengths_db_.push_back(static_cast<float>(strength_db + model_.gain_db));
  }
  strengths_db_.push_back(static_cast<float>(kRockStrength_db + model_.gain_db));
  const auto beams = static_cast<std::size_t>(model_.beams);
  const std::size_t lanes = (beams + kPacketRays - 1) / kPacketRays * kPacketRays;
  for (std::size_t k = 0; k < lanes; ++k) {
    const double angle_rad = model_.angles().at(static_cast<int>(std::min(k, beams - 1)));
    if (k < beams) angles_rad_.push_back(static_cast<float>(angle_rad));
    cosines_.push_back(std::cos(angle_rad));
    sines_.push_back(std::sin(angle_rad));
  }
}

double Multibeam::ping_rate_max_hz(const Water& water, double head_z_m) const {
  return std::min(model_.ping_rate_max_hz, water.sound_speed_m_s(head_z_m) / (2 * model_.range_max_m));
}

MultibeamPing Multibeam::ping(const RayScene& scene, const Water& water, const Pose& world_from_sonar) const {
  const std::size_t n = beams();
  MultibeamPing result{std::vector<float>(n), std::vector<float>(3 * n), std::vector<float>(n),
                       std::vector<float>(n), std::vector<Label>(n),     std::vector<std::uint8_t>(n)};
  ping(scene, water, world_from_sonar,
       {result.ranges_m.data(), result.points_sonar_m.data(), result.incidence_rad.data(), result.intensity_db.data(),
        result.labels.data(), result.valid.data()});
  return result;
}

void Multibeam::ping(const RayScene& scene, const Water& water, const Pose& world_from_sonar,
                     const PingRows& rows) const {
  const Eigen::Vector3d& head = world_from_sonar.position_m;
  const bool no_echoes = !on_ || !(head.z() <= 0) || scene.under_ground(head);
  const EchoRule rule{head.z(), no_echoes ? 0 : model_.range_max_m,
                      absorption_db_km(model_.frequency_hz, water.temperature_deg_c(head.z()),
                                       water.salinity_at_psu(head.z()), std::max(0.0, Water::depth_m(head.z()))) /
                          1000};
  FanCaster caster(world_from_sonar, strengths_db_);
  for (std::size_t first = 0; first < beams(); first += kPacketsAtOnce * kPacketRays) {
    const std::size_t count = std::min(kPacketsAtOnce * kPacketRays, beams() - first);
    caster.cast(scene, rule, &cosines_[first], &sines_[first], count);
    caster.store(rule, &cosines_[first], &sines_[first], count, rows, first);
  }
}

}  // namespace uwsim
