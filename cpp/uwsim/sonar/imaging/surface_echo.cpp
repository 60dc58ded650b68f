#include "uwsim/sonar/imaging/surface_echo.h"

#include <algorithm>
#include <cmath>

#include "uwsim/sonar/imaging/imaging_kernels.h"

namespace uwsim {
namespace {

/// Sixteen rays of an arc, in float.
struct ArcPacket {
  alignas(64) float cosine[kPacketRays], sine[kPacketRays];
  alignas(64) float lower_cosine[kPacketRays], lower_sine[kPacketRays];
  alignas(64) float upper_cosine[kPacketRays], upper_sine[kPacketRays];

  /// The last ray fills the lanes that are left over.
  explicit ArcPacket(std::span<const ArcRay> rays) {
    for (std::size_t k = 0; k < kPacketRays; ++k) {
      const ArcRay& ray = rays[std::min(k, rays.size() - 1)];
      cosine[k] = ray.middle.cosine, sine[k] = ray.middle.sine;
      lower_cosine[k] = ray.lower.cosine, lower_sine[k] = ray.lower.sine;
      upper_cosine[k] = ray.upper.cosine, upper_sine[k] = ray.upper.sine;
    }
  }

  ArcAngles angles() const { return {cosine, sine, lower_cosine, lower_sine, upper_cosine, upper_sine}; }
};

ArcFrame frame_of(const RayArc& arc) {
  ArcFrame frame;
  Eigen::Vector3f::Map(frame.ahead) = arc.ahead_world.cast<float>();
  Eigen::Vector3f::Map(frame.up) = arc.up_world.cast<float>();
  Eigen::Vector3f::Map(frame.aside) = arc.aside_world.cast<float>();
  frame.cos_aside = static_cast<float>(std::cos(arc.aside_rad));
  frame.sin_aside = static_cast<float>(std::sin(arc.aside_rad));
  frame.tan_half_width = static_cast<float>(std::tan(arc.half_width_rad));
  return frame;
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
  const double end = static_cast<double>(profile.size());
  const double length = far_bin - near_bin;
  if (near_bin >= end) return;
  if (length < 1e-9) {
    profile[static_cast<std::size_t>(near_bin)] += power;
    return;
  }
  const double last = std::min(far_bin, end);
  for (double bin = std::floor(near_bin); bin < last; ++bin) {
    const double covered = std::min(bin + 1, last) - std::max(bin, near_bin);
    profile[static_cast<std::size_t>(bin)] += power * covered / length;
  }
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

void SurfaceEchoes::add(const RayArc& arc, std::span<const ArcRay> rays, std::span<double> profile,
                        EchoesByLabel* by_label) const {
  if (head_world_m_.z() > 0) return;
  static const ImagingKernels& kernels = imaging_kernels();
  const ArcFrame frame = frame_of(arc);
  const PatchRule rule{static_cast<float>(head_world_m_.z()), static_cast<float>(absorption_db_m_),
                       static_cast<float>(bin_m_)};
  RayPacket packet;
  HitPacket hits;
  packet.origin_x.fill(0), packet.origin_y.fill(0), packet.origin_z.fill(0);
  packet.near_m.fill(0);
  // The patch of a ray that hits just beyond the last bin may begin within that bin.
  packet.far_m.fill(static_cast<float>(range_max_m_) * kPatchStretch);
  alignas(64) float near_bin[kPacketRays], far_bin[kPacketRays], cosine[kPacketRays], loss[kPacketRays];
  for (std::size_t first = 0; first < rays.size(); first += kPacketRays) {
    const std::span<const ArcRay> some = rays.subspan(first, std::min(kPacketRays, rays.size() - first));
    const ArcPacket arcs(some);
    kernels.directions(frame, arcs.angles(), packet.direction_x.data(), packet.direction_y.data(),
                       packet.direction_z.data());
    for (std::size_t k = 0; k < kPacketRays; ++k) packet.active[k] = k < some.size() ? -1 : 0;
    scene_->cast(head_world_m_, packet, hits, RayOrder::kCoherent);
    kernels.patches(frame, arcs.angles(),
                    {hits.distance_m.data(), hits.normal_x.data(), hits.normal_y.data(), hits.normal_z.data()}, rule,
                    {near_bin, far_bin, cosine, loss});
    for (std::size_t k = 0; k < some.size(); ++k) {
      if (!(cosine[k] > 0)) continue;
      const auto label = static_cast<Label>(hits.label[k]);
      double power = some[k].gain_sr * double{loss[k]};
      if (curves_.empty()) {
        power *= (label < strengths_.size() ? strengths_[label] : solid_) * double{cosine[k]};
      } else {
        const double facing = std::max(double{cosine[k]}, 1e-3);
        power *= scattered(label, facing) / facing;
      }
      spread(power, double{near_bin[k]}, double{far_bin[k]}, profile);
      if (by_label != nullptr) spread(power, double{near_bin[k]}, double{far_bin[k]}, by_label->of(label));
    }
  }
  if (acoustics_->multipath) add_ghosts(arc, rays, profile);
}

}  // namespace uwsim
