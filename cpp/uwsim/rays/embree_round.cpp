#include "uwsim/rays/embree_round.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "uwsim/rays/embree.h"
#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/embree_tree.h"
#include "uwsim/rays/ray_lanes.h"

namespace uwsim {
namespace {

/// The rays of a callback in double: the original rays if they are available, else the float rays.
class CallbackRays {
 public:
  CallbackRays(const RTCRayQueryContext* context, RTCRayN* rays, unsigned n)
      : detail_(detail_of(context)),
        exact_(detail_.exact == nullptr && detail_.lazy != nullptr ? &detail_.lazy->get() : detail_.exact),
        rays_(rays),
        n_(n) {}

  /// Returns the distance along the exact ray at which the float ray starts.
  double start_m(unsigned k) const {
    const bool starts_later = exact_ != nullptr && detail_.starts_m != nullptr;
    return (starts_later ? detail_.starts_m[RTCRayN_id(rays_, n_, k)] : 0) - detail_.setback_m;
  }
  double near_m(unsigned k) const { return std::max(0.0, start_m(k) + double{RTCRayN_tnear(rays_, n_, k)}); }
  double far_m(unsigned k) const { return start_m(k) + double{RTCRayN_tfar(rays_, n_, k)}; }

  Eigen::Vector3d origin_world_m(unsigned k) const {
    if (exact_ != nullptr) return origin_of(*exact_, RTCRayN_id(rays_, n_, k));
    return Eigen::Vector3d(RTCRayN_org_x(rays_, n_, k), RTCRayN_org_y(rays_, n_, k), RTCRayN_org_z(rays_, n_, k)) +
           detail_.surfaces->middle_m();
  }

  Eigen::Vector3d direction_world(unsigned k) const {
    if (exact_ != nullptr) return direction_of(*exact_, RTCRayN_id(rays_, n_, k));
    return {RTCRayN_dir_x(rays_, n_, k), RTCRayN_dir_y(rays_, n_, k), RTCRayN_dir_z(rays_, n_, k)};
  }

  std::optional<ShapeHit> meet(const RoundShape& shape, unsigned k) const {
    return first_hit(shape, origin_world_m(k), direction_world(k), near_m(k), far_m(k));
  }

  /// Calls visit(ray, hit) for each valid ray that meets the shape.
  template <typename Visit>
  void meet_all(const RoundShape& shape, const int* valid, const Visit& visit) const {
    ExactRays converted;
    // Lanes are only in order in a full packet.
    if (n_ == kPacketRays && exact_ == nullptr) convert(converted);
    const ExactRays& rays = exact_ != nullptr ? *exact_ : converted;
    if (n_ == kPacketRays && shape.is_open()) return meet_wall(shape, valid, rays, visit);
    std::array<std::int32_t, kPacketRays> left;
    std::copy_n(valid, n_, left.data());
    if (n_ == kPacketRays) discard_misses(shape, rays, left);
    for (unsigned k = 0; k < n_; ++k) {
      if (left[k] == 0) continue;
      if (const auto hit = meet(shape, k)) visit(k, *hit);
    }
  }

  /// Passes the hit, computed in double, to the code that started the cast.
  void keep(unsigned k, const ShapeHit& hit) const {
    if (detail_.round_hits == nullptr) return;
    const unsigned lane = RTCRayN_id(rays_, n_, k);
    detail_.round_hits->distance_m[lane] = hit.distance_m;
    detail_.round_hits->normal_x[lane] = hit.normal_world.x();
    detail_.round_hits->normal_y[lane] = hit.normal_world.y();
    detail_.round_hits->normal_z[lane] = hit.normal_world.z();
  }

 private:
  /// Removes the rays that certainly miss the shape.
  static void discard_misses(const RoundShape& shape, const ExactRays& rays,
                             std::array<std::int32_t, kPacketRays>& left) {
    std::array<std::int32_t, kPacketRays> passes;
    kernels().may_meet_round(lanes_of(rays), shape.ends[0].point_world_m.data(), shape.axis.data(), shape.radius_m,
                             passes.data());
    for (std::size_t k = 0; k < kPacketRays; ++k) left[k] &= passes[k];
  }

  template <typename Visit>
  void meet_wall(const RoundShape& shape, const int* valid, const ExactRays& rays, const Visit& visit) const {
    ExactRays::Lanes near, far;
    for (unsigned k = 0; k < kPacketRays; ++k) near[k] = near_m(k), far[k] = far_m(k);
    LaneRays lanes = lanes_of(rays);
    lanes.far_m = far.data();
    const auto& [one, other] = shape.ends;
    const LaneWall wall{shape.axis.data(),
                        {one.point_world_m.data(), other.point_world_m.data()},
                        {one.outward.data(), other.outward.data()},
                        shape.radius_m,
                        kSeam_m,
                        kAlongAxis};
    ExactHits hits;
    std::array<std::int32_t, kPacketRays> met;
    kernels().meet_wall(
        lanes, near.data(), wall,
        {hits.distance_m.data(), hits.normal_x.data(), hits.normal_y.data(), hits.normal_z.data(), met.data()});
    for (unsigned k = 0; k < kPacketRays; ++k) {
      if (valid[k] == 0 || met[k] == kMisses) continue;
      if (met[k] == kMeets) {
        visit(k, ShapeHit{hits.distance_m[k], {hits.normal_x[k], hits.normal_y[k], hits.normal_z[k]}});
      } else if (const auto hit = meet(shape, k)) {
        visit(k, *hit);
      }
    }
  }

  static const RayKernels& kernels() {
    static const RayKernels& chosen = ray_kernels();
    return chosen;
  }

  void convert(ExactRays& out) const {
    const Eigen::Vector3d& middle = detail_.surfaces->middle_m();
    for (unsigned k = 0; k < kPacketRays; ++k) {
      out.origin_x[k] = RTCRayN_org_x(rays_, n_, k) + middle.x();
      out.origin_y[k] = RTCRayN_org_y(rays_, n_, k) + middle.y();
      out.origin_z[k] = RTCRayN_org_z(rays_, n_, k) + middle.z();
      out.direction_x[k] = RTCRayN_dir_x(rays_, n_, k);
      out.direction_y[k] = RTCRayN_dir_y(rays_, n_, k);
      out.direction_z[k] = RTCRayN_dir_z(rays_, n_, k);
    }
  }

  const CastDetail& detail_;
  const ExactRays* exact_;
  RTCRayN* rays_;
  unsigned n_;
};

void round_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const ShapeBounds box = bounds(round.shapes[args->primID]);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(round.box_margin_m);
  const Eigen::Vector3f low = (box.low_m - round.middle_m - margin).cast<float>();
  const Eigen::Vector3f high = (box.high_m - round.middle_m + margin).cast<float>();
  *args->bounds_o = {low.x(), low.y(), low.z(), 0, high.x(), high.y(), high.z(), 0};
}

void round_intersect(const RTCIntersectFunctionNArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const RoundShape& shape = round.shapes[args->primID];
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, args->N);
  const CallbackRays callback(args->context, rays, args->N);
  callback.meet_all(shape, args->valid, [&](unsigned k, const ShapeHit& hit) {
    callback.keep(k, hit);
    RTCRayN_tfar(rays, args->N, k) = static_cast<float>(hit.distance_m - callback.start_m(k));
    RTCHitN_Ng_x(hits, args->N, k) = static_cast<float>(hit.normal_world.x());
    RTCHitN_Ng_y(hits, args->N, k) = static_cast<float>(hit.normal_world.y());
    RTCHitN_Ng_z(hits, args->N, k) = static_cast<float>(hit.normal_world.z());
    RTCHitN_u(hits, args->N, k) = RTCHitN_v(hits, args->N, k) = 0;
    RTCHitN_primID(hits, args->N, k) = args->primID;
    RTCHitN_geomID(hits, args->N, k) = args->geomID;
    RTCHitN_instID(hits, args->N, k, 0) = args->context->instID[0];
  });
}

void round_occluded(const RTCOccludedFunctionNArguments* args) {
  const auto& round = *static_cast<const RoundGeometry*>(args->geometryUserPtr);
  const RoundShape& shape = round.shapes[args->primID];
  const CallbackRays callback(args->context, args->ray, args->N);
  callback.meet_all(shape, args->valid, [&](unsigned k, const ShapeHit&) {
    RTCRayN_tfar(args->ray, args->N, k) = -std::numeric_limits<float>::infinity();
  });
}

}  // namespace

RoundGeometry round_geometry(const TileSurfaces& surfaces, std::uint32_t geometry) {
  RoundGeometry round{geometry, {}, surfaces.middle_m(), surfaces.tolerances().round_box_margin_m};
  for (std::uint32_t k = 0; k < surfaces.count(geometry); ++k) round.shapes.push_back(surfaces.shape(geometry, k));
  return round;
}

void attach_round(RTCDeviceTy* device, RTCSceneTy* tree, const RoundGeometry& round) {
  const GeometryOwner owner(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(owner.get(), static_cast<unsigned>(round.shapes.size()));
  rtcSetGeometryUserData(owner.get(), const_cast<RoundGeometry*>(&round));
  rtcSetGeometryBoundsFunction(owner.get(), &round_bounds, nullptr);
  rtcSetGeometryIntersectFunction(owner.get(), &round_intersect);
  rtcSetGeometryOccludedFunction(owner.get(), &round_occluded);
  attach(tree, owner, round.geometry);
}

}  // namespace uwsim
