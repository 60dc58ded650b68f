#include "uwsim/acoustics/modem/eigenrays.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "uwsim/core/check.h"
#include "uwsim/core/infinity.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

constexpr int kIterations = 100;
constexpr double kExact = 1e-13;  // relative error of a ray's launch angle
// Legs flatter than this are treated as if they had this slope, which changes their length by 5e-15
constexpr double kLevel = 1e-7;

/// atanh(x) / x
double atanh_ratio(double x) {
  const double q = x * x;
  return std::abs(x) < 0.02 ? 1 + q * (1.0 / 3 + q * (1.0 / 5 + q / 7)) : std::atanh(x) / x;
}

/// x / sin x
double per_sinc(double x) {
  const double q = x * x;
  return std::abs(x) < 0.02 ? 1 + q / 6 * (1 + q * 7 / 60) : x / std::sin(x);
}

/// A ray's Snell invariant, stored as the sine of the ray's dip where the sound speed is greatest: p = sqrt(1 - sine^2)
/// / fastest.
struct Snell {
  double fastest_m_s;
  double sine;

  double p_s_m() const { return std::sqrt((1 - sine) * (1 + sine)) / fastest_m_s; }
  /// The sine of the dip at the depth where the sound speed is c. It is exact where the ray is level.
  double sine_at(double c) const {
    const double ratio = c / fastest_m_s;
    return std::sqrt(std::max(0.0, sine * sine * ratio * ratio + (1 - ratio) * (1 + ratio)));
  }
};

struct LegSum {
  double across_m = 0, time_s = 0, length_m = 0;
};

/// The leg of a ray between two depths, in either order. The ray must not turn between them.
LegSum leg(const SoundSpeedProfile& profile, double depth_m, double other_m, const Snell& snell, bool all) {
  const auto [top, bottom] = std::minmax(depth_m, other_m);
  const double p = snell.p_s_m();
  LegSum sum;
  std::size_t k = profile.layer_at(top);
  double upper = top, c1 = profile.layers()[k].at(top), s1 = snell.sine_at(c1);
  for (; upper < bottom; ++k) {
    const SoundLayer& layer = profile.layers()[k];
    const double lower = std::min(bottom, layer.bottom_m), down = lower - upper;
    const double c2 = layer.at(lower), s2 = snell.sine_at(c2);
    const double across = p * (c1 + c2) * down / (s1 + s2);
    sum.across_m += across;
    if (all) {
      const double slope = down / (s2 * c1 + s1 * c2);
      sum.time_s += 2 * slope * atanh_ratio(layer.gradient_1_s * slope);
      const double half_turn = 0.5 * std::atan2(p * std::abs(s2 * c1 - s1 * c2), p * p * c1 * c2 + s1 * s2);
      sum.length_m += std::hypot(across, down) * per_sinc(half_turn);
    }
    upper = lower, c1 = c2, s1 = s2;
  }
  return sum;
}

/// The greatest speed of sound between two depths.
double fastest_between(const SoundSpeedProfile& profile, double depth_m, double other_m) {
  const auto [top, bottom] = std::minmax(depth_m, other_m);
  double fastest = std::max(profile.at(top), profile.at(bottom));
  for (std::size_t k = profile.layer_at(top) + 1; k < profile.layers().size(); ++k) {
    const SoundLayer& layer = profile.layers()[k];
    if (layer.top_m >= bottom) break;
    if (layer.top_m > top) fastest = std::max(fastest, layer.at(layer.top_m));
  }
  return fastest;
}

/// The depths at which a ray starts, reflects or turns, and ends, in order.
using Depths = std::span<const double>;

double across(const SoundSpeedProfile& profile, Depths depths, const Snell& snell) {
  double sum = 0;
  for (std::size_t k = 1; k < depths.size(); ++k) sum += leg(profile, depths[k - 1], depths[k], snell, false).across_m;
  return sum;
}

/// The root of a continuous function between two points with opposite signs, by the Illinois variant of regula falsi.
template <typename Function>
double root(const Function& f, double a, double fa, double b, double fb) {
  for (int k = 0; k < kIterations && a != b; ++k) {
    double m = (a * fb - b * fa) / (fb - fa);
    if (!(m > std::min(a, b) && m < std::max(a, b)) || k > 40) m = 0.5 * (a + b);
    const double fm = f(m);
    if (fm == 0 || std::abs(b - a) < 1e-15 * std::abs(b)) return m;
    if ((fm > 0) == (fb > 0)) {
      fa *= 0.5;
    } else {
      a = b, fa = fb;
    }
    b = m, fb = fm;
    if (std::abs(fm) < kExact) return m;
  }
  return b;
}

Eigenray ray_along(const SoundSpeedProfile& profile, Depths depths, const Snell& snell) {
  Eigenray ray;
  for (std::size_t k = 1; k < depths.size(); ++k) {
    const LegSum sum = leg(profile, depths[k - 1], depths[k], snell, true);
    ray.time_s += sum.time_s;
    ray.length_m += sum.length_m;
    ray.across_m[static_cast<std::size_t>(ray.legs++)] = sum.across_m;
  }
  const auto dip = [&](double depth_m, double next_m) {
    const double c = profile.at(depth_m);
    return std::copysign(std::atan2(snell.sine_at(c), snell.p_s_m() * c), next_m);
  };
  ray.launch_dip_rad = dip(depths.front(), depths[1] - depths[0]);
  ray.arrival_dip_rad = dip(depths.back(), depths.back() - depths[depths.size() - 2]);
  return ray;
}

/// Finds the ray with no turning point within its legs; returns whether there is one. The search uses the angle
/// atan(rise / across), because it is nearly linear in the ray's dip.
bool monotone(const SoundSpeedProfile& profile, Depths depths, double across_m, Snell& snell) {
  double rise = 0, low = depths[0], high = depths[0];
  for (std::size_t k = 1; k < depths.size(); ++k) {
    rise += std::abs(depths[k] - depths[k - 1]);
    low = std::min(low, depths[k]);
    high = std::max(high, depths[k]);
  }
  snell = {fastest_between(profile, low, high), 1};
  if (across_m <= 0) return true;
  const double wanted = std::atan2(rise, across_m);
  const auto error = [&](double sine) {
    return std::atan2(rise, across(profile, depths, {snell.fastest_m_s, sine})) - wanted;
  };
  const double least = 0.1 * kLevel;
  const double at_least = error(least);
  if (at_least > 0) return false;  // even the flattest leg does not reach far enough
  // Bracket the root close to the straight line's dip if an initial guess shows on which side of the guess the root
  // lies.
  const double guess = std::clamp(std::sin(wanted), 2 * least, 0.999);
  const double at_guess = error(guess);
  double other = at_guess > 0 ? std::max(least, 0.8 * guess) : std::min(1.0, 1.25 * guess);
  double at_other = error(other);
  if ((at_other > 0) == (at_guess > 0)) {
    other = at_guess > 0 ? least : 1.0;
    at_other = at_guess > 0 ? at_least : error(1.0);
  }
  snell.sine = root(error, other, at_other, guess, at_guess);
  return true;
}

/// Finds the direct ray that turns at a depth between `end_m` and `limit_m`, above (sense -1) or below (sense +1) both
/// ends.
bool turning(const SoundSpeedProfile& profile, const RayEnds& ends, int sense, double limit_m, double& turn_m) {
  const double first =
      sense < 0 ? std::min(ends.from_depth_m, ends.to_depth_m) : std::max(ends.from_depth_m, ends.to_depth_m);
  double fastest = fastest_between(profile, ends.from_depth_m, ends.to_depth_m);
  const auto error = [&](double depth_m) {
    const double depths[] = {ends.from_depth_m, depth_m, ends.to_depth_m};
    const double reached = across(profile, depths, {profile.at(depth_m), 0});
    return std::isfinite(reached) ? reached / ends.across_m - 1 : 0;
  };
  double here = first;
  while ((limit_m - here) * sense > 0) {
    std::size_t k = profile.layer_at(here);
    if (sense < 0 && here <= profile.layers()[k].top_m && k > 0) --k;
    const SoundLayer& layer = profile.layers()[k];
    const double edge = sense < 0 ? std::max(layer.top_m, limit_m) : std::min(layer.bottom_m, limit_m);
    const double edge_speed = layer.at(edge);
    if (edge_speed > fastest) {
      // The depth at which the layer's sound speed first exceeds every speed between the ends, plus a tiny amount, so
      // that the ray can turn there.
      double begin = layer.at(here) >= fastest ? here : here + (fastest - layer.at(here)) / layer.gradient_1_s;
      begin += 1e-9 * (edge - begin);
      const double at_begin = error(begin), at_edge = error(edge);
      if (at_begin <= 0 && at_edge >= 0) {
        turn_m = root(error, begin, at_begin, edge, at_edge);
        return true;
      }
      fastest = edge_speed;
    }
    here = edge;
  }
  return false;
}

void check(const RayEnds& ends) {
  const auto in_water = [&](const char* name, double depth_m) {
    require(depth_m >= 0 && depth_m <= ends.bottom_m && std::isfinite(depth_m), name, with_unit(depth_m, "m"),
            "must be between the surface and the bottom");
  };
  require(ends.bottom_m > 0, "bottom_m", with_unit(ends.bottom_m, "m"), "must be positive");
  in_water("from_depth_m", ends.from_depth_m);
  in_water("to_depth_m", ends.to_depth_m);
  require(ends.across_m >= 0 && ends.across_m <= 1e6, "across_m", with_unit(ends.across_m, "m"),
          "must be in [0, 1e6] m");
}

/// Returns the same ends, moved apart very slightly in depth if necessary, because a level ray in uniform water has no
/// legs along which depth changes.
RayEnds never_level(RayEnds ends) {
  if (std::abs(ends.to_depth_m - ends.from_depth_m) < kLevel * ends.across_m) {
    const double sense = ends.from_depth_m + kLevel * ends.across_m <= ends.bottom_m ? 1 : -1;
    ends.to_depth_m = ends.from_depth_m + sense * kLevel * ends.across_m;
  }
  return ends;
}

}  // namespace

std::optional<Eigenray> direct_ray(const SoundSpeedProfile& profile, const RayEnds& given) {
  check(given);
  const RayEnds ends = never_level(given);
  const double straight[] = {ends.from_depth_m, ends.to_depth_m};
  if (straight[0] == straight[1]) return Eigenray{};  // both ends coincide
  Snell snell{};
  if (monotone(profile, straight, ends.across_m, snell)) return ray_along(profile, straight, snell);
  for (const int sense : {-1, 1}) {
    double turn = 0;
    const double limit = sense < 0 ? 0 : std::min(ends.bottom_m, profile.layers().back().top_m);
    if (!turning(profile, ends, sense, limit, turn)) continue;
    const double depths[] = {ends.from_depth_m, turn, ends.to_depth_m};
    return ray_along(profile, depths, {profile.at(turn), 0});
  }
  return std::nullopt;
}

std::vector<Eigenray> eigenrays(const SoundSpeedProfile& profile, const RayEnds& given, bool with_bounces) {
  std::vector<Eigenray> found;
  if (const auto direct = direct_ray(profile, given)) found.push_back(*direct);
  const RayEnds ends = never_level(given);
  const double from = ends.from_depth_m, to = ends.to_depth_m;
  Snell snell{};
  const auto bounce = [&](std::initializer_list<double> at) {
    std::vector<double> depths = {from};
    depths.insert(depths.end(), at);
    depths.push_back(to);
    if (!monotone(profile, depths, ends.across_m, snell)) return;
    Eigenray ray = ray_along(profile, depths, snell);
    for (const double depth : at) {
      double& grazing = depth == 0 ? ray.surface_grazing_rad : ray.bottom_grazing_rad;
      grazing = std::asin(std::min(1.0, snell.sine_at(profile.at(depth))));
      ++(depth == 0 ? ray.surface_bounces : ray.bottom_bounces);
    }
    found.push_back(ray);
  };
  if (with_bounces) {
    bounce({0});
    if (std::isfinite(ends.bottom_m)) {
      bounce({ends.bottom_m});
      bounce({0, ends.bottom_m});
      bounce({ends.bottom_m, 0});
    }
  }
  std::sort(found.begin(), found.end(), [](const Eigenray& a, const Eigenray& b) { return a.time_s < b.time_s; });
  return found;
}

}  // namespace uwsim
