#include "uwsim/acoustics/sound_path.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/infinity.h"

namespace uwsim {
namespace {

/// Below this argument, a series that is exact to the last digit replaces the function: bent rays spend most of their
/// time here.
constexpr double kSmall = 0.02;

double sinc(double x) {
  const double q = x * x;
  return std::abs(x) < kSmall ? 1 - q / 6 * (1 - q / 20 * (1 - q / 42)) : std::sin(x) / x;
}

double cosine_of(double x) {
  const double q = x * x;
  return std::abs(x) < kSmall ? 1 - q / 2 * (1 - q / 12 * (1 - q / 30)) : std::cos(x);
}

/// The angle of a turn by its sine and cosine, in [-pi, pi].
double turn(double sine, double cosine) {
  const double q = sine * sine;
  if (!(std::abs(sine) < kSmall && cosine > 0)) return std::atan2(sine, cosine);
  return sine * (1 + q * (1.0 / 6 + q * (3.0 / 40 + q * (15.0 / 336))));
}

/// atanh(x) / x
double atanhc(double x) {
  const double q = x * x;
  return std::abs(x) < kSmall ? 1 + q * (1.0 / 3 + q * (1.0 / 5 + q * (1.0 / 7))) : std::atanh(x) / x;
}

}  // namespace

SoundPath::SoundPath(const SoundSpeedProfile& profile, double depth_m, double dip_rad)
    : SoundPath(profile, depth_m, dip_rad, std::cos(dip_rad), std::sin(dip_rad)) {}

SoundPath::SoundPath(const SoundSpeedProfile& profile, double depth_m, double dip_rad, double cosine, double sine)
    : profile_(&profile), cosine_(cosine), sine_(sine) {
  state_.depth_m = depth_m;
  state_.dip_rad = dip_rad;
  const std::size_t layer = profile.layer_at(depth_m);
  snell_s_m_ = cosine_ / profile.layers()[layer].at(depth_m);
  // On a boundary, use the layer ahead.
  enter(dip_rad < 0 && layer > 0 && depth_m == profile.layers()[layer].top_m ? layer - 1 : layer);
}

void SoundPath::enter(std::size_t layer) {
  layer_ = layer;
  curvature_1_m_ = -snell_s_m_ * profile_->layers()[layer].gradient_1_s;
}

/// With q = curvature s / 2, half the turn, and the mean dip m: x = s cos m sinc q, z = s sin m sinc q, and, from the
/// difference of ln tan(dip/2 + pi/4) between the ends, t = 2/g atanh(g s sinc(2q) / (c1 + c2)).
SoundState SoundPath::ahead(double length_m) const {
  const SoundLayer& here = layer();
  const double half_turn = 0.5 * curvature_1_m_ * length_m;
  const double even = sinc(half_turn), turn_cosine = cosine_of(half_turn), turn_sine = half_turn * even;
  const double chord_m = length_m * even;
  SoundState next;
  next.across_m = state_.across_m + chord_m * (cosine_ * turn_cosine - sine_ * turn_sine);
  next.depth_m = state_.depth_m + chord_m * (sine_ * turn_cosine + cosine_ * turn_sine);
  next.dip_rad = state_.dip_rad + 2 * half_turn;
  const double part = length_m * even * turn_cosine / (here.at(state_.depth_m) + here.at(next.depth_m));
  next.time_s = state_.time_s + 2 * part * atanhc(here.gradient_1_s * part);
  next.length_m = state_.length_m + length_m;
  return next;
}

double SoundPath::to_boundary_m() const {
  const SoundLayer& in = layer();
  const double top_m = std::max(in.top_m, 0.0);
  const double here = speed_m_s();
  // The length to the point where the arc crosses a depth, downwards (+1) or upwards (-1).
  const auto crossing = [&](double depth_m, int sense) {
    const double down_m = depth_m - state_.depth_m;
    const double faster = in.gradient_1_s * down_m;
    const double sine_2 = sine_ * sine_ - cosine_ * cosine_ * faster * (2 * here + faster) / (here * here);
    if (sine_2 < 0) return kInfinity;  // turns before it reaches the depth
    const double sine = sense * std::sqrt(sine_2), cosine = snell_s_m_ * (here + faster);
    const double half_turn = 0.5 * turn(sine * cosine_ - cosine * sine_, cosine * cosine_ + sine * sine_);
    const double rise = sine_ * cosine_of(half_turn) + cosine_ * half_turn * sinc(half_turn);
    const double turned = curvature_1_m_ == 0 ? kInfinity : 2 * half_turn / curvature_1_m_;
    const double straight = down_m / (rise * sinc(half_turn));
    return std::abs(rise) > 1e-6 ? straight : turned;
  };
  const auto later = [](double length_m) { return length_m > 1e-9 ? length_m : kInfinity; };
  const auto bottom = [&] { return std::isfinite(in.bottom_m) ? later(crossing(in.bottom_m, 1)) : kInfinity; };
  const auto top = [&] { return in.bottom_m > 0 ? later(crossing(top_m, -1)) : kInfinity; };
  // An arc that leads down leaves by the bottom, or turns and leaves by the top.
  const double first_m = state_.dip_rad > 0 ? bottom() : top();
  if (first_m < kInfinity) return first_m;
  return state_.dip_rad > 0 ? top() : bottom();
}

SoundPath::Step SoundPath::step(double length_max_m) const {
  const SoundLayer& in = layer();
  // An upper bound for the change in depth over this length: most steps end well within their layer.
  const double farthest_m = length_max_m * (std::abs(sine_) + 0.5 * std::abs(curvature_1_m_) * length_max_m);
  if (state_.depth_m - farthest_m > std::max(in.top_m, 0.0) && state_.depth_m + farthest_m < in.bottom_m) {
    return {ahead(length_max_m), false};
  }
  const double boundary_m = to_boundary_m();
  if (boundary_m > length_max_m) return {ahead(length_max_m), false};
  Step step{ahead(boundary_m), std::isfinite(boundary_m)};
  if (step.leaves) step.end.depth_m = step.end.dip_rad > 0 ? in.bottom_m : std::max(in.top_m, 0.0);
  return step;
}

SoundPath::Direction SoundPath::direction_at(const SoundState& state) const {
  const double cosine = snell_s_m_ * layer().at(state.depth_m);
  return {cosine, std::copysign(std::sqrt(std::max(0.0, 1 - cosine * cosine)), state.dip_rad)};
}

bool SoundPath::advance(const Step& step) {
  state_ = step.end;
  const Direction direction = direction_at(state_);
  cosine_ = direction.cosine, sine_ = direction.sine;
  if (!step.leaves) return false;
  const bool down = state_.dip_rad > 0;
  if (!down && layer().top_m <= 0) return true;
  enter(down ? layer_ + 1 : layer_ - 1);
  return false;
}

double SoundPath::length_after(double time_s) const {
  double length_m = speed_m_s() * time_s;
  // Newton's method: dt/ds is the slowness at the end.
  for (int k = 0; k < 8; ++k) {
    const SoundState there = ahead(length_m);
    const double left_s = time_s - (there.time_s - state_.time_s);
    length_m += left_s * layer().at(there.depth_m);
    if (std::abs(left_s) < 1e-15) break;
  }
  return length_m;
}

SoundState travel(const SoundSpeedProfile& profile, double depth_m, double dip_rad, double time_s) {
  SoundPath path(profile, depth_m, dip_rad);
  if (depth_m <= 0 && dip_rad <= 0) return path.state();
  for (;;) {
    // The step to the end of the layer. Its length is limited, because the outermost layers have no end.
    const SoundPath::Step whole = path.step(2000 * (time_s - path.state().time_s) + 1);
    if (whole.end.time_s >= time_s || !whole.leaves) return path.ahead(path.length_after(time_s - path.state().time_s));
    if (path.advance(whole)) return path.state();
  }
}

}  // namespace uwsim
