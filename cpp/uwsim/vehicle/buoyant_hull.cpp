#include "uwsim/vehicle/buoyant_hull.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "uwsim/core/symmetric.h"
#include "uwsim/vehicle/mesh_slice.h"

namespace uwsim {
namespace {

constexpr double kThinnest = 1e-9;  // parts with less than this fraction of the volume are left out
constexpr double kWavePitch = 8;    // see CutVolume
constexpr double kBent = 1e-4;      // see mass_across_bends

/// Returns 0 for x <= 0, 1 for x >= 1, and in between a cubic with zero slope at both ends.
double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// `moments` are about `origin_m`.
VolumePart part_of(const VolumeMoments& moments, const Eigen::Vector3d& origin_m) {
  const Eigen::Vector3d centre = moments.first_m4 / moments.volume_m3;
  return {moments.volume_m3, origin_m + centre, moments.second_m5 - moments.volume_m3 * centre * centre.transpose()};
}

}  // namespace

BuoyantHull::Slice::Slice(TriangleMesh mesh, double pitch) {
  Eigen::Vector3d low = mesh.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  middle_body_m = 0.5 * (low + high);
  half_size_m = 0.5 * (high - low);
  for (Eigen::Vector3d& v : mesh.vertices_m) {
    v -= middle_body_m;
    radius_m = std::max(radius_m, v.norm());
  }
  volume = CutVolume(mesh, pitch);
}

/// A slice and the direction in which heights are measured, such as the world's up, in the body frame.
struct BuoyantHull::Cut {
  const CutVolume& volume;
  Eigen::Vector3d up_body;
  double middle_z_m;     // height of the slice's middle
  double half_height_m;  // conservative bound on how far the slice extends above and below its middle
  double radius_m;

  Cut(const Slice& slice, const Eigen::Vector3d& up, double middle_z)
      : volume(slice.volume),
        up_body(up),
        middle_z_m(middle_z),
        half_height_m(std::min(slice.radius_m, up.cwiseAbs().dot(slice.half_size_m))),
        radius_m(slice.radius_m) {}

  /// Relative to the slice's middle.
  VolumeMoments moments_below(double level_m, bool with_second) const {
    if (middle_z_m + half_height_m <= level_m) return volume.whole();
    if (middle_z_m - half_height_m >= level_m) return {};
    return volume.below(up_body, level_m - middle_z_m, with_second);
  }
  /// Those below the level 0, from `kept`, which is replaced if it is of a plane too far away.
  VolumeMoments moments_kept_in(std::optional<PlaneCut>& kept) const {
    if (std::abs(middle_z_m) >= half_height_m) return moments_below(0, true);
    if (kept && kept->is_near(up_body, -middle_z_m, radius_m)) return kept->moved_to(up_body, -middle_z_m);
    return kept.emplace(volume.cut(up_body, -middle_z_m)).below;
  }
};

/// A pose, and the whole hull at it.
struct BuoyantHull::Placed {
  const Eigen::Vector3d& position_world_m;
  const Eigen::Matrix3d& world_from_body;
  Cut hull;

  Placed(const BuoyantHull& of, const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation)
      : position_world_m(position),
        world_from_body(rotation),
        hull(of.whole_, rotation.row(2), position.z() + Eigen::Vector3d(rotation.row(2)).dot(of.whole_.middle_body_m)) {
  }

  double bottom_m() const { return hull.middle_z_m - hull.half_height_m; }
  double top_m() const { return hull.middle_z_m + hull.half_height_m; }
};

/// Mass of displaced water, and its moment about a slice's middle.
struct BuoyantHull::DisplacedMass {
  double mass_kg = 0;
  Eigen::Vector3d moment_kg_m = Eigen::Vector3d::Zero();
};

BuoyantHull::BuoyantHull(TriangleMesh mesh_body, std::optional<std::size_t> division)
    : mesh_body_(std::move(mesh_body)), division_(division) {
  require_closed(mesh_body_, "hull");
  require(division.value_or(0) < parts_.slices.size(), "hull.division", division.value_or(0), "must be at most 3");
  solid_ = solid_properties(mesh_body_);
  whole_ = Slice(mesh_body_, 1);
  const Eigen::Matrix3d& inertia = solid_.inertia_per_density_m5;
  const Eigen::Matrix3d second = 0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia;
  parts_.slices[0] = {{solid_.volume_m3, solid_.centroid_m, second}};
  parts_.inverse_inertia_1_m5 = inertia.inverse();
  const Modes<3> axes = principal_axes(second);
  parts_.spread_m = axes.vectors * (3 / solid_.volume_m3 * axes.values).cwiseSqrt().asDiagonal();
  parts_.length_m = 2 * whole_.half_size_m.maxCoeff();
  slices_ = std::make_shared<Slices>();
}

const BuoyantHull::Slices& BuoyantHull::in_slices() const {
  std::call_once(slices_->are_cut, [this] { cut_into_slices(*slices_); });
  return *slices_;
}

void BuoyantHull::cut_into_slices(Slices& slices) const {
  slices.parts = parts_;
  Eigen::Index longest = 0;
  whole_.half_size_m.maxCoeff(&longest);
  slices.divisions[0].emplace_back(mesh_body_, kWavePitch);
  for (std::size_t division = 1, count = 2; division < slices.divisions.size(); ++division, count *= 2) {
    const double thickness_m = parts_.length_m / static_cast<double>(count);
    for (std::size_t k = 0; k < count; ++k) {
      const double low_m = whole_.middle_body_m(longest) - 0.5 * parts_.length_m + static_cast<double>(k) * thickness_m;
      constexpr double kBeyond = std::numeric_limits<double>::max();
      TriangleMesh mesh =
          slice_between(mesh_body_, longest, k == 0 ? -kBeyond : low_m, k + 1 == count ? kBeyond : low_m + thickness_m);
      if (mesh.triangles.empty()) continue;
      Slice slice(std::move(mesh), kWavePitch);
      const VolumeMoments& all = slice.volume.whole();
      if (all.volume_m3 <= kThinnest * solid_.volume_m3) continue;
      slices.parts.slices[division].push_back(part_of(all, slice.middle_body_m));
      slices.divisions[division].push_back(std::move(slice));
    }
  }
}

VolumeFlow BuoyantHull::flow_at(const Placed& at, const Eigen::Vector3d& centre_body_m, const WaterField& water,
                                double time_s, NearbyWater* nearby) const {
  const Eigen::Vector3d centre = at.position_world_m + at.world_from_body * centre_body_m;
  const VolumeParts& parts = water.surface_is_flat() ? parts_ : in_slices().parts;
  const PlacedVolume placed{parts, centre, at.world_from_body};
  if (nearby == nullptr || !water.flows_smoothly()) return water.flow_over(placed, time_s);
  if (nearby->flow) return nearby->flow->at(centre, time_s);
  return nearby->flow.emplace(water.flow_near(placed, time_s)).flow;
}

Displacement BuoyantHull::displacement(const Pose& world_from_body, double level_m) const {
  const Eigen::Matrix3d rotation = world_from_body.rotation();
  const Placed at(*this, world_from_body.position_m, rotation);
  const VolumeMoments wet = at.hull.moments_below(level_m, false);
  if (wet.volume_m3 <= 0) return {0, world_from_body.position_m};
  return {wet.volume_m3, world_from_body.position_m + rotation * (whole_.middle_body_m + wet.first_m4 / wet.volume_m3)};
}

WaterSurface BuoyantHull::surface_over(const Placed& at, const Slice& slice, const VolumePart& part,
                                       const WaterField& water, double time_s) const {
  const Eigen::Matrix3d& rotation = at.world_from_body;
  const Eigen::Vector3d middle = at.position_world_m + rotation * slice.middle_body_m;
  const Eigen::RowVector3d x = rotation.row(0), y = rotation.row(1);
  const Eigen::Vector3d cx = part.second_moment_m5 * x.transpose() / part.volume_m3,
                        cy = part.second_moment_m5 * y.transpose() / part.volume_m3;
  return water.surface_over({middle.x(), middle.y(), slice.radius_m, {x * cx, x * cy, y * cy}}, time_s);
}

/// Calls visit(slice, cut, wet) for each slice that is wet, with heights measured from the plane that cuts it.
template <typename Visit>
void BuoyantHull::visit_wet_slices(const Placed& at, const WaterField& water, double time_s,
                                   const WaterSurface& over_hull, NearbyWater* nearby, const Visit& visit) const {
  const std::size_t division = division_ ? *division_ : water.division_of(parts_, at.hull.middle_z_m);
  const std::vector<Slice>& division_slices = in_slices().divisions[division];
  if (nearby != nullptr && nearby->division != division) {
    nearby->cuts = {};
    nearby->division = division;
  }
  for (std::size_t k = 0; k < division_slices.size(); ++k) {
    const Slice& slice = division_slices[k];
    const WaterSurface surface =
        division == 0 ? over_hull : surface_over(at, slice, in_slices().parts.slices[division][k], water, time_s);
    const Eigen::Vector3d normal = Eigen::Vector3d(-surface.slope_x, -surface.slope_y, 1).normalized();
    const double middle_z_m = at.position_world_m.z() + at.hull.up_body.dot(slice.middle_body_m);
    const Cut cut(slice, at.world_from_body.transpose() * normal, normal.z() * (middle_z_m - surface.mean_m));
    const VolumeMoments wet = nearby == nullptr ? cut.moments_below(0, true) : cut.moments_kept_in(nearby->cuts[k]);
    if (wet.volume_m3 > kThinnest * solid_.volume_m3) visit(slice, cut, wet, surface);
  }
}

double BuoyantHull::submerged_volume_m3(const Pose& world_from_body, const WaterField& water, double time_s) const {
  if (water.surface_is_flat()) return displacement(world_from_body, water.still_level_m(time_s)).volume_m3;
  const Eigen::Matrix3d rotation = world_from_body.rotation();
  const Placed at(*this, world_from_body.position_m, rotation);
  if (at.top_m() <= -water.wave_bound_m()) return solid_.volume_m3;
  double sum = 0;
  visit_wet_slices(
      at, water, time_s, surface_over(at, whole_, parts_.whole(), water, time_s), nullptr,
      [&sum](const Slice&, const Cut&, const VolumeMoments& wet, const WaterSurface&) { sum += wet.volume_m3; });
  return sum;
}

/// Empty if the hull is dry.
std::vector<WaterPlane> BuoyantHull::water_planes(const Placed& at, const WaterField& water, double time_s) const {
  const double bound_m = water.wave_bound_m();
  if (at.top_m() <= -bound_m) return {{}};
  if (at.bottom_m() >= bound_m) return {};
  if (bound_m == 0) return {{.up_body = at.hull.up_body, .level_m = -at.position_world_m.z()}};
  std::vector<WaterPlane> planes;
  const double half_length_m = 0.5 * parts_.length_m;
  Eigen::Index longest = 0;
  whole_.half_size_m.maxCoeff(&longest);
  const auto add = [&](const Slice& slice, const Cut& cut, const VolumeMoments&, const WaterSurface&) {
    WaterPlane& plane = planes.emplace_back();
    plane.up_body = cut.up_body;
    plane.level_m = cut.up_body.dot(slice.middle_body_m) - cut.middle_z_m;
    if (&slice == &in_slices().divisions[0].front()) return;
    plane.axis = longest;
    const double middle_m = slice.middle_body_m(longest), half_m = slice.half_size_m(longest);
    const double beyond_m = std::abs(middle_m - whole_.middle_body_m(longest)) + half_m;
    const bool ends_the_hull = beyond_m > (1 - kThinnest) * half_length_m;
    const bool is_low = middle_m < whole_.middle_body_m(longest);
    if (!ends_the_hull || !is_low) plane.from_m = middle_m - half_m;
    if (!ends_the_hull || is_low) plane.to_m = middle_m + half_m;
  };
  visit_wet_slices(at, water, time_s, surface_over(at, whole_, parts_.whole(), water, time_s), nullptr, add);
  return planes;
}

WetSurface BuoyantHull::wet_surface(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                                    const WaterField& water, double time_s) const {
  const Placed at(*this, position_world_m, world_from_body);
  return cut_at_surface(mesh_body_, water_planes(at, water, time_s), position_world_m, world_from_body, water, time_s);
}

Buoyancy BuoyantHull::buoyancy(const Eigen::Vector3d& position_world_m, const Eigen::Matrix3d& world_from_body,
                               const WaterField& water, double time_s, NearbyWater* nearby) const {
  const Placed at(*this, position_world_m, world_from_body);
  if (water.surface_is_flat()) return below_flat_surface(at, water, time_s, nearby);
  if (at.hull.middle_z_m + 2 * whole_.radius_m <= -water.wave_bound_m())
    return below_waves(at, water, time_s, flow_at(at, solid_.centroid_m, water, time_s, nearby));
  const WaterSurface surface = surface_over(at, whole_, parts_.whole(), water, time_s);
  if (at.bottom_m() >= surface.high_m) return {};
  const double deep = smooth_step((surface.low_m - at.top_m()) / whole_.radius_m);
  if (deep == 1) return below_waves(at, water, time_s, flow_at(at, solid_.centroid_m, water, time_s, nearby));
  Buoyancy sum = through_waves(at, water, time_s, surface, nearby);
  if (sum.volume_m3 > 0) sum.flow = flow_at(at, sum.centre_body_m, water, time_s, nearby);
  if (deep == 0) return sum;
  const Buoyancy below = below_waves(at, water, time_s, sum.flow);
  sum.force_body_n += deep * (below.force_body_n - sum.force_body_n);
  sum.moment_body_nm += deep * (below.moment_body_nm - sum.moment_body_nm);
  return sum;
}

/// The buoyancy under a flat surface, which a tide may have moved. Apart, so that the result is built in its place.
Buoyancy BuoyantHull::below_flat_surface(const Placed& at, const WaterField& water, double time_s,
                                         NearbyWater* nearby) const {
  const double level_m = water.still_level_m(time_s);
  const Eigen::Vector3d above_level = at.position_world_m - level_m * Eigen::Vector3d::UnitZ();
  Buoyancy still =
      level_m == 0 ? in_still_water(at, water, 0) : in_still_water({*this, above_level, at.world_from_body}, water, 0);
  // Made in its place: a load that spans two numbers just stored would wait for both.
  if (still.volume_m3 > 0) new (&still.flow) VolumeFlow(flow_at(at, still.centre_body_m, water, time_s, nearby));
  return still;
}

/// The buoyancy under a flat surface at z = `surface_m`, with the density of still water.
Buoyancy BuoyantHull::in_still_water(const Placed& at, const WaterField& water, double surface_m) const {
  const Cut& hull = at.hull;
  const double gravity = water.gravity();
  const DensityLayer layer = water.density_layer_at(std::min(at.top_m(), surface_m));
  const bool in_one_layer = at.bottom_m() >= layer.low_m;
  const Eigen::Vector3d weight_per_kg = gravity * hull.up_body;
  Buoyancy wet;
  if (!in_one_layer && at.top_m() <= surface_m) {
    if (const std::optional<DisplacedMass> displaced = mass_across_bends(at, water, layer)) {
      wet.volume_m3 = solid_.volume_m3;
      wet.centre_body_m = solid_.centroid_m;
      wet.force_body_n = displaced->mass_kg * weight_per_kg;
      wet.moment_body_nm = solid_.centroid_m.cross(wet.force_body_n) + displaced->moment_kg_m.cross(weight_per_kg);
      return wet;
    }
  }
  if (!in_one_layer || (layer.gradient_kg_m4 != 0 && at.top_m() > surface_m)) {
    const VolumeMoments part = hull.moments_below(surface_m, true);
    if (part.volume_m3 <= 0) return wet;
    const DisplacedMass displaced = mass_in_layers(hull, water, surface_m, part);
    wet.volume_m3 = part.volume_m3;
    wet.centre_body_m = whole_.middle_body_m + part.first_m4 / part.volume_m3;
    wet.force_body_n = displaced.mass_kg * weight_per_kg;
    wet.moment_body_nm = whole_.middle_body_m.cross(wet.force_body_n) + displaced.moment_kg_m.cross(weight_per_kg);
    return wet;
  }
  if (at.top_m() <= surface_m) {
    wet.volume_m3 = solid_.volume_m3;
    wet.centre_body_m = solid_.centroid_m;
  } else {
    const VolumeMoments part = hull.moments_below(surface_m, false);
    if (part.volume_m3 <= 0) return wet;
    wet.volume_m3 = part.volume_m3;
    wet.centre_body_m = whole_.middle_body_m + part.first_m4 / part.volume_m3;
  }
  const double centre_z_m = at.position_world_m.z() + hull.up_body.dot(wet.centre_body_m);
  wet.force_body_n = layer.at(centre_z_m) * gravity * wet.volume_m3 * hull.up_body;
  wet.moment_body_nm = wet.centre_body_m.cross(wet.force_body_n);
  if (layer.gradient_kg_m4 != 0) {  // the centre of mass of the displaced water is shifted towards the denser side
    const Eigen::Vector3d shift = parts_.whole().second_moment_m5 * hull.up_body;
    wet.moment_body_nm += layer.gradient_kg_m4 * gravity * shift.cross(hull.up_body);
  }
  return wet;
}

/// The mass that a submerged hull displaces in layers of which each bends the density by at most kBent over the hull,
/// and its moment about the centroid; nothing if one bends it more. The hull is taken for the ellipsoid that has its
/// volume and its second moments: exact within a layer, and otherwise to some hundredths of the bend. At a height of x
/// half-axes, a share of 3/4 (1 - x^2) of an ellipsoid's volume lies.
std::optional<BuoyantHull::DisplacedMass> BuoyantHull::mass_across_bends(const Placed& at, const WaterField& water,
                                                                         const DensityLayer& top) const {
  const Eigen::Vector3d shift_m5 = parts_.whole().second_moment_m5 * at.hull.up_body;
  const double half_axis_volume_m4 = std::sqrt(5 * solid_.volume_m3 * at.hull.up_body.dot(shift_m5));
  const double per_half_axis_1_m = solid_.volume_m3 / half_axis_volume_m4;
  const double middle_z_m = at.position_world_m.z() + at.hull.up_body.dot(solid_.centroid_m);
  DensityLayer layer = top;
  DisplacedMass sum{solid_.volume_m3 * layer.at(middle_z_m), layer.gradient_kg_m4 * shift_m5};
  while (layer.low_m > at.bottom_m()) {
    const DensityLayer next = water.density_layer_below(layer);
    const double bend = next.gradient_kg_m4 - layer.gradient_kg_m4, jump = next.at(layer.low_m) - layer.at(layer.low_m);
    const double most = kBent * layer.density_kg_m3;
    if (std::abs(bend) * whole_.radius_m > most || std::abs(jump) > 1e-6 * most) return std::nullopt;
    const double s = std::clamp((layer.low_m - middle_z_m) * per_half_axis_1_m, -1.0, 1.0), s2 = s * s;
    // The integrals of 3/4 (1 - x^2) (s - x), and of that times x, from -1 to s.
    const double depth = s2 * (0.375 - 0.0625 * s2) + 0.5 * s + 0.1875;
    const double moment = s * (s2 * (0.125 - 0.0375 * s2) - 0.1875) - 0.1;
    sum.mass_kg -= bend * half_axis_volume_m4 * depth;
    sum.moment_kg_m -= 5 * bend * moment * shift_m5;
    layer = next;
  }
  return sum;
}

/// The mass displaced in several density layers. The whole wet volume contributes with the top layer's density; for
/// each further layer, the volume below its upper boundary contributes with the density difference from the layer
/// above.
BuoyantHull::DisplacedMass BuoyantHull::mass_in_layers(const Cut& at, const WaterField& water, double surface_m,
                                                       const VolumeMoments& wet) const {
  DisplacedMass sum;
  const auto add = [&](const VolumeMoments& part, double density_at_middle, double gradient) {
    sum.mass_kg += density_at_middle * part.volume_m3 + gradient * at.up_body.dot(part.first_m4);
    sum.moment_kg_m += density_at_middle * part.first_m4 + gradient * (part.second_m5 * at.up_body);
  };
  const double bottom_m = at.middle_z_m - at.half_height_m;
  DensityLayer layer = water.density_layer_at(std::min(at.middle_z_m + at.half_height_m, surface_m));
  add(wet, layer.at(at.middle_z_m), layer.gradient_kg_m4);
  while (layer.low_m > bottom_m) {
    const DensityLayer next = water.density_layer_below(layer);
    add(at.moments_below(layer.low_m, true), next.at(at.middle_z_m) - layer.at(at.middle_z_m),
        next.gradient_kg_m4 - layer.gradient_kg_m4);
    layer = next;
  }
  return sum;
}

/// The buoyancy of a hull that the surface may cut. Layers of density are taken to be parallel to the surface.
Buoyancy BuoyantHull::through_waves(const Placed& at, const WaterField& water, double time_s,
                                    const WaterSurface& over_hull, NearbyWater* nearby) const {
  const Eigen::Matrix3d& rotation = at.world_from_body;
  const Eigen::Vector3d weight_per_kg = water.gravity() * at.hull.up_body;
  Buoyancy sum;
  Eigen::Vector3d first_m4 = Eigen::Vector3d::Zero();
  visit_wet_slices(
      at, water, time_s, over_hull, nearby,
      [&](const Slice& slice, const Cut& cut, const VolumeMoments& moments, const WaterSurface& surface) {
        const DisplacedMass displaced = mass_in_layers(cut, water, 0, moments);
        const VolumePart wet = part_of(moments, slice.middle_body_m);
        const VolumePart placed{wet.volume_m3, at.position_world_m + rotation * wet.centroid_m,
                                rotation * wet.second_moment_m5 * rotation.transpose()};
        const VolumeLoad load = water.wave_load_on(placed, surface, time_s);
        const double density = water.density_at(cut.middle_z_m + cut.up_body.dot(wet.centroid_m - slice.middle_body_m));
        const Eigen::Vector3d weight = displaced.mass_kg * weight_per_kg,
                              force = density * (rotation.transpose() * load.force_m4_s2);
        sum.volume_m3 += wet.volume_m3;
        first_m4 += wet.volume_m3 * wet.centroid_m;
        sum.force_body_n += weight + force;
        sum.moment_body_nm += slice.middle_body_m.cross(weight) + displaced.moment_kg_m.cross(weight_per_kg) +
                              wet.centroid_m.cross(force) + density * (rotation.transpose() * load.moment_m5_s2);
      });
  if (sum.volume_m3 > 0) sum.centre_body_m = first_m4 / sum.volume_m3;
  return sum;
}

/// The buoyancy of a fully submerged hull: as in still water, with the layers displaced by the waves, plus the force
/// that accelerates the displaced water.
Buoyancy BuoyantHull::below_waves(const Placed& at, const WaterField& water, double time_s,
                                  const VolumeFlow& flow) const {
  const Eigen::Vector3d centroid = at.position_world_m + at.world_from_body * solid_.centroid_m;
  const double head_m = water.has_one_density() ? -centroid.z() : water.pressure_head_at(centroid, time_s);
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
