#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "uwsim/acoustics/sound_arc.h"
#include "uwsim/sonar/bent_kernels.h"
#include "uwsim/sonar/bent_lanes.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

// The largest distance between a chord and its path: a share of the distance travelled to the chord's end, or at least
// a millimetre.
constexpr double kSagShare = 1e-3, kLeastSag_m = 1e-3;
// Chords are cast slightly beyond their ends, so that no surface is missed between two of them.
constexpr double kOverlap_m = 1e-3;
constexpr double kFastest_m_s = 1800;
constexpr double kShortest_m = 1e-9;
// The cosine of the incidence below which the tangent plane does not place a hit along the path.
constexpr double kGrazing = 0.1;

static_assert(kBentTogether % kSome == 0);

template <typename Series, typename Function>
UWSIM_INLINE Reals series_or(Mask mask, const Series& series, const Function& function, Reals x, Reals y) {
  const Reals value = series();
  if (all(mask)) return value;
  alignas(64) double xs[kSome], ys[kSome], values[kSome];
  x.store(xs), y.store(ys), value.store(values);
  for_each(inverse(mask), [&](std::size_t k) { values[k] = function(xs[k], ys[k]); });
  return Reals(values);
}

using Arcs = Arc<Reals>;
using Points = ArcPoint<Reals>;

/// The arcs of some rays, of which `at` is the first.
UWSIM_INLINE Arcs load(const BentRays& rays, const PieceRows& rows, std::size_t at) {
  const auto row = [at](const BentRow& values) { return Reals(values + at); };
  return {{row(rows.across_m), row(rows.depth_m), row(rows.dip_rad), row(rows.time_s), row(rows.length_m)},
          row(rows.cosine),
          row(rows.sine),
          row(rays.snell_s_m),
          row(rows.curvature_1_m),
          row(rays.top_m),
          row(rays.bottom_m),
          row(rows.reference_m),
          row(rows.speed_m_s),
          row(rows.gradient_1_s)};
}
UWSIM_INLINE void store_point(PieceRows& rows, std::size_t at, const Arcs& arcs) {
  arcs.from.across_m.store(rows.across_m + at), arcs.from.depth_m.store(rows.depth_m + at);
  arcs.from.dip_rad.store(rows.dip_rad + at), arcs.from.time_s.store(rows.time_s + at);
  arcs.from.length_m.store(rows.length_m + at);
  arcs.cosine.store(rows.cosine + at), arcs.sine.store(rows.sine + at);
}
UWSIM_INLINE void store_law(PieceRows& rows, std::size_t at, const Arcs& arcs) {
  arcs.curvature_1_m.store(rows.curvature_1_m + at), arcs.reference_m.store(rows.reference_m + at);
  arcs.speed_m_s.store(rows.speed_m_s + at), arcs.gradient_1_s.store(rows.gradient_1_s + at);
}

UWSIM_INLINE Points select(Mask mask, const Points& a, const Points& b) {
  return {select(mask, a.across_m, b.across_m), select(mask, a.depth_m, b.depth_m), select(mask, a.dip_rad, b.dip_rad),
          select(mask, a.time_s, b.time_s), select(mask, a.length_m, b.length_m)};
}

/// Where the rays lead: positions relative to their start.
struct Planes {
  Reals level_x, level_y, start_depth_m;

  UWSIM_INLINE Planes(const BentRays& rays, std::size_t first, double depth_m)
      : level_x(rays.level_x + first), level_y(rays.level_y + first), start_depth_m(depth_m) {}

  UWSIM_INLINE Vectors at(const Points& point) const {
    return {point.across_m * level_x, point.across_m * level_y, start_depth_m - point.depth_m};
  }
  UWSIM_INLINE Vectors along(const ArcDirection<Reals>& direction) const {
    return {direction.cosine * level_x, direction.cosine * level_y, 0.0 - direction.sine};
  }
};

/// The angle in [-pi/2, pi/2] of a sine and its cosine, which is not negative. With x = tan of a half, Moshier's
/// rational approximation of atan (Cephes Mathematical Library, atan.c): errors below 2e-16 of the angle.
UWSIM_INLINE Reals angle_of(Reals sine, Reals cosine) {
  constexpr double kNumerator[] = {-8.750608600031904122785e-1, -1.615753718733365076637e1, -7.500855792314704667340e1,
                                   -1.228866684490136173410e2, -6.485021904942025371773e1};
  constexpr double kDenominator[] = {1.0,
                                     2.485846490142306297962e1,
                                     1.650270098316988542046e2,
                                     4.328810604912902668951e2,
                                     4.853903996359136964868e2,
                                     1.945506571482613964425e2};
  const Reals half = sine / (1 + cosine), size = magnitude(half);
  const Mask steep = size > 0.66;
  const Reals x = select(steep, (size - 1) / (size + 1), size), q = x * x;
  Reals above = kNumerator[0], below = kDenominator[0];
  for (int k = 1; k < 5; ++k) above = above * q + kNumerator[k];
  for (int k = 1; k < 6; ++k) below = below * q + kDenominator[k];
  const Reals angle = x + x * (q * above / below);
  return with_sign(2 * (angle + select(steep, 0.78539816339744830962, 0.0)), sine);
}

UWSIM_INLINE void start_at(std::size_t at, const SoundLayer* layers, const BentStart& from, const DirectionRows& rows,
                           BentRays& rays) {
  const Reals x(rows.x + at), y(rows.y + at), sine = 0.0 - Reals(rows.z + at);
  const Reals across = square_root(x * x + y * y), dip_rad = angle_of(sine, across);
  const Mask level = across > 0.0, rises = sine < 0.0;
  select(level, x / across, 1.0).store(rays.level_x + at), select(level, y / across, 0.0).store(rays.level_y + at);
  // A ray from the surface does not head up, and none starts in air.
  const Reals depth_m = from.depth_m;
  store_mask(rays.done + at, (depth_m < 0.0) | ((depth_m <= 0.0) & (sine <= 0.0)));
  const SoundLayer &above = layers[from.above], &below = layers[from.below];
  const auto ahead = [&](double SoundLayer::*value) { return select(rises, above.*value, below.*value); };
  const Arcs arcs = {{0.0, depth_m, dip_rad, 0.0, 0.0},
                     across,
                     sine,
                     across / from.speed_m_s,
                     (0.0 - across / from.speed_m_s) * ahead(&SoundLayer::gradient_1_s),
                     ahead(&SoundLayer::top_m),
                     ahead(&SoundLayer::bottom_m),
                     ahead(&SoundLayer::reference_m),
                     ahead(&SoundLayer::speed_m_s),
                     ahead(&SoundLayer::gradient_1_s)};
  store_point(rays.end, at, arcs), store_law(rays.end, at, arcs);
  arcs.snell_s_m.store(rays.snell_s_m + at), arcs.top_m.store(rays.top_m + at), arcs.bottom_m.store(rays.bottom_m + at);
  std::fill_n(rays.layer + at, kSome, from.below);
  for_each(rises, [&](std::size_t k) { rays.layer[at + k] = from.above; });
}

__attribute__((flatten)) void start(const SoundLayer* layers, const BentStart& from, const DirectionRows& directions,
                                    BentRays& rays) {
  for (std::size_t at = 0; at < kBentTogether; at += kSome) start_at(at, layers, from, directions, rays);
}

/// The length of the first arc of a chord, of curvature k: its sag k L^2 / 8 equals that allowed at its end.
UWSIM_INLINE Reals first_length_m(Reals curvature_1_m, Reals gone_m) {
  const Reals share_m = 4 * kSagShare / curvature_1_m;
  const Reals length_m =
      larger(square_root(8 * kLeastSag_m / curvature_1_m), share_m + square_root(share_m * (share_m + 2 * gone_m)));
  return select(curvature_1_m > 0.0, length_m, kNever_m);
}

/// How much longer a chord may become by an arc of curvature k, if it has a length of `chord_m` and turned by
/// `turn_rad` so far: a path of length L that turns by D in total departs from its chord by less than L D / 4.
UWSIM_INLINE Reals further_length_m(Reals curvature_1_m, Reals chord_m, Reals turn_rad, Reals sag_m) {
  const Reals left = 4 * sag_m - chord_m * turn_rad, slope = turn_rad + curvature_1_m * chord_m;
  return select(left > 0.0, 2 * left / (slope + square_root(slope * slope + 4 * curvature_1_m * left)), 0.0);
}

/// Moves rays to the ends of their steps. Sets which of them have reached the surface.
UWSIM_INLINE Mask advance(const SoundLayer* layers, const ArcStep<Reals>& step, Mask moves, std::size_t at,
                          BentRays& rays, Arcs& arcs) {
  arcs.from = select(moves, step.end, arcs.from);
  const ArcDirection<Reals> direction = direction_on(arcs, arcs.from);
  arcs.cosine = select(moves, direction.cosine, arcs.cosine);
  arcs.sine = select(moves, direction.sine, arcs.sine);
  const Mask leaves = moves & step.leaves, down = arcs.from.dip_rad > 0.0;
  const Mask surfaces = leaves & inverse(down) & (arcs.top_m <= 0.0), enters = leaves & inverse(surfaces);
  if (!any(enters)) return surfaces;
  PieceRows& rows = rays.end;
  const unsigned downward = bits_of(down);
  for_each(enters, [&](std::size_t k) {
    const std::size_t ray = at + k;
    rays.layer[ray] += (downward >> k & 1) != 0 ? 1 : -1;
    const SoundLayer& layer = layers[rays.layer[ray]];
    rays.top_m[ray] = layer.top_m, rays.bottom_m[ray] = layer.bottom_m;
    rows.reference_m[ray] = layer.reference_m, rows.speed_m_s[ray] = layer.speed_m_s;
    rows.gradient_1_s[ray] = layer.gradient_1_s, rows.curvature_1_m[ray] = -rays.snell_s_m[ray] * layer.gradient_1_s;
  });
  arcs.top_m = Reals(rays.top_m + at), arcs.bottom_m = Reals(rays.bottom_m + at);
  arcs.reference_m = Reals(rows.reference_m + at), arcs.speed_m_s = Reals(rows.speed_m_s + at);
  arcs.gradient_1_s = Reals(rows.gradient_1_s + at), arcs.curvature_1_m = Reals(rows.curvature_1_m + at);
  return surfaces;
}

/// The step to the maximum time where that comes first.
UWSIM_INLINE void end_in_time(const Arcs& arcs, Reals left_s, Mask late, ArcStep<Reals>& step) {
  const Reals length_m = length_after(arcs, select(late, left_s, 0.0));
  step.end = select(late, point_ahead(arcs, length_m), step.end);
  step.leaves = step.leaves & inverse(late);
}

UWSIM_INLINE void next_chords_at(std::size_t at, const SoundLayer* layers, double start_depth_m, double time_max_s,
                                 BentRays& rays, const ChordRows& chords) {
  Mask grows = inverse(load_mask(rays.done + at)), surfaces{};
  if (!any(grows)) {
    store_mask(chords.active + at, grows);
    return;
  }
  Arcs end = load(rays, rays.end, at);
  const Points start = end.from;
  Reals turn_rad = 0.0, count = 0.0;
#pragma GCC unroll 1
  for (std::size_t piece = 0; piece < kPiecesMax; ++piece) {
    const Reals curvature = magnitude(end.curvature_1_m), chord_m = end.from.length_m - start.length_m;
    const Reals sag_m = larger(kLeastSag_m, kSagShare * end.from.length_m);
    const Reals most_m =
        piece == 0 ? first_length_m(curvature, start.length_m) : further_length_m(curvature, chord_m, turn_rad, sag_m);
    grows = grows & (most_m > 0.1 * chord_m);  // otherwise another piece is not worth it
    if (!any(grows)) break;
    const Reals left_s = time_max_s - end.from.time_s;
    ArcStep<Reals> step = next_step(end, select(grows, smaller(most_m, kFastest_m_s * left_s), 0.0));
    const Mask late = grows & (step.end.time_s > time_max_s);
    if (any(late)) end_in_time(end, left_s, late, step);
    const Reals length_m = step.end.length_m - end.from.length_m;
    grows = grows & (length_m > kShortest_m);
    if (!any(grows)) break;
    store_point(rays.pieces[piece], at, end), store_law(rays.pieces[piece], at, end);
    count = select(grows, count + 1, count);
    turn_rad = select(grows, turn_rad + curvature * length_m, turn_rad);
    surfaces = surfaces | advance(layers, step, grows, at, rays, end);
    grows = grows & step.leaves & inverse(surfaces);
  }
  store_point(rays.end, at, end);  // where the law changes, it has been stored
  const Mask active = count > 0.0;
  const Planes planes(rays, at, start_depth_m);
  const Vectors from = planes.at(start), along = planes.at(end.from) - from;
  const Reals chord_m = square_root(dot(along, along));
  const Vectors direction = along / chord_m;
  count.store(rays.count + at), chord_m.store(rays.chord_m + at);
  store_mask(rays.surfaces + at, surfaces), store_mask(rays.done + at, inverse(active));
  store_floats(chords.origin_x + at, from.x), store_floats(chords.origin_y + at, from.y);
  store_floats(chords.origin_z + at, from.z), store_floats(chords.direction_x + at, direction.x);
  store_floats(chords.direction_y + at, direction.y), store_floats(chords.direction_z + at, direction.z);
  store_floats(chords.far_m + at, chord_m + kOverlap_m);
  store_mask(chords.active + at, active);
}

__attribute__((flatten)) void next_chords(const SoundLayer* layers, double start_depth_m, double time_max_s,
                                          BentRays& rays, const ChordRows& chords) {
  for (std::size_t at = 0; at < kBentTogether; at += kSome) {
    next_chords_at(at, layers, start_depth_m, time_max_s, rays, chords);
  }
}

UWSIM_INLINE void place_hits_at(std::size_t at, const BentRays& rays, double start_depth_m, const ChordHits& hits,
                                PathHits& placed) {
  const Planes planes(rays, at, start_depth_m);
  const Mask found = load_mask(hits.found + at);
  const Reals count(rays.count + at), distance_m = select(found, load_floats(hits.distance_m + at), 0.0);
  const Arcs end = load(rays, rays.end, at);
  Arcs path = load(rays, rays.pieces[0], at);
  const Vectors from = planes.at(path.from), along = (planes.at(end.from) - from) / Reals(rays.chord_m + at);
  // The piece with the hit: it begins before the hit, and the next one behind it.
  Reals begin_m = dot(planes.at(path.from) - from, along), end_m = dot(planes.at(end.from) - from, along);
  Reals end_length_m = end.from.length_m;
  Mask looks = found;
  for (std::size_t piece = 1; piece < kPiecesMax; ++piece) {
    looks = looks & (Reals(static_cast<double>(piece)) < count);
    if (!any(looks)) break;
    const Arcs next = load(rays, rays.pieces[piece], at);
    const Reals place_m = dot(planes.at(next.from) - from, along);
    const Mask passes = looks & (place_m <= distance_m), ends = looks & inverse(passes);
    end_m = select(ends, place_m, end_m), end_length_m = select(ends, next.from.length_m, end_length_m);
    begin_m = select(passes, place_m, begin_m);
    path.from = select(passes, next.from, path.from);
    path.cosine = select(passes, next.cosine, path.cosine), path.sine = select(passes, next.sine, path.sine);
    path.curvature_1_m = select(passes, next.curvature_1_m, path.curvature_1_m);
    path.reference_m = select(passes, next.reference_m, path.reference_m);
    path.speed_m_s = select(passes, next.speed_m_s, path.speed_m_s);
    path.gradient_1_s = select(passes, next.gradient_1_s, path.gradient_1_s);
    looks = passes;
  }
  const Reals share = smaller(larger((distance_m - begin_m) / (end_m - begin_m), 0.0), 1.0);
  Reals ahead_m = select(found, share * (end_length_m - path.from.length_m), 0.0);
  const Vectors met = from + distance_m * along;
  const Vectors towards = {load_floats(hits.normal_x + at), load_floats(hits.normal_y + at),
                           load_floats(hits.normal_z + at)};
  const Vectors normal = towards / square_root(dot(towards, towards));
  const Vectors plane = select(magnitude(dot(normal, along)) > kGrazing, normal, along);
  // One step of Newton's method: over the distance that is left, the path bends by less than half a millimetre.
  const Points near = point_ahead(path, ahead_m);
  const Vectors onward = planes.along(direction_on(path, near));
  ahead_m = select(found, ahead_m + dot(plane, met - planes.at(near)) / dot(plane, onward), 0.0);
  const Points arrival = point_ahead(path, ahead_m);
  const Vectors point = planes.at(arrival), arriving = planes.along(direction_on(path, arrival));
  arrival.length_m.store(placed.length_m + at), arrival.time_s.store(placed.time_s + at);
  point.x.store(placed.x + at), point.y.store(placed.y + at), point.z.store(placed.z + at);
  arriving.x.store(placed.arrival_x + at), arriving.y.store(placed.arrival_y + at),
      arriving.z.store(placed.arrival_z + at);
}

__attribute__((flatten)) void place_hits(const BentRays& rays, double start_depth_m, const ChordHits& hits,
                                         PathHits& placed) {
  for (std::size_t at = 0; at < kBentTogether; at += kSome) {
    const Mask found = load_mask(hits.found + at);
    if (any(found)) place_hits_at(at, rays, start_depth_m, hits, placed);
  }
}

constexpr BentKernels kKernels{&start, &next_chords, &place_hits};

}  // namespace
}  // namespace uwsim
