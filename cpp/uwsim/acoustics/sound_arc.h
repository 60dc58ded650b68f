#pragma once

#include <cmath>

/// Closed forms of a ray's arc in a layer of constant gradient; sound_path.h states the law. `Real` is double, or
/// several rays side by side (sonar/bent_kernels_impl.h), each with the same operations in the same order. In an
/// anonymous namespace, because files for several instruction sets include it.
namespace uwsim {
namespace {

/// Below this argument, a series that is exact to the last digit replaces the function: bent rays spend most of their
/// time here.
constexpr double kSmallArc = 0.02;
constexpr double kNever_m = __builtin_inf();

inline double select(bool mask, double yes, double no) { return mask ? yes : no; }
inline bool all(bool mask) { return mask; }
inline bool inverse(bool mask) { return !mask; }
inline double square_root(double x) { return __builtin_sqrt(x); }
inline double magnitude(double x) { return __builtin_fabs(x); }
inline double with_sign(double x, double sign) { return __builtin_copysign(x, sign); }
/// The series where `mask` is true, the function elsewhere.
template <typename Series, typename Function>
double series_or(bool mask, const Series& series, const Function& function, double x, double y) {
  return mask ? series() : function(x, y);
}

template <typename Real>
Real sinc(Real x) {
  const auto series = [&] {
    const Real q = x * x;
    return 1 - q * (1.0 / 6) * (1 - q * (1.0 / 20) * (1 - q * (1.0 / 42)));
  };
  return series_or(
      magnitude(x) < kSmallArc, series, [](double a, double) { return std::sin(a) / a; }, x, x);
}

template <typename Real>
Real cosine_of(Real x) {
  const auto series = [&] {
    const Real q = x * x;
    return 1 - q * 0.5 * (1 - q * (1.0 / 12) * (1 - q * (1.0 / 30)));
  };
  return series_or(
      magnitude(x) < kSmallArc, series, [](double a, double) { return std::cos(a); }, x, x);
}

/// The angle of a turn by its sine and cosine, in [-pi, pi].
template <typename Real>
Real turn(Real sine, Real cosine) {
  const auto series = [&] {
    const Real q = sine * sine;
    return sine * (1 + q * (1.0 / 6 + q * (3.0 / 40 + q * (15.0 / 336))));
  };
  return series_or((magnitude(sine) < kSmallArc) & (cosine > 0.0), series,
                   [](double a, double b) { return std::atan2(a, b); }, sine, cosine);
}

/// atanh(x) / x
template <typename Real>
Real atanhc(Real x) {
  const auto series = [&] {
    const Real q = x * x;
    return 1 + q * (1.0 / 3 + q * (1.0 / 5 + q * (1.0 / 7)));
  };
  return series_or(
      magnitude(x) < kSmallArc, series, [](double a, double) { return std::atanh(a) / a; }, x, x);
}

/// A point on a ray; see SoundState.
template <typename Real>
struct ArcPoint {
  Real across_m, depth_m, dip_rad, time_s, length_m;
};

/// The arc from a point on, and the layer that it is in.
template <typename Real>
struct Arc {
  ArcPoint<Real> from;
  Real cosine, sine;  ///< of the dip
  Real snell_s_m;     ///< cos(dip) / c
  Real curvature_1_m;
  Real top_m, bottom_m, reference_m, speed_m_s, gradient_1_s;  ///< see SoundLayer

  Real speed_at(Real depth_m) const { return speed_m_s + gradient_1_s * (depth_m - reference_m); }
};

/// With q = curvature s / 2, half the turn, and the mean dip m: x = s cos m sinc q, z = s sin m sinc q, and, from the
/// difference of ln tan(dip/2 + pi/4) between the ends, t = 2/g atanh(g s sinc(2q) / (c1 + c2)).
template <typename Real>
ArcPoint<Real> point_ahead(const Arc<Real>& arc, Real length_m) {
  const Real half_turn = 0.5 * arc.curvature_1_m * length_m;
  const Real even = sinc(half_turn), turn_cosine = cosine_of(half_turn), turn_sine = half_turn * even;
  const Real chord_m = length_m * even;
  ArcPoint<Real> next;
  next.across_m = arc.from.across_m + chord_m * (arc.cosine * turn_cosine - arc.sine * turn_sine);
  next.depth_m = arc.from.depth_m + chord_m * (arc.sine * turn_cosine + arc.cosine * turn_sine);
  next.dip_rad = arc.from.dip_rad + 2 * half_turn;
  const Real part = length_m * even * turn_cosine / (arc.speed_at(arc.from.depth_m) + arc.speed_at(next.depth_m));
  next.time_s = arc.from.time_s + 2 * part * atanhc(arc.gradient_1_s * part);
  next.length_m = arc.from.length_m + length_m;
  return next;
}

/// The length to the point where the arc crosses a depth, downwards (sense +1) or upwards (-1).
template <typename Real>
Real length_to_depth(const Arc<Real>& arc, Real depth_m, Real sense) {
  const Real here = arc.speed_at(arc.from.depth_m), down_m = depth_m - arc.from.depth_m;
  const Real faster = arc.gradient_1_s * down_m;
  const Real sine_2 = arc.sine * arc.sine - arc.cosine * arc.cosine * faster * (2 * here + faster) / (here * here);
  const auto turns_before = sine_2 < 0.0;
  const Real sine = sense * square_root(select(turns_before, Real(0.0), sine_2)),
             cosine = arc.snell_s_m * (here + faster);
  const Real half_turn = 0.5 * turn(sine * arc.cosine - cosine * arc.sine, cosine * arc.cosine + sine * arc.sine);
  const Real even = sinc(half_turn);
  const Real rise = arc.sine * cosine_of(half_turn) + arc.cosine * half_turn * even;
  const Real turned = select(arc.curvature_1_m == 0.0, Real(kNever_m), 2 * half_turn / arc.curvature_1_m);
  const Real straight = down_m / (rise * even);
  return select(turns_before, Real(kNever_m), select(magnitude(rise) > 1e-6, straight, turned));
}

/// The length to the end of the layer or to the surface; infinite if the arc never leaves.
template <typename Real>
Real length_to_boundary(const Arc<Real>& arc) {
  const Real top_m = select(arc.top_m < 0.0, Real(0.0), arc.top_m);
  const auto length = [&](const auto& below) {
    const auto exists = (below & (arc.bottom_m < kNever_m)) | (inverse(below) & (arc.bottom_m > 0.0));
    const Real depth_m = select(exists, select(below, arc.bottom_m, top_m), arc.from.depth_m);
    const Real length_m = length_to_depth(arc, depth_m, select(below, Real(1.0), Real(-1.0)));
    return select(exists & (length_m > 1e-9), length_m, Real(kNever_m));
  };
  // An arc that leads down leaves by the bottom, or turns and leaves by the top.
  const auto down = arc.from.dip_rad > 0.0;
  const Real first_m = length(down);
  const auto leaves = first_m < kNever_m;
  return all(leaves) ? first_m : select(leaves, first_m, length(inverse(down)));
}

/// A section of the arc within its layer.
template <typename Real>
struct ArcStep {
  ArcPoint<Real> end;
  decltype(Real() < Real()) leaves;  ///< whether it ends at the layer's boundary or at the surface
};

/// The next step, at most `length_max_m` long; it is shorter if the layer or the water ends first.
template <typename Real>
ArcStep<Real> next_step(const Arc<Real>& arc, Real length_max_m) {
  const Real top_m = select(arc.top_m < 0.0, Real(0.0), arc.top_m);
  // An upper bound for the change in depth over this length: most steps end well within their layer.
  const Real farthest_m = length_max_m * (magnitude(arc.sine) + 0.5 * magnitude(arc.curvature_1_m) * length_max_m);
  const auto inside = (arc.from.depth_m - farthest_m > top_m) & (arc.from.depth_m + farthest_m < arc.bottom_m);
  if (all(inside)) return {point_ahead(arc, length_max_m), inverse(inside)};
  const Real boundary_m = length_to_boundary(arc);
  const auto within = inside | (boundary_m > length_max_m);
  ArcStep<Real> step;
  step.end = point_ahead(arc, select(within, length_max_m, boundary_m));
  step.leaves = inverse(within) & (boundary_m < kNever_m);
  const Real edge_m = select(step.end.dip_rad > 0.0, arc.bottom_m, top_m);
  step.end.depth_m = select(step.leaves, edge_m, step.end.depth_m);
  return step;
}

template <typename Real>
struct ArcDirection {
  Real cosine, sine;  ///< of the dip
};

/// The direction at a point of the arc.
template <typename Real>
ArcDirection<Real> direction_on(const Arc<Real>& arc, const ArcPoint<Real>& point) {
  const Real cosine = arc.snell_s_m * arc.speed_at(point.depth_m), square = 1 - cosine * cosine;
  return {cosine, with_sign(square_root(select(square > 0.0, square, Real(0.0))), point.dip_rad)};
}

/// The distance along the arc that sound travels in `time_s`.
template <typename Real>
Real length_after(const Arc<Real>& arc, Real time_s) {
  Real length_m = arc.speed_at(arc.from.depth_m) * time_s;
  auto done = time_s < -kNever_m;
  // Newton's method: dt/ds is the slowness at the end.
  for (int k = 0; k < 8 && !all(done); ++k) {
    const ArcPoint<Real> there = point_ahead(arc, length_m);
    const Real left_s = time_s - (there.time_s - arc.from.time_s);
    length_m = select(done, length_m, length_m + left_s * arc.speed_at(there.depth_m));
    done = done | (magnitude(left_s) < 1e-15);
  }
  return length_m;
}

}  // namespace
}  // namespace uwsim
