#include "uwsim/rays/exact_cast.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "uwsim/rays/embree_cast.h"
#include "uwsim/rays/embree_query.h"
#include "uwsim/rays/ray_lanes.h"
#include "uwsim/rays/terrain_walk.h"

// The steps of casting an exact ray, in order; README.md illustrates them.
//
//   1. cast       Embree reports the surface that each of sixteen rays hits first, in float
//   2. locate     find the location of the terrain triangles' heights, and prefetch them
//   3. refine     intersect the terrain triangles again in double, sixteen at a time
//   4. classify   most rays over open terrain are now finished, as are those that hit nothing
//   5. resolve    every other ray separately, in double: the cases in which a hit is certain without a search
//   6. search     the remaining rays: try all surfaces within the error of the hit; if none is hit, continue behind it

namespace uwsim {
namespace {

constexpr std::size_t kTogether = 4;    // packets; heights are fetched from memory while the next packets are cast
constexpr std::size_t kFewSolids = 16;  // up to this many solids near a cell are tried one at a time
// Number of candidates that a ray may pass before it is assumed to miss all solids
constexpr int kMostTurns = 64;

class ExactCast {
 public:
  explicit ExactCast(const TileTrees& tile) : tile_(tile), surfaces_(tile.surfaces), kernels_(tile.kernels) {}

  void cast(const ExactRays& rays, const double* starts_m, ExactHits& hits) const {
    Answer answer;
    find(rays, starts_m, answer);
    finish(answer, rays, starts_m, hits);
  }

  void cast(std::span<const ExactRays> rays, std::span<ExactHits> hits) const {
    std::array<Answer, kTogether> answers;
    for (std::size_t first = 0; first < rays.size(); first += kTogether) {
      const std::size_t last = std::min(first + kTogether, rays.size());
      for (std::size_t k = first; k < last; ++k) find(rays[k], nullptr, answers[k - first]);
      for (std::size_t k = first; k < last; ++k) finish(answers[k - first], rays[k], nullptr, hits[k]);
    }
  }

 private:
  /// The intermediate results of a packet.
  struct Answer {
    FloatAnswer embree;
    std::uint32_t low_starts;  ///< bit mask of lanes that do not start clearly above the terrain
  };

  /// Steps 1 and 2.
  void find(const ExactRays& rays, const double* starts_m, Answer& answer) const {
    answer.low_starts = tile_.block.heights_m != nullptr ? low_starts(rays, starts_m) : 0;
    cast_in_float(tile_.tree.get(), surfaces_, rays, starts_m, answer.embree);
    if (answer.embree.any_terrain) kernels_.locate_heights(tile_.block, answer.embree.terrain);
  }

  /// Finds rays with low starts. Embree intersects the raised terrain, which rays from above hit before the true
  /// terrain. A ray that starts below the raised terrain, or just above it, may hit the true terrain before anything
  /// that Embree reports.
  std::uint32_t low_starts(const ExactRays& rays, const double* starts_m) const {
    alignas(64) std::array<std::int32_t, kPacketRays> low;
    starts_m == nullptr ? kernels_.find_low_starts(tile_.block, lanes_of(rays), low.data()) : low.fill(-1);
    std::int32_t any = 0;
    for (std::size_t k = 0; k < kPacketRays; ++k) any |= low[k] &= rays.active[k];
    std::uint32_t bits = 0;
    for (std::size_t k = 0; any != 0 && k < kPacketRays; ++k) bits |= static_cast<std::uint32_t>(low[k] & 1) << k;
    return bits;
  }

  /// Steps 3 to 6.
  void finish(const Answer& answer, const ExactRays& rays, const double* starts_m, ExactHits& hits) const {
    alignas(64) std::array<std::int32_t, kPacketRays> met;
    refine(answer.embree, rays, met, hits);
    for (std::uint32_t left = classify(answer, met, hits); left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      resolve(answer, rays, starts_m, lane, met[lane] != 0, hits);
    }
  }

  /// Step 3. `met`: -1 where the ray hits the terrain triangle that Embree reported, away from its edges, else 0.
  void refine(const FloatAnswer& embree, const ExactRays& rays, std::array<std::int32_t, kPacketRays>& met,
              ExactHits& hits) const {
    if (!embree.any_terrain) {
      met.fill(0);
      set_all_missed(hits);
      return;
    }
    kernels_.refine_terrain(
        tile_.block, embree.terrain, lanes_of(rays),
        {hits.distance_m.data(), hits.normal_x.data(), hits.normal_y.data(), hits.normal_z.data(), met.data()});
  }

  /// Step 4. Labels hits on open terrain. Returns a bit mask of the lanes that are not finished, because they hit
  /// anything else or have low starts.
  std::uint32_t classify(const Answer& answer, const std::array<std::int32_t, kPacketRays>& met,
                         ExactHits& hits) const {
    const bool done = kernels_.label_terrain(answer.embree.geometry.data(), TileSurfaces::kOpenTerrain, met.data(),
                                             hits.label.data());
    std::uint32_t left = answer.low_starts;
    for (std::size_t k = 0; !done && k < kPacketRays; ++k) {
      const bool open = answer.embree.geometry[k] != kNoGeometry && hits.label[k] == kNothing;
      left |= static_cast<std::uint32_t>(open) << k;
    }
    return left;
  }

  /// Step 5, for one ray. `refined`: whether step 3 found the ray's hit on the terrain triangle that Embree reported;
  /// if so, `hits` contains that hit.
  void resolve(const Answer& answer, const ExactRays& rays, const double* starts_m, std::size_t lane, bool refined,
               ExactHits& hits) const {
    const std::optional<Candidate> candidate = candidate_of(answer.embree, surfaces_, starts_m, lane);
    TerrainWalk terrain{.hit = {}, .clear_to_m = 0};  // so far, nothing is known about the terrain up to the candidate

    // 5a. From a low start, walk along the terrain until the ray is clear of it.
    if ((answer.low_starts >> lane & 1) != 0) {
      terrain = walk_terrain(surfaces_, ray_of(rays, lane), starts_m != nullptr ? starts_m[lane] : 0);
      if (terrain.began_low) return search(rays, lane, starts_m, candidate, terrain, hits);
    }
    if (!candidate) return;
    const auto [geometry, primitive, distance_m] = *candidate;

    // 5b. Terrain hit away from its triangle's edges: only a nearby solid can be hit earlier.
    if (geometry == TileSurfaces::kOpenTerrain && refined) {
      hits.label[lane] = kTerrain;
      return;
    }
    if (geometry == TileSurfaces::kTerrainNearSolids && refined &&
        surfaces_.solids_near(primitive).size() <= kFewSolids) {
      hits.label[lane] = kTerrain;
      return prefer_solids_before(rays, lane, primitive, hits);
    }

    // 5c. A round shape with no mesh close to it: Embree's callback has computed the hit in double.
    const bool round = surfaces_.is_round(geometry);
    if (round && !tile_.is_crowded(geometry, primitive)) {
      const ExactHits& exact = answer.embree.round;
      return keep(hits, lane, {exact.distance_m[lane], normal_of(exact, lane), true}, TileSurfaces::label(geometry),
                  rays.far_m[lane]);
    }

    // 5d. Terrain hit near an edge or not at all: walk from the point where the raised terrain was hit.
    const TileRay ray = ray_of(rays, lane);
    if (TileSurfaces::is_terrain(geometry)) {
      terrain = walk_terrain(surfaces_, ray, std::max(0.0, distance_m));
      if (terrain.hit && !terrain.near_solids) return keep(hits, lane, *terrain.hit, kTerrain, ray.far_m);
    }

    // 5e. A solid's triangle with only its neighbours close to it, hit away from its edges.
    if (geometry > kTerrain && !round && !tile_.is_crowded(geometry, primitive)) {
      const auto hit = surfaces_.meet(geometry, primitive, ray);
      if (hit && hit->clear_of_edges && hit->distance_m >= 0) {
        return keep(hits, lane, *hit, TileSurfaces::label(geometry), ray.far_m);
      }
    }
    search(rays, lane, starts_m, candidate, terrain, hits);
  }

  /// For 5b: replaces the hit if a nearby solid is hit first. Embree may have reported the terrain although a solid is
  /// nearer, by less than float's error.
  void prefer_solids_before(const ExactRays& rays, std::size_t lane, std::uint32_t triangle_near_solids,
                            ExactHits& hits) const {
    const TileRay ray = ray_of(rays, lane);
    for (const TileMember& solid : surfaces_.solids_near(triangle_near_solids)) {
      const auto hit = surfaces_.meet(solid.geometry, solid.primitive, ray);
      if (!hit || hit->distance_m < 0 || hit->distance_m >= hits.distance_m[lane]) continue;
      set_hit(hits, lane, std::max(0.0, hit->distance_m), hit->normal_world, TileSurfaces::label(solid.geometry));
    }
  }

  /// Step 6. Proceeds from candidate to candidate until it finds a true hit before which nothing else can be hit.
  /// Embree may report a solid too early or wrongly (because triangles are widened), and the terrain too early or not
  /// at all (for a ray between the raised terrain and the true terrain). `terrain`: the result of the walk along the
  /// ray so far.
  void search(const ExactRays& rays, std::size_t lane, const double* starts_m, std::optional<Candidate> candidate,
              TerrainWalk terrain, ExactHits& hits) const {
    const Tolerances& tolerances = surfaces_.tolerances();
    TileRay ray = ray_of(rays, lane);
    const double far_m = ray.far_m;
    for (int turn = 0; candidate && turn < kMostTurns; ++turn) {
      const double at_m = candidate->distance_m;
      if (TileSurfaces::is_terrain(candidate->geometry)) {
        // The candidate is on the raised terrain: the true terrain is behind it, unless a walk has already passed this
        // point.
        if (!terrain.hit && at_m >= terrain.clear_to_m) terrain = walk_terrain(surfaces_, ray, std::max(0.0, at_m));
      } else {
        // The candidate is a solid: the first hit among all nearby surfaces is the true one, unless the ray hits the
        // terrain first.
        const double error_m = tolerances.hit_error_along_m(sine_at(*candidate, ray));
        const Eigen::Vector3d point = ray.origin_world_m + at_m * ray.direction_world;
        const auto solid = first_hit_around(tile_.tree.get(), surfaces_, point, error_m, ray,
                                            std::max(0.0, at_m - error_m), at_m + error_m);
        if (solid && !(terrain.hit && terrain.hit->distance_m <= solid->hit.distance_m)) {
          return keep(hits, lane, solid->hit, solid->label, far_m);
        }
      }
      // After a terrain hit, only surfaces that float's error may have moved behind the terrain can still be hit first.
      if (terrain.hit) {
        ray.far_m = std::min(ray.far_m, terrain.hit->distance_m + tolerances.hit_error_along_m(kGrazingSine));
      }
      candidate = next_candidate(tile_.tree.get(), surfaces_, rays, lane, ray, at_m, starts_m);
    }
    terrain.hit ? keep(hits, lane, *terrain.hit, kTerrain, far_m) : set_miss(hits, lane);
  }

  /// The sine of the angle between a ray and the triangle that it may have hit, but at least the sine of 0.1 degree.
  /// For a round shape, it is this minimum: hits on the shape are exact, but a mesh close to it may be hit at any
  /// angle.
  double sine_at(const Candidate& candidate, const TileRay& ray) const {
    if (surfaces_.is_round(candidate.geometry)) return kGrazingSine;
    const Corners t = surfaces_.corners(candidate.geometry, candidate.primitive);
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).stableNormalized();
    return std::max(kGrazingSine, std::abs(normal.dot(ray.direction_world)));
  }

  /// Sets a lane's hit, or a miss if the hit is beyond the ray's end.
  static void keep(ExactHits& hits, std::size_t lane, const TileHit& hit, Label label, double far_m) {
    if (!(hit.distance_m <= far_m)) return set_miss(hits, lane);
    set_hit(hits, lane, std::max(0.0, hit.distance_m), hit.normal_world, label);
  }

  const TileTrees& tile_;
  const TileSurfaces& surfaces_;
  const RayKernels& kernels_;
};

}  // namespace

void cast_exact(const TileTrees& tile, const ExactRays& rays, const double* starts_m, ExactHits& hits) {
  ExactCast(tile).cast(rays, starts_m, hits);
}

void cast_exact(const TileTrees& tile, std::span<const ExactRays> rays, std::span<ExactHits> hits) {
  ExactCast(tile).cast(rays, hits);
}

}  // namespace uwsim
