#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/acoustics/sound_arc.h"
#include "uwsim/core/float_lanes.h"
#include "uwsim/sonar/bent_kernels.h"

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

#define UWSIM_EIGHT inline __attribute__((always_inline))

// Eight values take one or several of the CPU's registers. (Of wider vectors GCC 12 compares and selects the values one
// by one, with branches.)
constexpr int kParts = kBentTogether * static_cast<int>(sizeof(double)) / kNativeBytes;
constexpr int kEach = kNativeBytes / static_cast<int>(sizeof(double));
using Part = Native<double>::Part;
using MaskPart = decltype(Part{} < Part{});

/// Truth values of eight rays.
struct Mask {
  MaskPart part[kParts];

  UWSIM_EIGHT bool operator[](std::size_t k) const { return part[k / kEach][k % kEach] != 0; }

#define UWSIM_OPERATOR(op)                              \
  friend UWSIM_EIGHT Mask operator op(Mask a, Mask b) { \
    UWSIM_UNROLLED a.part[p] = a.part[p] op b.part[p];  \
    return a;                                           \
  }
  UWSIM_OPERATOR(&)
  UWSIM_OPERATOR(|)
#undef UWSIM_OPERATOR
};

/// Values of eight rays.
struct Eight {
  Part part[kParts];

  UWSIM_EIGHT Eight() { UWSIM_UNROLLED part[p] = Part{}; }
  UWSIM_EIGHT Eight(double value) {  // NOLINT(google-explicit-constructor)
    UWSIM_UNROLLED part[p] = value - Part{};
  }
  explicit UWSIM_EIGHT Eight(const double* from) {
    UWSIM_UNROLLED part[p] = reinterpret_cast<const Native<double>::InMemory*>(from)[p];
  }
  UWSIM_EIGHT void store(double* to) const {
    UWSIM_UNROLLED reinterpret_cast<Native<double>::InMemory*>(to)[p] = part[p];
  }
  UWSIM_EIGHT double operator[](std::size_t k) const { return part[k / kEach][k % kEach]; }

#define UWSIM_OPERATOR(op)                                 \
  friend UWSIM_EIGHT Eight operator op(Eight a, Eight b) { \
    UWSIM_UNROLLED a.part[p] = a.part[p] op b.part[p];     \
    return a;                                              \
  }
#define UWSIM_COMPARISON(op)                              \
  friend UWSIM_EIGHT Mask operator op(Eight a, Eight b) { \
    Mask mask;                                            \
    UWSIM_UNROLLED mask.part[p] = a.part[p] op b.part[p]; \
    return mask;                                          \
  }
  UWSIM_OPERATOR(+)
  UWSIM_OPERATOR(-)
  UWSIM_OPERATOR(*)
  UWSIM_OPERATOR(/)
  UWSIM_COMPARISON(<)
  UWSIM_COMPARISON(>)
  UWSIM_COMPARISON(<=)
  UWSIM_COMPARISON(==)
#undef UWSIM_OPERATOR
#undef UWSIM_COMPARISON
};

UWSIM_EIGHT Mask inverse(Mask mask) {
  UWSIM_UNROLLED mask.part[p] = ~mask.part[p];
  return mask;
}
UWSIM_EIGHT Eight select(Mask mask, Eight yes, Eight no) {
  UWSIM_UNROLLED yes.part[p] = mask.part[p] ? yes.part[p] : no.part[p];
  return yes;
}
UWSIM_EIGHT bool any(Mask mask) {
  MaskPart found = mask.part[0];
  for (int p = 1; p < kParts; ++p) found |= mask.part[p];
#if defined(__AVX512F__)
  using Words = long long __attribute__((vector_size(64)));
  return __builtin_ia32_ptestmq512((Words)found, (Words)found, 0xFF) != 0;
#elif defined(__AVX2__)
  return __builtin_ia32_movmskpd256((Part)found) != 0;
#elif defined(__SSE2__)
  return __builtin_ia32_movmskpd((Part)found) != 0;
#else
  bool some = false;
  for (int k = 0; k < kEach; ++k) some |= found[k] != 0;
  return some;
#endif
}
UWSIM_EIGHT bool all(Mask mask) { return !any(inverse(mask)); }
UWSIM_EIGHT Eight smaller(Eight a, Eight b) { return select(b < a, b, a); }
UWSIM_EIGHT Eight larger(Eight a, Eight b) { return select(a < b, b, a); }
UWSIM_EIGHT Eight square_root(Eight x) {
#if defined(__AVX512F__)
  UWSIM_UNROLLED x.part[p] = __builtin_ia32_sqrtpd512_mask(x.part[p], x.part[p], -1, 4);
#elif defined(__AVX2__)
  UWSIM_UNROLLED x.part[p] = __builtin_ia32_sqrtpd256(x.part[p]);
#elif defined(__SSE2__)
  UWSIM_UNROLLED x.part[p] = __builtin_ia32_sqrtpd(x.part[p]);
#else
  UWSIM_UNROLLED for (int k = 0; k < kEach; ++k) x.part[p][k] = __builtin_sqrt(x.part[p][k]);
#endif
  return x;
}
constexpr long long kSign = static_cast<long long>(1ULL << 63);
UWSIM_EIGHT Eight magnitude(Eight x) {
  UWSIM_UNROLLED x.part[p] = (Part)((MaskPart)x.part[p] & ~kSign);
  return x;
}
UWSIM_EIGHT Eight with_sign(Eight x, Eight sign) {
  UWSIM_UNROLLED x.part[p] = (Part)(((MaskPart)x.part[p] & ~kSign) | ((MaskPart)sign.part[p] & kSign));
  return x;
}
template <typename Series, typename Function>
UWSIM_EIGHT Eight series_or(Mask mask, const Series& series, const Function& function, Eight x, Eight y) {
  Eight value = series();
  if (all(mask)) return value;
#pragma GCC unroll 1
  for (std::size_t k = 0; k < kBentTogether; ++k) {
    if (!mask[k]) value.part[k / kEach][k % kEach] = function(x[k], y[k]);
  }
  return value;
}

using Arcs = Arc<Eight>;
using Points = ArcPoint<Eight>;

UWSIM_EIGHT Arcs load(const ArcRows& rows) {
  return {{Eight(rows.across_m), Eight(rows.depth_m), Eight(rows.dip_rad), Eight(rows.time_s), Eight(rows.length_m)},
          Eight(rows.cosine),
          Eight(rows.sine),
          Eight(rows.snell_s_m),
          Eight(rows.curvature_1_m),
          Eight(rows.top_m),
          Eight(rows.bottom_m),
          Eight(rows.reference_m),
          Eight(rows.speed_m_s),
          Eight(rows.gradient_1_s)};
}
UWSIM_EIGHT void store(ArcRows& rows, const Arcs& arcs) {
  arcs.from.across_m.store(rows.across_m), arcs.from.depth_m.store(rows.depth_m);
  arcs.from.dip_rad.store(rows.dip_rad), arcs.from.time_s.store(rows.time_s), arcs.from.length_m.store(rows.length_m);
  arcs.cosine.store(rows.cosine), arcs.sine.store(rows.sine);
  arcs.snell_s_m.store(rows.snell_s_m), arcs.curvature_1_m.store(rows.curvature_1_m);
  arcs.top_m.store(rows.top_m), arcs.bottom_m.store(rows.bottom_m), arcs.reference_m.store(rows.reference_m);
  arcs.speed_m_s.store(rows.speed_m_s), arcs.gradient_1_s.store(rows.gradient_1_s);
}

// As many 32-bit values as a register holds doubles, anywhere in memory.
using Ints = std::int32_t __attribute__((vector_size(kNativeBytes / 2)));
using Floats = float __attribute__((vector_size(kNativeBytes / 2)));
using IntsInMemory = std::int32_t __attribute__((vector_size(kNativeBytes / 2), aligned(4), may_alias));
using FloatsInMemory = float __attribute__((vector_size(kNativeBytes / 2), aligned(4), may_alias));

UWSIM_EIGHT Mask load_mask(const std::int32_t* from) {
  const auto* const ints = reinterpret_cast<const IntsInMemory*>(from);
  Mask mask;
  UWSIM_UNROLLED mask.part[p] = __builtin_convertvector(ints[p], MaskPart);
  return mask;
}
UWSIM_EIGHT void store_mask(std::int32_t* to, Mask mask) {
  auto* const ints = reinterpret_cast<IntsInMemory*>(to);
  UWSIM_UNROLLED ints[p] = __builtin_convertvector(mask.part[p], Ints);
}
UWSIM_EIGHT Eight load_floats(const float* from) {
  const auto* const floats = reinterpret_cast<const FloatsInMemory*>(from);
  Eight value;
  UWSIM_UNROLLED value.part[p] = __builtin_convertvector(floats[p], Part);
  return value;
}
UWSIM_EIGHT void store_floats(float* to, Eight value) {
  auto* const floats = reinterpret_cast<FloatsInMemory*>(to);
  UWSIM_UNROLLED floats[p] = __builtin_convertvector(value.part[p], Floats);
}
UWSIM_EIGHT Points select(Mask mask, const Points& a, const Points& b) {
  return {select(mask, a.across_m, b.across_m), select(mask, a.depth_m, b.depth_m), select(mask, a.dip_rad, b.dip_rad),
          select(mask, a.time_s, b.time_s), select(mask, a.length_m, b.length_m)};
}

struct Vectors {
  Eight x, y, z;

  friend UWSIM_EIGHT Vectors operator-(const Vectors& a, const Vectors& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend UWSIM_EIGHT Vectors operator+(const Vectors& a, const Vectors& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend UWSIM_EIGHT Vectors operator*(Eight s, const Vectors& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend UWSIM_EIGHT Vectors operator/(const Vectors& a, Eight s) { return {a.x / s, a.y / s, a.z / s}; }
};
UWSIM_EIGHT Eight dot(const Vectors& a, const Vectors& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
UWSIM_EIGHT Vectors select(Mask mask, const Vectors& a, const Vectors& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

/// Where the rays lead: positions relative to their start.
struct Planes {
  Eight level_x, level_y, start_depth_m;

  UWSIM_EIGHT Planes(const BentRays& rays, double depth_m)
      : level_x(rays.level_x), level_y(rays.level_y), start_depth_m(depth_m) {}

  UWSIM_EIGHT Vectors at(const Points& point) const {
    return {point.across_m * level_x, point.across_m * level_y, start_depth_m - point.depth_m};
  }
  UWSIM_EIGHT Vectors along(const ArcDirection<Eight>& direction) const {
    return {direction.cosine * level_x, direction.cosine * level_y, 0.0 - direction.sine};
  }
};

/// The length of the first arc of a chord, of curvature k: its sag k L^2 / 8 equals that allowed at its end.
UWSIM_EIGHT Eight first_length_m(Eight curvature_1_m, Eight gone_m) {
  const Eight share_m = 4 * kSagShare / curvature_1_m;
  const Eight length_m =
      larger(square_root(8 * kLeastSag_m / curvature_1_m), share_m + square_root(share_m * (share_m + 2 * gone_m)));
  return select(curvature_1_m > 0.0, length_m, kNever_m);
}

/// How much longer a chord may become by an arc of curvature k, if it has a length of `chord_m` and turned by
/// `turn_rad` so far: a path of length L that turns by D in total departs from its chord by less than L D / 4.
UWSIM_EIGHT Eight further_length_m(Eight curvature_1_m, Eight chord_m, Eight turn_rad, Eight sag_m) {
  const Eight left = 4 * sag_m - chord_m * turn_rad, slope = turn_rad + curvature_1_m * chord_m;
  return select(left > 0.0, 2 * left / (slope + square_root(slope * slope + 4 * curvature_1_m * left)), 0.0);
}

/// Moves rays to the ends of their steps. Sets which of them have reached the surface.
UWSIM_EIGHT Mask advance(const SoundLayer* layers, const ArcStep<Eight>& step, Mask moves, BentRays& rays, Arcs& arcs) {
  arcs.from = select(moves, step.end, arcs.from);
  const ArcDirection<Eight> direction = direction_on(arcs, arcs.from);
  arcs.cosine = select(moves, direction.cosine, arcs.cosine);
  arcs.sine = select(moves, direction.sine, arcs.sine);
  const Mask leaves = moves & step.leaves, down = arcs.from.dip_rad > 0.0;
  const Mask surfaces = leaves & inverse(down) & (arcs.top_m <= 0.0), enters = leaves & inverse(surfaces);
  if (!any(enters)) return surfaces;
  store(rays.end, arcs);
  for (std::size_t k = 0; k < kBentTogether; ++k) {
    if (!enters[k]) continue;
    rays.layer[k] += down[k] ? 1 : -1;
    const SoundLayer& layer = layers[rays.layer[k]];
    rays.end.top_m[k] = layer.top_m, rays.end.bottom_m[k] = layer.bottom_m;
    rays.end.reference_m[k] = layer.reference_m;
    rays.end.speed_m_s[k] = layer.speed_m_s, rays.end.gradient_1_s[k] = layer.gradient_1_s;
    rays.end.curvature_1_m[k] = -rays.end.snell_s_m[k] * layer.gradient_1_s;
  }
  arcs = load(rays.end);
  return surfaces;
}

/// The step to the maximum time where that comes first.
UWSIM_EIGHT void end_in_time(const Arcs& arcs, Eight left_s, Mask late, ArcStep<Eight>& step) {
  const Eight length_m = length_after(arcs, select(late, left_s, 0.0));
  step.end = select(late, point_ahead(arcs, length_m), step.end);
  step.leaves = step.leaves & inverse(late);
}

__attribute__((flatten)) void next_chords(const SoundLayer* layers, double start_depth_m, double time_max_s,
                                          BentRays& rays, const ChordRows& chords) {
  Arcs end = load(rays.end);
  const Points start = end.from;
  Eight turn_rad = 0.0, count = 0.0;
  Mask grows = inverse(load_mask(rays.done)), surfaces{};
  for (std::size_t piece = 0; piece < kPiecesMax; ++piece) {
    const Eight curvature = magnitude(end.curvature_1_m), chord_m = end.from.length_m - start.length_m;
    const Eight sag_m = larger(kLeastSag_m, kSagShare * end.from.length_m);
    const Eight most_m =
        piece == 0 ? first_length_m(curvature, start.length_m) : further_length_m(curvature, chord_m, turn_rad, sag_m);
    grows = grows & (most_m > 0.1 * chord_m);  // otherwise another piece is not worth it
    if (!any(grows)) break;
    const Eight left_s = time_max_s - end.from.time_s;
    ArcStep<Eight> step = next_step(end, select(grows, smaller(most_m, kFastest_m_s * left_s), 0.0));
    const Mask late = grows & (step.end.time_s > time_max_s);
    if (any(late)) end_in_time(end, left_s, late, step);
    const Eight length_m = step.end.length_m - end.from.length_m;
    grows = grows & (length_m > kShortest_m);
    if (!any(grows)) break;
    store(rays.pieces[piece], end);
    count = select(grows, count + 1, count);
    turn_rad = select(grows, turn_rad + curvature * length_m, turn_rad);
    surfaces = surfaces | advance(layers, step, grows, rays, end);
    grows = grows & step.leaves & inverse(surfaces);
  }
  store(rays.end, end);
  const Mask active = count > 0.0;
  const Planes planes(rays, start_depth_m);
  const Vectors from = planes.at(start), along = planes.at(end.from) - from;
  const Eight chord_m = square_root(dot(along, along));
  const Vectors direction = along / chord_m;
  count.store(rays.count), chord_m.store(rays.chord_m);
  store_mask(rays.surfaces, surfaces), store_mask(rays.done, inverse(active));
  store_floats(chords.origin_x, from.x), store_floats(chords.origin_y, from.y), store_floats(chords.origin_z, from.z);
  store_floats(chords.direction_x, direction.x), store_floats(chords.direction_y, direction.y);
  store_floats(chords.direction_z, direction.z), store_floats(chords.far_m, chord_m + kOverlap_m);
  store_mask(chords.active, active);
}

__attribute__((flatten)) void place_hits(const BentRays& rays, double start_depth_m, const ChordHits& hits,
                                         PathHits& placed) {
  const Planes planes(rays, start_depth_m);
  const Mask found = load_mask(hits.found);
  const Eight count(rays.count), distance_m = select(found, load_floats(hits.distance_m), 0.0);
  const Arcs end = load(rays.end);
  Arcs path = load(rays.pieces[0]);
  const Vectors from = planes.at(path.from), along = (planes.at(end.from) - from) / Eight(rays.chord_m);
  // The piece with the hit: it begins before the hit, and the next one behind it.
  Eight begin_m = dot(planes.at(path.from) - from, along), end_m = dot(planes.at(end.from) - from, along);
  Eight end_length_m = end.from.length_m;
  Mask looks = found;
  for (std::size_t piece = 1; piece < kPiecesMax; ++piece) {
    looks = looks & (Eight(static_cast<double>(piece)) < count);
    if (!any(looks)) break;
    const Arcs next = load(rays.pieces[piece]);
    const Eight place_m = dot(planes.at(next.from) - from, along);
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
  const Eight share = smaller(larger((distance_m - begin_m) / (end_m - begin_m), 0.0), 1.0);
  Eight ahead_m = select(found, share * (end_length_m - path.from.length_m), 0.0);
  const Vectors met = from + distance_m * along;
  const Vectors towards = {load_floats(hits.normal_x), load_floats(hits.normal_y), load_floats(hits.normal_z)};
  const Vectors normal = towards / square_root(dot(towards, towards));
  const Vectors plane = select(magnitude(dot(normal, along)) > kGrazing, normal, along);
  // One step of Newton's method: over the distance that is left, the path bends by less than half a millimetre.
  const Points near = point_ahead(path, ahead_m);
  const Vectors onward = planes.along(direction_on(path, near));
  ahead_m = select(found, ahead_m + dot(plane, met - planes.at(near)) / dot(plane, onward), 0.0);
  const Points arrival = point_ahead(path, ahead_m);
  const Vectors point = planes.at(arrival), arriving = planes.along(direction_on(path, arrival));
  arrival.length_m.store(placed.length_m), arrival.time_s.store(placed.time_s);
  point.x.store(placed.x), point.y.store(placed.y), point.z.store(placed.z);
  arriving.x.store(placed.arrival_x), arriving.y.store(placed.arrival_y), arriving.z.store(placed.arrival_z);
}

constexpr BentKernels kKernels{&next_chords, &place_hits};

}  // namespace
}  // namespace uwsim
