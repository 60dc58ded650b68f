#include "uwsim/sonar/acoustic_multibeam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"
#include "uwsim/core/with_unit.h"
#include "uwsim/sonar/acoustic_transmission.h"
#include "uwsim/sonar/beam_kernels.h"
#include "uwsim/sonar/bent_cast.h"
#include "uwsim/sonar/water_sound.h"

namespace uwsim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
// Rotation of the fan during a ping; less than this is below a hundredth of a beam width
constexpr double kMinTurn_rad = 1e-5;
constexpr std::size_t kRaysWorthThread = 1024;          // take some 0.3 ms, several times as long as waking a thread
constexpr std::size_t kCastTogether = 8 * kPacketRays;  // bent rays, whose hits fit into the nearest cache
constexpr float kMinRange_m = 0.01f;                    // echoes from shorter ranges are no louder than at this range

double length_of(double x, double y) { return std::sqrt(x * x + y * y); }

float ratio(double level_db) { return static_cast<float>(std::pow(10, level_db / 10)); }

void check(const BottomMaterial& bottom, const std::string& path) {
  require(bottom.strength_db >= -100 && bottom.strength_db <= 30, path + ".strength_db",
          with_unit(bottom.strength_db, "dB"), "must be in [-100, 30] dB");
  require(bottom.relief >= 0 && bottom.relief <= 2, path + ".relief", bottom.relief, "must be in [0, 2]");
}

}  // namespace

AcousticPing AcousticPing::silent(std::size_t beams) {
  return {std::vector<float>(beams, kInfinity),
          std::vector<float>(3 * beams, kNone),
          std::vector<float>(beams, kNone),
          std::vector<float>(beams, -kInfinity),
          std::vector<float>(beams, -kInfinity),
          std::vector<float>(beams, kInfinity),
          std::vector<float>(beams, kInfinity),
          std::vector<float>(beams, kInfinity),
          std::vector<float>(beams, kInfinity),
          std::vector<Label>(beams, kNothing),
          std::vector<std::uint8_t>(beams, 0),
          std::vector<std::uint8_t>(beams, 0),
          std::vector<float>()};
}

void AcousticSpec::check() const {
  parameters.check();
  require(acidity_ph >= 6 && acidity_ph <= 9, "sonar.acidity_ph", acidity_ph, "must be in [6, 9]");
  uwsim::check(bottom, "sonar.bottom");
  for (std::size_t k = 0; k < materials.size(); ++k) {
    uwsim::check(materials[k], "sonar.materials[" + std::to_string(k) + "]");
  }
  if (volume_strength_db) {
    require(*volume_strength_db >= -200 && *volume_strength_db <= 0, "sonar.volume_strength_db",
            with_unit(*volume_strength_db, "dB"), "must be in [-200, 0] dB");
  }
  for (std::size_t k = 0; k < targets.size(); ++k) targets[k].check("sonar.targets[" + std::to_string(k) + "]");
}

AcousticMultibeam::AcousticMultibeam(const MultibeamModel& fan, const AcousticSpec& spec, const Water& water,
                                     double bottom_m, const RandomStream& stream)
    : fan_(fan),
      spec_((spec.check(), spec)),
      stream_(stream),
      footprint_(fan, spec.parameters.beam_width_across_rad, spec.parameters.beam_width_along_rad, spec.rays_per_beam),
      profile_(sound_speed_profile(water)),
      absorption_(absorption_column(water, spec.parameters.frequency_hz, spec.acidity_ph, bottom_m)),
      volume_strength_(spec.volume_strength_db ? std::pow(10, *spec.volume_strength_db / 10) : 0),
      lossless_snr_db_(spec.parameters.lossless_snr_db() - fan.gain_db),
      detector_(spec.parameters, spec.range_noise),
      speckle_(stream.key(), spec.parameters),
      share_sr_(static_cast<float>(spec.parameters.beam_solid_angle_sr() / spec.rays_per_beam)),
      width_rad_(
          static_cast<float>(std::sqrt(spec.parameters.beam_width_along_rad * spec.parameters.beam_width_across_rad))) {
  const double speed_m_s = profile_.at(bottom_m);
  const auto add = [&](const BottomMaterial& material) {
    strengths_.push_back(ratio(material.strength_db));
    reliefs_.push_back(static_cast<float>(material.relief));
    curves_.emplace_back(material, spec.parameters.frequency_hz, speed_m_s);
    if (spec.multipath) mirrors_.push_back(mirror(material.fluid));
    by_angle_ = by_angle_ || material.seabed;
  };
  for (const BottomMaterial& material : spec.materials) add(material);
  add(spec.bottom);
  for (const WaterTargets& group : spec.targets) targets_.emplace_back(group, stream.key());
  if (spec.materials.size() > kTerrain && spec.materials[kTerrain].ripples_rad) {
    ripples_.emplace(*spec.materials[kTerrain].ripples_rad);
  }
}

void AcousticMultibeam::set_facets(const BedPatch& bed, std::size_t lane, HitLanes& hits) const {
  const float spacing_rad = footprint_.spacing_rad(hits.beam[lane]);
  BedPatch patch = bed;
  patch.across_m = double{hits.length_m[lane]} * double{spacing_rad > 0 ? spacing_rad : width_rad_};
  patch.along_m = patch.across_m / std::max(double{hits.cosine[lane]}, 1e-3);
  const std::array<double, 2> facets = ripples_->facets(patch);
  hits.facets[lane] = {static_cast<float>(facets[0]), static_cast<float>(facets[1])};
}

void AcousticMultibeam::set_echoes(const Transmission& sent, const HitLanes& hits, std::span<RayEcho> echoes) const {
  constexpr float kTwoWay = -0.2f * std::numbers::ln10_v<float>;
  using Lanes = std::array<float, kPacketRays>;
  alignas(64) Lanes length, cosine, gain, lost, spacing, relief, energy, width, point;
  length.fill(1), cosine.fill(1), gain.fill(0), lost.fill(0), spacing.fill(0), relief.fill(0);
  for (std::size_t k = 0; k < echoes.size(); ++k) {
    if (!hits.met[k]) continue;
    const std::size_t beam = hits.beam[k], material = std::min<std::size_t>(hits.label[k], strengths_.size() - 1);
    length[k] = std::max(hits.length_m[k], kMinRange_m);
    cosine[k] = std::clamp(hits.cosine[k], 1e-3f, 1.0f);
    const float share = share_sr_ * footprint_.widening(beam);
    gain[k] = by_angle_ ? share * curves_[material](cosine[k]) / cosine[k] : share * strengths_[material] * cosine[k];
    if (ripples_ && hits.label[k] == kTerrain) {
      const auto [first, second] = hits.facets[k];
      gain[k] = share * 0.5f * (curves_[material](first) + curves_[material](second)) / cosine[k];
    }
    const double absorption_db_m = absorption_.mean_db_m(sent.depth_m, sent.absorbed_db, hits.depth_m[k]);
    lost[k] = std::exp(kTwoWay * static_cast<float>(absorption_db_m) * length[k]);
    spacing[k] = footprint_.spacing_rad(beam);
    relief[k] = reliefs_[material] * length[k] * width_rad_ * footprint_.root_widening(beam);
  }
  static const BeamKernels& kernels = beam_kernels();
  kernels.patches({length.data(), cosine.data(), gain.data(), lost.data(), spacing.data(), relief.data(), sent.cell_m},
                  {energy.data(), width.data(), point.data()});
  for (std::size_t k = 0; k < echoes.size(); ++k) {
    if (!hits.met[k]) {
      echoes[k].energy = 0;
      continue;
    }
    echoes[k] = {hits.range_m[k], energy[k], width[k], cosine[k], static_cast<Label>(hits.label[k]), 0, point[k]};
  }
}

void AcousticMultibeam::cast_straight(const Transmission& sent, const FanRays& rays, std::span<RayEcho> echoes) const {
  const Eigen::Matrix3Xf& directions_world = rays.directions_world;
  const Eigen::Vector3d& head = sent.world_from_sonar.position_m;
  const auto farthest = static_cast<float>(fan_.range_max_m);
  RayPacket packet;
  HitPacket met;
  HitLanes hits;
  packet.origin_x.fill(0);
  packet.origin_y.fill(0);
  packet.origin_z.fill(0);
  packet.near_m.fill(0);
  packet.far_m.fill(farthest);
  const bool moves = !sent.mach.isZero(0);
  static const BeamKernels& kernels = beam_kernels();
  for (std::size_t first = 0; first < echoes.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, echoes.size() - first);
    for (std::size_t lane = 0; lane < kPacketRays; ++lane) {
      const float* const direction = directions_world.data() + 3 * (first + std::min(lane, count - 1));
      packet.direction_x[lane] = direction[0];
      packet.direction_y[lane] = direction[1];
      packet.direction_z[lane] = direction[2];
      packet.active[lane] = lane < count ? -1 : 0;
    }
    sent.scene.cast(head, packet, met, RayOrder::kCoherent);
    kernels.incidence({met.normal_x.data(), met.normal_y.data(), met.normal_z.data(), packet.direction_x.data(),
                       packet.direction_y.data(), packet.direction_z.data()},
                      hits.cosine.data());
    for (std::size_t lane = 0; lane < count; ++lane) {
      const float length_m = met.distance_m[lane];
      const double z = head.z() + double{length_m} * packet.direction_z[lane];
      hits.met[lane] = length_m < farthest && !(z > 0);
      hits.length_m[lane] = hits.range_m[lane] = length_m;
      hits.depth_m[lane] = -z;
      hits.label[lane] = met.label[lane];
      hits.beam[lane] = rays.beam(first + lane);
      const Eigen::Vector3f direction(packet.direction_x[lane], packet.direction_y[lane], packet.direction_z[lane]);
      if (ripples_ && hits.met[lane] && hits.label[lane] == kTerrain) {
        const Eigen::Vector3d way = direction.cast<double>();
        const Eigen::Vector3f normal(met.normal_x[lane], met.normal_y[lane], met.normal_z[lane]);
        set_facets({head + double{length_m} * way, normal.cast<double>(), way}, lane, hits);
      }
      if (!moves) continue;
      // Half the path from the head to the bottom and back to the head's new position, relative to the path out.
      hits.range_m[lane] = 0.5f * (1 + (direction - 2 * sent.mach).norm()) * length_m;
    }
    set_echoes(sent, hits, echoes.subspan(first, count));
  }
}

void AcousticMultibeam::cast_bent_rays(const Transmission& sent, const FanRays& rays, std::span<RayEcho> echoes) const {
  const Eigen::Vector3d& head = sent.world_from_sonar.position_m;
  const double time_max_s = fan_.range_max_m / sent.sound_speed_m_s;
  std::array<Eigen::Vector3d, kCastTogether> directions;
  std::array<SoundHit, kCastTogether> paths;
  HitLanes hits;
  for (std::size_t first = 0; first < echoes.size(); first += kPacketRays) {
    const std::size_t count = std::min(kPacketRays, echoes.size() - first), place = first % kCastTogether;
    if (place == 0) {
      const std::size_t together = std::min(kCastTogether, echoes.size() - first);
      for (std::size_t k = 0; k < together; ++k) {
        directions[k] = rays.directions_world.col(static_cast<Eigen::Index>(first + k)).cast<double>().normalized();
      }
      cast_bent(sent.scene, profile_, head, std::span(directions).first(together), time_max_s,
                std::span(paths).first(together));
    }
    for (std::size_t lane = 0; lane < count; ++lane) {
      const SoundHit& path = paths[place + lane];
      hits.met[lane] = path.label != kNothing;
      if (!hits.met[lane]) continue;
      const Eigen::Vector3d normal = path.normal_world.cast<double>();
      const double half = 0.5 * (1 + (directions[place + lane] - 2 * sent.mach.cast<double>()).norm());
      hits.length_m[lane] = static_cast<float>(path.length_m);
      hits.range_m[lane] = static_cast<float>(half * sent.sound_speed_m_s * path.time_s);
      hits.cosine[lane] = static_cast<float>(std::abs(normal.dot(path.arrival_world)) / normal.norm());
      hits.depth_m[lane] = -path.point_world_m.z();
      hits.label[lane] = path.label;
      hits.beam[lane] = rays.beam(first + lane);
      if (ripples_ && path.label == kTerrain) set_facets({path.point_world_m, normal, path.arrival_world}, lane, hits);
    }
    set_echoes(sent, hits, echoes.subspan(first, count));
  }
}

AcousticPing AcousticMultibeam::ping(const RayScene& scene, const Pose& world_from_sonar, const HeadMotion& motion,
                                     std::uint64_t tick, int threads, const PingRequest& request) const {
  const auto beams = static_cast<std::size_t>(fan_.beams);
  AcousticPing ping = AcousticPing::silent(beams);
  const Eigen::Vector3d& head = world_from_sonar.position_m;
  if (!(head.z() <= 0) || scene.under_ground(head)) return ping;
  const double c = profile_.at(-head.z());
  const double cells = std::ceil(fan_.range_max_m / spec_.parameters.range_cell_m(c));
  const double cells_per_sample = std::ceil(cells / static_cast<double>(kSamplesMax));
  const Transmission sent{
      scene,
      world_from_sonar,
      world_from_sonar.rotation().cast<float>(),
      (motion.velocity_world_m_s / c).cast<float>(),
      motion.rate_world_rad_s.dot(world_from_sonar.direction(Eigen::Vector3d::UnitZ())),
      -head.z(),
      absorption_.down_to_db(-head.z()),
      c,
      static_cast<float>(spec_.parameters.range_cell_m(c)),
      spec_.false_detections ? detector_.false_alarm(fan_.range_max_m, spec_.parameters.range_cell_m(c)) : 0,
      speckle_.view(world_from_sonar),
      tick,
      request.water_column ? static_cast<std::size_t>(std::ceil(cells / cells_per_sample)) : 0};
  ping.water_column_db.resize(beams * sent.samples);
  ping.water_column_sample_m = cells_per_sample * spec_.parameters.range_cell_m(c);
  OtherEchoes others(targets_.empty() && !spec_.multipath ? 0 : beams);
  add_targets(sent, request.time_s, others);
  const auto rays = static_cast<std::size_t>(footprint_.rays());
  const auto work = [&](std::size_t first, std::size_t last) {
    ping_beams(sent, first / rays, last / rays, others, ping);
  };
  parallel_ranges(beams * rays, threads, work, kRaysWorthThread);
  return ping;
}

void AcousticMultibeam::ping_beams(const Transmission& sent, std::size_t first, std::size_t last, OtherEchoes& others,
                                   AcousticPing& ping) const {
  const auto rays = static_cast<std::size_t>(footprint_.rays());
  std::vector<RayEcho> echoes((last - first) * rays);
  const FanRays fan_rays{ray_directions_world(sent, first, last), first, 1 / static_cast<float>(rays)};
  if (spec_.bending) {
    cast_bent_rays(sent, fan_rays, echoes);
  } else {
    cast_straight(sent, fan_rays, echoes);
  }
  if (spec_.multipath) add_ghosts(sent, first, last, others);
  for (std::size_t beam = first; beam < last; ++beam) {
    const std::span<RayEcho> all(echoes.data() + (beam - first) * rays, rays);
    for (std::size_t ray = 0; ray < rays; ++ray) all[ray].ray = static_cast<std::uint16_t>(ray);
    const auto silent = std::partition(all.begin(), all.end(), [](const RayEcho& e) { return e.energy > 0; });
    const std::span<RayEcho> surface(all.begin(), silent);
    BeamEcho echo = beam_echo(surface, sent.cell_m);
    const std::span<RayEcho> other = others.empty() ? std::span<RayEcho>() : std::span<RayEcho>(others[beam]);
    std::vector<RayEcho> loudest(other.begin(), other.end());
    if (!loudest.empty()) {
      if (loudest.size() > kRaysMax) {  // more than the detector takes: it gets the strongest
        std::sort(loudest.begin(), loudest.end(), [](const RayEcho& a, const RayEcho& b) {
          return a.energy != b.energy ? a.energy > b.energy : a.range_m < b.range_m;
        });
        loudest.resize(kRaysMax);
      }
      BeamEcho louder = beam_echo(loudest, sent.cell_m);
      louder.of_surface = false;
      if (louder.peak > echo.peak) echo = louder;
    }
    record(sent, beam, echo, detect(sent, beam, echo), ping);
    if (sent.samples > 0) record_water_column(sent, beam, surface, other, ping);
  }
}

/// The directions of the rays at reception. A rotating fan has turned by then, by an angle that depends on each beam's
/// travel time.
Eigen::Matrix3Xf AcousticMultibeam::ray_directions_world(const Transmission& sent, std::size_t first,
                                                         std::size_t last) const {
  const auto begin = static_cast<Eigen::Index>(first), beams = static_cast<Eigen::Index>(last - first);
  const auto per_beam = static_cast<Eigen::Index>(footprint_.rays());
  Eigen::Matrix3Xf directions(3, beams * per_beam);
  const double longest_s = 2 * fan_.range_max_m / sent.sound_speed_m_s;
  if (std::abs(sent.turn_rad_s) * longest_s < kMinTurn_rad) {
    directions.noalias() = sent.rotation * footprint_.directions().middleCols(begin * per_beam, beams * per_beam);
    return directions;
  }
  // A ray along each beam's axis yields the travel time, and thus the rotation.
  const FanRays axes{sent.rotation * footprint_.axes().middleCols(begin, beams), first, 1.0f};
  std::vector<RayEcho> ahead(last - first);
  cast_straight(sent, axes, ahead);
  for (Eigen::Index beam = 0; beam < beams; ++beam) {
    const RayEcho& echo = ahead[static_cast<std::size_t>(beam)];
    const double travel_s = echo.energy > 0 ? 2 * echo.range_m / sent.sound_speed_m_s : longest_s;
    const Eigen::AngleAxisf turn(static_cast<float>(sent.turn_rad_s * travel_s), Eigen::Vector3f::UnitZ());
    directions.middleCols(beam * per_beam, per_beam).noalias() =
        (sent.rotation * turn.toRotationMatrix()) *
        footprint_.directions().middleCols((begin + beam) * per_beam, per_beam);
  }
  return directions;
}

BottomDetection AcousticMultibeam::detect(const Transmission& sent, std::size_t beam, const BeamEcho& echo) const {
  const auto index = static_cast<std::uint32_t>(2 * beam);
  BottomDetection found;
  if (echo.peak > 0) {
    const BeamRays rays = footprint_.beam(beam);
    const auto [speckle, speckle_range] = sent.speckle.draws(echo_footprint(echo.rays, rays.directions));
    const auto [noise, noise_range] = stream_.normals(sent.tick, index);
    found = detector_.bottom(echo, rays, sent.cell_m, {speckle, speckle_range, noise, noise_range},
                             background(sent, beam, echo.centre_range_m));
  }
  const double draw = sent.false_alarm > 0 ? stream_.uniform(sent.tick, index + 1) : 1;
  if (draw < sent.false_alarm) {
    const auto third = index + 1 + 2 * static_cast<std::uint32_t>(fan_.beams);
    const double range_m = fan_.range_max_m * stream_.uniform(sent.tick, third);
    const BottomDetection noise = detector_.noise(draw, sent.false_alarm, range_m, sent.cell_m);
    if (found.kind == Detection::kNone || noise.intensity > found.intensity) found = noise;
  }
  return found;
}

void AcousticMultibeam::record(const Transmission& sent, std::size_t beam, const BeamEcho& echo,
                               const BottomDetection& found, AcousticPing& ping) const {
  if (found.kind == Detection::kNone || !(found.range_m > 0 && found.range_m < fan_.range_max_m)) return;
  const auto range = static_cast<float>(found.range_m);
  ping.ranges_m[beam] = range;
  Eigen::Map<Eigen::Vector3f>(ping.points_sonar_m.data() + 3 * beam) =
      range * footprint_.axes().col(static_cast<Eigen::Index>(beam));
  ping.travel_time_s[beam] = static_cast<float>(2 * found.range_m / sent.sound_speed_m_s);
  const double snr_db = 10 * std::log10(found.intensity);
  const double level = found.intensity * background(sent, beam, found.range_m);
  ping.intensity_db[beam] = static_cast<float>(10 * std::log10(level) - lossless_snr_db_);
  ping.snr_db[beam] = static_cast<float>(snr_db);
  const double across_m = found.range_m * spec_.parameters.beam_width_along_rad / std::sqrt(12.0);
  const Eigen::Vector3f axis_world = sent.rotation * footprint_.axes().col(static_cast<Eigen::Index>(beam));
  ping.deviation_m[beam] = static_cast<float>(found.deviation_m);
  ping.vertical_deviation_m[beam] =
      static_cast<float>(length_of(found.deviation_m * axis_world.z(), across_m * sent.rotation(2, 2)));
  ping.horizontal_deviation_m[beam] = static_cast<float>(
      length_of(found.deviation_m * axis_world.head<2>().norm(), across_m * sent.rotation.col(2).head<2>().norm()));
  ping.valid[beam] = 1;
  ping.detections[beam] = static_cast<std::uint8_t>(found.kind);
  if (found.kind == Detection::kFalse || !echo.of_surface) return;
  ping.incidence_rad[beam] = std::acos(echo.cosine);
  ping.labels[beam] = echo.label;
}

}  // namespace uwsim
