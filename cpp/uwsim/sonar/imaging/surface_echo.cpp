#include "uwsim/sonar/imaging/surface_echo.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

constexpr double kFarField_m = 0.05;  // at shorter ranges there is no far field, and 1 / R^2 would diverge
constexpr double kStretch = 1.5;      // limits the extent of a patch, as a multiple of its range

/// The range at which a ray in another direction meets the tangent plane, relative to the range of the hit. The
/// arguments are the dot products of the normal with the two directions.
double range_ratio(double along, double other) {
  const double ratio = along / other;
  return ratio > 0 ? std::clamp(ratio, 1 / kStretch, kStretch) : kStretch;
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
    rays.push_back({angles_rad[k], angles_rad[k] - down / 2, angles_rad[k] + up / 2, 1});
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
  std::vector<Ray> cast(rays.size());
  std::vector<RayHit> hits(rays.size());
  for (std::size_t k = 0; k < rays.size(); ++k) cast[k] = {head_world_m_, arc.direction(rays[k].angle_rad)};
  // The patch of a ray that hits just beyond the last bin may begin within that bin.
  scene_->cast(cast, range_max_m_ * kStretch, hits);
  for (std::size_t k = 0; k < rays.size(); ++k) {
    if (hits[k].label != kNothing) add_patch(arc, rays[k], cast[k], hits[k], profile, by_label);
  }
  if (acoustics_->multipath) add_ghosts(arc, rays, profile);
}

void SurfaceEchoes::add_patch(const RayArc& arc, const ArcRay& patch, const Ray& ray, const RayHit& hit,
                              std::span<double> profile, EchoesByLabel* by_label) const {
  const Eigen::Vector3d normal = hit.normal_world.cast<double>();
  const double along = normal.dot(ray.direction_world);
  const double z = ray.origin_world_m.z() + hit.distance_m * ray.direction_world.z();
  if (along >= 0 || z > 0) return;

  const double range = std::max(hit.distance_m, kFarField_m);
  const double one = range_ratio(along, normal.dot(arc.direction(patch.lower_rad)));
  const double other = range_ratio(along, normal.dot(arc.direction(patch.upper_rad)));
  const Eigen::Vector3d inward = std::cos(patch.angle_rad) * arc.ahead_world + std::sin(patch.angle_rad) * arc.up_world;
  const Eigen::Vector3d across = std::cos(arc.aside_rad) * arc.aside_world - std::sin(arc.aside_rad) * inward;
  const double slope = normal.dot(across) * std::tan(arc.half_width_rad) / along;
  const double widened = std::min(std::abs(slope), kStretch - 1);
  const double near = range * std::max(std::min(one, other) - widened, 1 / kStretch);
  const double far = range * (std::max(one, other) + widened);

  const double strength = hit.label < strengths_.size() ? strengths_[hit.label] : solid_;
  const double loss = std::pow(10.0, -0.2 * absorption_db_m_ * range) / (range * range);
  double power = strength * std::min(1.0, -along) * patch.gain_sr * loss;
  if (!curves_.empty()) {
    const double cosine = std::clamp(-along, 1e-3, 1.0);
    power = scattered(hit.label, cosine) / cosine * patch.gain_sr * loss;
  }
  spread(power, near / bin_m_, far / bin_m_, profile);
  if (by_label != nullptr) spread(power, near / bin_m_, far / bin_m_, by_label->of(hit.label));
}

}  // namespace uwsim
