#include "uwsim/vehicle/buoyant_hull.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace uwsim {
namespace {

constexpr double kEdgePerRadius = 0.25;  // longest edge of a triangle under waves
constexpr double kThinnest = 1e-9;       // slices with less than this fraction of the volume are left out

/// Returns 0 for x <= 0, 1 for x >= 1, and in between a cubic with zero slope at both ends.
double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

}  // namespace

/// A pose with derived values: the world's up in the body frame and the height of the hull's middle.
struct BuoyantHull::Placed {
  const Eigen::Vector3d& position_world_m;
  const Eigen::Matrix3d& world_from_body;
  Eigen::Vector3d up_body;
  double middle_z_m;
  double half_height_m;  // conservative bound on how far the hull extends above and below its middle

  Placed(const BuoyantHull& hull, const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation)
      : position_world_m(position),
        world_from_body(rotation),
        up_body(rotation.row(2)),
        middle_z_m(position.z() + up_body.dot(hull.middle_body_m_)),
        half_height_m(std::min(hull.radius_m_, up_body.cwiseAbs().dot(hull.half_size_m_))) {}
};

BuoyantHull::BuoyantHull(TriangleMesh mesh_body) : mesh_body_(std::move(mesh_body)) {
  require_closed(mesh_body_, "hull");
  solid_ = solid_properties(mesh_body_);
  Eigen::Vector3d low = mesh_body_.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& v : mesh_body_.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  middle_body_m_ = 0.5 * (low + high);
  half_size_m_ = 0.5 * (high - low);
  TriangleMesh centred = mesh_body_;
  for (Eigen::Vector3d& v : centred.vertices_m) {
    v -= middle_body_m_;
    radius_m_ = std::max(radius_m_, v.norm());
  }
  volume_ = CutVolume(centred);
  cut_into_slices();
  pressure_ = HullPressure(mesh_body_, kEdgePerRadius * radius_m_);
}

void BuoyantHull::cut_into_slices() {
  const Eigen::Matrix3d& inertia = solid_.inertia_per_density_m5;
  const Eigen::Matrix3d second = 0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia;
  parts_.slices[0] = {{solid_.volume_m3, solid_.centroid_m, second}};
  parts_.inverse_inertia_1_m5 = inertia.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(second);
  parts_.spread_m = axes.eigenvectors() * (3 / solid_.volume_m3 * axes.eigenvalues()).cwiseSqrt().asDiagonal();
  Eigen::Index longest = 0;
  parts_.length_m = 2 * half_size_m_.maxCoeff(&longest);
  const Eigen::Vector3d along = Eigen::Vector3d::Unit(longest);
  for (std::size_t division = 1, count = 2; division < parts_.slices.size(); ++division, count *= 2) {
    VolumeMoments before;
    for (std::size_t k = 1; k <= count; ++k) {
      const double level_m = half_size_m_(longest) * (2.0 * static_cast<double>(k) / static_cast<double>(count) - 1);
      const VolumeMoments below = k == count ? volume_.whole() : volume_.below(along, level_m, true);
      const double volume_m3 = below.volume_m3 - before.volume_m3;
      if (volume_m3 > kThinnest * solid_.volume_m3) {
        const Eigen::Vector3d centre = (below.first_m4 - before.first_m4) / volume_m3;
        const Eigen::Matrix3d about = below.second_m5 - before.second_m5 - volume_m3 * centre * centre.transpose();
        parts_.slices[division].push_back({volume_m3, middle_body_m_ + centre, about});
      }
      before = below;
    }
  }
}

VolumeFlow BuoyantHull::flow_at(const Placed& at, const Eigen::Vector3d& centre_body_m, const WaterField& water,
                                double time_s) const {
  const Eigen::Vector3d centre = at.position_world_m + at.world_from_body * centre_body_m;
  return water.flow_over({parts_, centre, at.world_from_body}, time_s);
}

VolumeMoments BuoyantHull::moments_below(const Placed& at, double level_m, bool with_second) const {
  if (at.middle_z_m + at.half_height_m <= level_m) return volume_.whole();
  if (at.middle_z_m - at.half_height_m >= level_m) return {};
  return volume_.below(at.up_body, level_m - at.middle_z_m, with_second);
}

Displacement BuoyantHull::displacement(const Pose& world_from_body, double level_m) const {
  const Eigen::Matrix3d rotation = world_from_body.rotation();
  const VolumeMoments wet = moments_below({*this, world_from_body.position_m, rotation}, level_m, false);
  if (wet.volume_m3 <= 0) return {0, world_from_body.position_m};
  return {wet.volume_m3, world_from_body.position_m + rotation * (middle_body_m_ + wet.first_m4 / wet.volume_m3)};
}

double BuoyantHull::level_m(const Pose& world_from_body, const WaterField& water, double time_s) const {
  if (water.wave_bound_m() == 0) return 0;
  const Eigen::Vector3d middle = world_from_body.point(middle_body_m_);
  return water.surface_height_at(middle.x(), middle.y(), time_s);
}

Buoyancy BuoyantHull::buoyancy(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                               const WaterField& water, double time_s) const {
  const Placed at(*this, position_world_m, world_from_body);
  const double bound_m = water.wave_bound_m();
  if (bound_m == 0) {
    Buoyancy still = in_still_water(at, water, 0);
    if (still.volume_m3 > 0) still.flow = flow_at(at, still.centre_body_m, water, time_s);
    return still;
  }
  if (at.middle_z_m + 2 * radius_m_ <= -bound_m) {
    return below_waves(at, water, time_s, flow_at(at, solid_.centroid_m, water, time_s));
  }
  const Eigen::Vector3d middle = position_world_m + world_from_body * middle_body_m_;
  const SurfaceSpan span = water.surface_span_at(middle.x(), middle.y(), radius_m_, time_s);
  if (at.middle_z_m - at.half_height_m >= span.high_m) return {};
  const double cover_m = span.low_m - (at.middle_z_m + at.half_height_m);
  const double deep = smooth_step(cover_m / radius_m_);
  if (deep == 1) return below_waves(at, water, time_s, flow_at(at, solid_.centroid_m, water, time_s));
  Buoyancy sum = through_waves(at, water, time_s, span.middle_m);
  if (sum.volume_m3 > 0) sum.flow = flow_at(at, sum.centre_body_m, water, time_s);
  if (deep == 0) return sum;
  const Buoyancy below = below_waves(at, water, time_s, sum.flow);
  sum.force_body_n += deep * (below.force_body_n - sum.force_body_n);
  sum.moment_body_nm += deep * (below.moment_body_nm - sum.moment_body_nm);
  return sum;
}

/// The buoyancy under a flat surface at z = `surface_m`, with the density of still water.
Buoyancy BuoyantHull::in_still_water(const Placed& at, const WaterField& water, double surface_m) const {
  const double top_m = at.middle_z_m + at.half_height_m;
  const DensityLayer layer = water.density_layer_at(std::min(top_m, surface_m));
  const bool in_one_layer = at.middle_z_m - at.half_height_m >= layer.low_m;
  if (!in_one_layer || (layer.gradient_kg_m4 != 0 && top_m > surface_m)) {
    return in_layers(at, water, surface_m, moments_below(at, surface_m, true));
  }
  Buoyancy wet;
  if (top_m <= surface_m) {
    wet.volume_m3 = solid_.volume_m3;
    wet.centre_body_m = solid_.centroid_m;
  } else {
    const VolumeMoments part = moments_below(at, surface_m, false);
    if (part.volume_m3 <= 0) return {};
    wet.volume_m3 = part.volume_m3;
    wet.centre_body_m = middle_body_m_ + part.first_m4 / part.volume_m3;
  }
  const double centre_z_m = at.position_world_m.z() + at.up_body.dot(wet.centre_body_m);
  const double gravity = water.gravity();
  wet.force_body_n = layer.at(centre_z_m) * gravity * wet.volume_m3 * at.up_body;
  wet.moment_body_nm = wet.centre_body_m.cross(wet.force_body_n);
  if (layer.gradient_kg_m4 != 0) {  // the centre of mass of the displaced water is shifted towards the denser side
    const Eigen::Vector3d shift = parts_.whole().second_moment_m5 * at.up_body;
    wet.moment_body_nm += layer.gradient_kg_m4 * gravity * shift.cross(at.up_body);
  }
  return wet;
}

/// The buoyancy of a hull in several density layers. The whole wet volume contributes with the top layer's density; for
/// each further layer, the volume below its upper boundary contributes with the density difference from the layer
/// above.
Buoyancy BuoyantHull::in_layers(const Placed& at, const WaterField& water, double surface_m,
                                const VolumeMoments& wet) const {
  if (wet.volume_m3 <= 0) return {};
  double mass_kg = 0;
  Eigen::Vector3d mass_moment_kg_m = Eigen::Vector3d::Zero();  // about the hull's middle
  const auto add = [&](const VolumeMoments& part, double density_at_middle, double gradient) {
    mass_kg += density_at_middle * part.volume_m3 + gradient * at.up_body.dot(part.first_m4);
    mass_moment_kg_m += density_at_middle * part.first_m4 + gradient * (part.second_m5 * at.up_body);
  };
  const double bottom_m = at.middle_z_m - at.half_height_m;
  DensityLayer layer = water.density_layer_at(std::min(at.middle_z_m + at.half_height_m, surface_m));
  add(wet, layer.at(at.middle_z_m), layer.gradient_kg_m4);
  while (layer.low_m > bottom_m) {
    const DensityLayer next =
        water.density_layer_at(std::nextafter(layer.low_m, -std::numeric_limits<double>::infinity()));
    add(moments_below(at, layer.low_m, true), next.at(at.middle_z_m) - layer.at(at.middle_z_m),
        next.gradient_kg_m4 - layer.gradient_kg_m4);
    layer = next;
  }
  const Eigen::Vector3d weight_per_kg = water.gravity() * at.up_body;
  Buoyancy sum;
  sum.volume_m3 = wet.volume_m3;
  sum.centre_body_m = middle_body_m_ + wet.first_m4 / wet.volume_m3;
  sum.force_body_n = mass_kg * weight_per_kg;
  sum.moment_body_nm = middle_body_m_.cross(sum.force_body_n) + mass_moment_kg_m.cross(weight_per_kg);
  return sum;
}

/// The buoyancy of a hull that the surface, `surface_m` above the hull's middle, may cut: the pressure integrated over
/// the wetted triangles.
Buoyancy BuoyantHull::through_waves(const Placed& at, const WaterField& water, double time_s, double surface_m) const {
  const HullPressure::Load load = pressure_.load(at.position_world_m, at.world_from_body, water, time_s);
  const VolumeMoments wet = moments_below(at, surface_m, false);
  Buoyancy sum;
  sum.volume_m3 = std::max(0.0, wet.volume_m3);
  sum.centre_body_m =
      wet.volume_m3 > 0 ? Eigen::Vector3d(middle_body_m_ + wet.first_m4 / wet.volume_m3) : middle_body_m_;
  sum.force_body_n = load.force_body_n;
  sum.moment_body_nm = load.moment_body_nm;
  return sum;
}

/// The buoyancy of a fully submerged hull: as in still water, with the layers displaced by the waves, plus the force
/// that accelerates the displaced water.
Buoyancy BuoyantHull::below_waves(const Placed& at, const WaterField& water, double time_s,
                                  const VolumeFlow& flow) const {
  const Eigen::Vector3d centroid = at.position_world_m + at.world_from_body * solid_.centroid_m;
  double head_m = -centroid.z();
  if (!water.has_one_density()) water.pressure_heads({&centroid, 1}, time_s, {&head_m, 1});
  Eigen::Vector3d shifted = at.position_world_m;
  shifted.z() -= centroid.z() + head_m;
  Buoyancy sum = in_still_water({*this, shifted, at.world_from_body}, water, std::numeric_limits<double>::infinity());
  const double density = water.density_at(-head_m);
  const Eigen::Vector3d force =
      density * solid_.volume_m3 * (at.world_from_body.transpose() * flow.wave_acceleration_m_s2);
  sum.force_body_n += force;
  sum.moment_body_nm += solid_.centroid_m.cross(force) +
                        density * (solid_.inertia_per_density_m5 *
                                   (at.world_from_body.transpose() * flow.wave_angular_acceleration_rad_s2));
  sum.flow = flow;
  return sum;
}

}  // namespace uwsim
