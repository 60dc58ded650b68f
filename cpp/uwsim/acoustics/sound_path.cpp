#include "uwsim/acoustics/sound_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uwsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double sinc(double x) { return std::abs(x) < 1e-4 ? 1 - x * x / 6 : std::sin(x) / x; }

/// atanh(x) / x
double atanhc(double x) { return std::abs(x) < 1e-4 ? 1 + x * x / 3 : std::atanh(x) / x; }

}  // namespace

SoundPath::SoundPath(const SoundSpeedProfile& profile, double depth_m, double dip_rad)
    : profile_(&profile), layer_(profile.layer_at(depth_m)) {
  state_.depth_m = depth_m;
  state_.dip_rad = dip_rad;
  snell_s_m_ = std::cos(dip_rad) / profile.at(depth_m);
  // On a boundary, what lies ahead counts.
  if (dip_rad < 0 && layer_ > 0 && depth_m == profile.layers()[layer_].top_m) --layer_;
}

double SoundPath::curvature_1_m() const { return -snell_s_m_ * profile_->layers()[layer_].gradient_1_s; }

/// With the half turn q = curvature s / 2 and the mean dip m: x = s cos m sinc q, z = s sin m sinc q, and, from
/// ln tan(dip/2 + pi/4) taken between the ends, t = 2/g atanh(g s sinc(2q) / (c1 + c2)).
SoundState SoundPath::ahead(double length_m) const {
  const SoundLayer& layer = profile_->layers()[layer_];
  const double half_turn = 0.5 * curvature_1_m() * length_m;
  const double mean_dip = state_.dip_rad + half_turn;
  const double chord_m = length_m * sinc(half_turn);
  SoundState next;
  next.across_m = state_.across_m + chord_m * std::cos(mean_dip);
  next.depth_m = state_.depth_m + chord_m * std::sin(mean_dip);
  next.dip_rad = state_.dip_rad + 2 * half_turn;
  const double speeds = layer.at(state_.depth_m) + layer.at(next.depth_m);
  const double part = length_m * sinc(2 * half_turn) / speeds;
  next.time_s = state_.time_s + 2 * part * atanhc(layer.gradient_1_s * part);
  next.length_m = state_.length_m + length_m;
  return next;
}

double SoundPath::to_boundary_m() const {
  const SoundLayer& layer = profile_->layers()[layer_];
  const double top_m = std::max(layer.top_m, 0.0);
  const double here = layer.at(state_.depth_m), sine = std::sin(state_.dip_rad), cosine = std::cos(state_.dip_rad);
  const double curvature = curvature_1_m();
  // To the arc's crossing of a depth, leaving it downward (+1) or upward (-1).
  const auto crossing = [&](double depth_m, int way) {
    const double down_m = depth_m - state_.depth_m;
    const double faster = layer.gradient_1_s * down_m;
    const double sine_2 = sine * sine - cosine * cosine * faster * (2 * here + faster) / (here * here);
    if (sine_2 < 0) return kInfinity;  // turns before
    const double dip = way * std::atan2(std::sqrt(sine_2), snell_s_m_ * (here + faster));
    const double half_turn = 0.5 * (dip - state_.dip_rad);
    const double rise = std::sin(state_.dip_rad + half_turn);
    const double turned = curvature == 0 ? kInfinity : 2 * half_turn / curvature;
    const double straight = down_m / (rise * sinc(half_turn));
    return std::abs(rise) > 1e-6 ? straight : turned;
  };
  const auto later = [](double length_m) { return length_m > 1e-9 ? length_m : kInfinity; };
  double length_m = kInfinity;
  if (std::isfinite(layer.bottom_m)) length_m = later(crossing(layer.bottom_m, 1));
  if (layer.bottom_m > 0) length_m = std::min(length_m, later(crossing(top_m, -1)));
  return length_m;
}

bool SoundPath::advance(double length_m) {
  const SoundLayer& layer = profile_->layers()[layer_];
  const bool leaves = length_m >= to_boundary_m();
  state_ = ahead(length_m);
  if (!leaves) return false;
  const bool down = state_.dip_rad > 0;
  state_.depth_m = down ? layer.bottom_m : std::max(layer.top_m, 0.0);
  if (!down && layer.top_m <= 0) return true;
  layer_ += down ? 1 : -1;
  return false;
}

double SoundPath::length_after(double time_s) const {
  const SoundLayer& layer = profile_->layers()[layer_];
  const double here = layer.at(state_.depth_m);
  double length_m = here * time_s;
  // Newton: the path is ridden at the speed of sound there.
  for (int k = 0; k < 8; ++k) {
    const SoundState there = ahead(length_m);
    const double left_s = time_s - (there.time_s - state_.time_s);
    length_m += left_s * layer.at(there.depth_m);
    if (std::abs(left_s) < 1e-15) break;
  }
  return length_m;
}

SoundState travel(const SoundSpeedProfile& profile, double depth_m, double dip_rad, double time_s) {
  SoundPath path(profile, depth_m, dip_rad);
  if (depth_m <= 0 && dip_rad <= 0) return path.state();
  for (;;) {
    const double boundary_m = path.to_boundary_m();
    const bool leaves = std::isfinite(boundary_m) && path.ahead(boundary_m).time_s < time_s;
    if (!leaves) return path.ahead(path.length_after(time_s - path.state().time_s));
    if (path.advance(boundary_m)) return path.state();
  }
}

}  // namespace uwsim
