#include "uwsim/sonar/imaging/surface_echo.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "uwsim/sonar/imaging/imaging_kernels.h"

namespace uwsim {
namespace {

/// The frames of packets in which each arc has as many successive lanes as the others. Lanes that are left over repeat
/// the last arc.
ArcFrames frames_of(std::span<const RayArc> arcs, std::size_t rays_each) {
  ArcFrames frames;
  for (std::size_t lane = 0; lane < kPacketRays; ++lane) {
    const RayArc& arc = arcs[std::min(lane / rays_each, arcs.size() - 1)];
    for (int axis = 0; axis < 3; ++axis) {
      frames.ahead[axis][lane] = static_cast<float>(arc.ahead_world[axis]);
      frames.up[axis][lane] = static_cast<float>(arc.up_world[axis]);
      frames.aside[axis][lane] = static_cast<float>(arc.aside_world[axis]);
    }
    frames.cos_aside[lane] = static_cast<float>(std::cos(arc.aside_rad));
    frames.sin_aside[lane] = static_cast<float>(std::sin(arc.aside_rad));
    frames.tan_half_width[lane] = static_cast<float>(std::tan(arc.half_width_rad));
  }
  return frames;
}

}  // namespace

Eigen::Vector3d RayArc::direction(double angle_rad) const {
  const Eigen::Vector3d in_plane = std::cos(angle_rad) * ahead_world + std::sin(angle_rad) * up_world;
  return std::cos(aside_rad) * in_plane + std::sin(aside_rad) * aside_world;
}

std::vector<ArcRay> arc_rays(std::span<const double> angles_rad) {
  std::vector<ArcRay> rays;
  rays.reserve(angles_rad.size());
  const std::size_t n = angles_rad.size();
  for (std::size_t k = 0; k < n; ++k) {
    const double down = k > 0 ? angles_rad[k] - angles_rad[k - 1] : angles_rad[1] - angles_rad[0];
    const double up = k + 1 < n ? angles_rad[k + 1] - angles_rad[k] : down;
    const double lower_rad = angles_rad[k] - down / 2, upper_rad = angles_rad[k] + up / 2;
    rays.push_back({angles_rad[k], lower_rad, upper_rad, 1, angles_rad[k], lower_rad, upper_rad});
  }
  return rays;
}

std::span<double> EchoesByLabel::of(Label label) {
  for (Surface& surface : surfaces_) {
    if (surface.label == label) return surface.profile;
  }
  surfaces_.push_back({label, std::vector<double>(bins_, 0.0)});
  return surfaces_.back().profile;
}

void EchoesByLabel::add(double weight, const EchoesByLabel& other) {
  for (const Surface& surface : other.surfaces_) {
    const std::span<double> profile = of(surface.label);
    for (std::size_t bin = 0; bin < bins_; ++bin) profile[bin] += weight * surface.profile[bin];
  }
}

Label EchoesByLabel::strongest(std::size_t bin, double least) const {
  Label label = kNothing;
  for (const Surface& surface : surfaces_) {
    if (surface.profile[bin] <= least) continue;
    label = surface.label;
    least = surface.profile[bin];
  }
  return label;
}

void SurfaceEchoes::spread(double power, double near_bin, double far_bin, std::span<double> profile) {
  imaging_kernels().spread(&power, &near_bin, &far_bin, 1, profile.size(), profile.data());
}

SurfaceEchoes::SurfaceEchoes(const RayScene& scene, const Eigen::Vector3d& head_world_m,
                             const ImagingAcoustics& acoustics, double absorption_db_m)
    : scene_(&scene),
      head_world_m_(head_world_m),
      range_max_m_(acoustics.range_max_m),
      bin_m_(acoustics.bin_m()),
      absorption_db_m_(absorption_db_m),
      solid_(std::pow(10.0, acoustics.solid_strength_db / 10)),
      acoustics_(&acoustics) {
  const std::size_t labels = std::max<std::size_t>(acoustics.strengths_db.size(), kTerrain + 1);
  for (std::size_t label = 0; label < labels; ++label) {
    strengths_.push_back(acoustics.strength(static_cast<Label>(label)));
  }
  const std::vector<BottomMaterial>& materials = acoustics.materials;
  if (materials.size() > kTerrain && materials[kTerrain].ripples_rad)
    ripples_.emplace(*materials[kTerrain].ripples_rad);
  if (std::none_of(materials.begin(), materials.end(), [](const BottomMaterial& m) { return m.seabed != nullptr; })) {
    return;
  }
  constexpr double kSpeed_m_s = 1500;  // nominal: it hardly matters to backscatter
  for (const BottomMaterial& material : materials) curves_.emplace_back(material, acoustics.frequency_hz, kSpeed_m_s);
}

double SurfaceEchoes::scattered(Label label, double cosine) const {
  if (label < curves_.size() && acoustics_->materials[label].seabed) {
    return double{curves_[label](static_cast<float>(std::clamp(cosine, 1e-3, 1.0)))};
  }
  return (label < strengths_.size() ? strengths_[label] : solid_) * cosine * cosine;
}

double SurfaceEchoes::reflected(Label label, double cosine) const {
  if (curves_.empty()) return (label < strengths_.size() ? strengths_[label] : solid_) * cosine;
  const double facing = std::max(cosine, 1e-3);
  return scattered(label, facing) / facing;
}

ArcRaySets::ArcRaySets(std::vector<std::vector<ArcRay>> sets) : sets_(std::move(sets)), stride_(rays() + kPacketRays) {
  turns_.reserve(sets_.size() * kRows * stride_);
  for (const std::vector<ArcRay>& set : sets_) {
    for (const ArcTurn ArcRay::*turn : {&ArcRay::middle, &ArcRay::lower, &ArcRay::upper}) {
      for (const float ArcTurn::*part : {&ArcTurn::cosine, &ArcTurn::sine}) {
        for (const ArcRay& ray : set) turns_.push_back(ray.*turn.*part);
        turns_.resize(turns_.size() + kPacketRays, set.empty() ? 0.0f : turns_.back());
      }
    }
  }
}

/// The angles of a packet in which each arc has the rays from `first` on in successive lanes.
template <std::size_t kArcs>
class PacketAngles {
 public:
  PacketAngles(const ArcRaySets& rays, std::size_t first) {
    constexpr std::size_t kEach = kPacketRays / kArcs;
    for (std::size_t row = 0; row < ArcRaySets::kRows; ++row) {
      for (std::size_t arc = 0; arc < kArcs; ++arc) {
        std::copy_n(rays.turns(arc, row, first), kEach, values_[row] + arc * kEach);
      }
    }
  }
  ArcAngles angles() const { return {values_[0], values_[1], values_[2], values_[3], values_[4], values_[5]}; }

 private:
  alignas(64) float values_[ArcRaySets::kRows][kPacketRays];
};

void SurfaceEchoes::add(const RayArc& arc, std::span<const ArcRay> rays, std::span<double> profile,
                        EchoesByLabel* by_label) const {
  const ArcRaySets one({std::vector<ArcRay>(rays.begin(), rays.end())});
  add({&arc, 1}, one, profile, {by_label, by_label != nullptr ? 1u : 0u});
}

void SurfaceEchoes::add(std::span<const RayArc> arcs, const ArcRaySets& rays, std::span<double> profiles,
                        std::span<EchoesByLabel> by_label) const {
  if (head_world_m_.z() > 0 || rays.rays() == 0 || arcs.empty()) return;
  const std::size_t bins = profiles.size() / arcs.size();
  for (std::size_t first = 0; first < arcs.size(); first += kArcsTogether) {
    const std::size_t count = std::min(kArcsTogether, arcs.size() - first);
    const std::span<double> some = profiles.subspan(first * bins, count * bins);
    const std::span<EchoesByLabel> labelled = by_label.empty() ? by_label : by_label.subspan(first, count);
    if (count == 1) {
      add_packets<1>(arcs.subspan(first, count), rays, some, labelled);
    } else {
      add_packets<kArcsTogether>(arcs.subspan(first, count), rays, some, labelled);
    }
  }
  if (!acoustics_->multipath) return;
  for (std::size_t k = 0; k < arcs.size(); ++k) {
    add_ghosts(arcs[k], rays.of_arc(k), profiles.subspan(k * bins, bins));
  }
}

template <std::size_t kArcs>
void SurfaceEchoes::add_packets(std::span<const RayArc> arcs, const ArcRaySets& rays, std::span<double> profiles,
                                std::span<EchoesByLabel> by_label) const {
  constexpr std::size_t kEach = kPacketRays / kArcs;
  static const ImagingKernels& kernels = imaging_kernels();
  const std::size_t bins = profiles.size() / arcs.size();
  const ArcFrames frames = frames_of(arcs, kEach);
  const PatchRule rule{static_cast<float>(head_world_m_.z()), static_cast<float>(absorption_db_m_),
                       static_cast<float>(bin_m_)};
  RayPacket packet;
  HitPacket hits;
  packet.origin_x.fill(0), packet.origin_y.fill(0), packet.origin_z.fill(0);
  packet.near_m.fill(0);
  // The patch of a ray that hits just beyond the last bin may begin within that bin.
  packet.far_m.fill(static_cast<float>(range_max_m_) * kPatchStretch);
  alignas(64) float near_bin[kPacketRays], far_bin[kPacketRays], cosine[kPacketRays], loss[kPacketRays];
  alignas(64) double power[kPacketRays], near[kPacketRays], far[kPacketRays];
  for (std::size_t first = 0; first < rays.rays(); first += kEach) {
    const std::size_t count = std::min(kEach, rays.rays() - first);
    const PacketAngles<kArcs> packed(rays, first);
    kernels.directions(frames, packed.angles(), packet.direction_x.data(), packet.direction_y.data(),
                       packet.direction_z.data());
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      packet.active[k] = k % kEach < count && k / kEach < arcs.size() ? -1 : 0;
    }
    scene_->cast(head_world_m_, packet, hits, RayOrder::kCoherent);
    kernels.patches(frames, packed.angles(),
                    {hits.distance_m.data(), hits.normal_x.data(), hits.normal_y.data(), hits.normal_z.data()}, rule,
                    {near_bin, far_bin, cosine, loss});
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const double facing = double{cosine[k]};
      power[k] = 0;
      near[k] = double{near_bin[k]}, far[k] = double{far_bin[k]};
      if (!(facing > 0) || packet.active[k] == 0) continue;
      const double received = rays.of_arc(k / kEach)[first + k % kEach].gain_sr * double{loss[k]};
      power[k] = received * reflected(static_cast<Label>(hits.label[k]), facing);
      if (!ripples_ || hits.label[k] != kTerrain) continue;
      const Eigen::Vector3d way(packet.direction_x[k], packet.direction_y[k], packet.direction_z[k]);
      const ArcRay& ray = rays.of_arc(k / kEach)[first + k % kEach];
      const double length_m = double{hits.distance_m[k]}, least = std::max(facing, 1e-3);
      const auto [one, other] = ripples_->facets({head_world_m_ + length_m * way,
                                                  {hits.normal_x[k], hits.normal_y[k], hits.normal_z[k]},
                                                  way,
                                                  (ray.upper_rad - ray.lower_rad) * length_m / least,
                                                  2 * arcs[k / kEach].half_width_rad * length_m});
      power[k] = received * 0.5 * (scattered(kTerrain, one) + scattered(kTerrain, other)) / least;
    }
    for (std::size_t arc = 0; arc < arcs.size(); ++arc) {
      const std::size_t lane = arc * kEach;
      kernels.spread(power + lane, near + lane, far + lane, count, bins, profiles.data() + arc * bins);
    }
    if (by_label.empty()) continue;
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      if (!(power[k] > 0)) continue;
      spread(power[k], near[k], far[k], by_label[k / kEach].of(static_cast<Label>(hits.label[k])));
    }
  }
}

}  // namespace uwsim
