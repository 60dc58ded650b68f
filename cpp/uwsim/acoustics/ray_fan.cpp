#include "uwsim/acoustics/ray_fan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwsim {
namespace {

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

}  // namespace

Snell Snell::of(double speed_m_s, double dip_rad) {
  // Exactly 0 for a vertical ray
  const double cosine = dip_rad < 0.5 * std::numbers::pi ? std::cos(dip_rad) : 0;
  return {speed_m_s, std::sin(dip_rad), cosine};
}

double Snell::sine_at(double c) const {
  const double ratio = c / speed_m_s;
  return std::sqrt(std::max(0.0, sine * sine * ratio * ratio + (1 - ratio) * (1 + ratio)));
}

void RayFan::set(const SoundSpeedProfile& profile, const RayEnds& ends) {
  const auto [upper, lower] = std::minmax(ends.from_depth_m, ends.to_depth_m);
  const bool has_bottom = std::isfinite(ends.bottom_m);
  const double last = has_bottom ? ends.bottom_m : std::max(lower, profile.layers().back().top_m);
  double here = 0;
  layers_.clear(), up_.clear(), down_.clear();
  const auto go_to = [&](double depth_m) {
    for (std::size_t k = profile.layer_at(here); here < depth_m; ++k) {
      const SoundLayer& layer = profile.layers()[k];
      const double next = std::min(depth_m, layer.bottom_m);
      layers_.push_back({here, next, layer.at(here), layer.at(next), layer.gradient_1_s});
      here = next;
    }
  };
  go_to(upper);
  between_ = layers_.size();
  go_to(lower);
  below_ = layers_.size();
  go_to(last);

  double passed = std::max(profile.at(upper), profile.at(lower));
  for (std::size_t k = between_; k < below_; ++k) passed = std::max(passed, layers_[k].at_bottom_m_s);
  double fastest = passed;
  for (std::size_t k = between_; k-- > 0; fastest = std::max(fastest, layers_[k].at_top_m_s)) {
    if (layers_[k].at_top_m_s > fastest) up_.push_back({fastest, layers_[k].at_top_m_s, k});
  }
  fastest = passed;
  for (std::size_t k = below_; k < layers_.size(); fastest = std::max(fastest, layers_[k++].at_bottom_m_s)) {
    if (layers_[k].at_bottom_m_s > fastest) down_.push_back({fastest, layers_[k].at_bottom_m_s, k});
  }
  add_bands(passed, has_bottom);
}

void RayFan::add_bands(double passed_m_s, bool has_bottom) {
  std::vector<double>& speeds = speeds_m_s_;
  speeds.clear(), bands_.clear();
  speeds.push_back(passed_m_s);
  for (const auto* turns : {&up_, &down_}) {
    for (const Turn& turn : *turns) speeds.push_back(turn.to_m_s);
  }
  std::sort(speeds.begin(), speeds.end());
  speeds.erase(std::unique(speeds.begin(), speeds.end()), speeds.end());
  const auto turning = [](const std::vector<Turn>& turns, double speed_m_s) {
    return std::find_if(turns.begin(), turns.end(), [&](const Turn& turn) { return turn.to_m_s > speed_m_s; });
  };
  for (std::size_t k = 0; k < speeds.size(); ++k) {
    const double ratio = k + 1 < speeds.size() ? speeds[k] / speeds[k + 1] : 0;
    const auto above = turning(up_, speeds[k]), below = turning(down_, speeds[k]);
    const bool turns_above = above != up_.end(), turns_below = below != down_.end();
    bands_.push_back({speeds[k], std::atan2(std::sqrt((1 - ratio) * (1 + ratio)), ratio), !turns_above,
                      !turns_below && has_bottom, turns_below || has_bottom, turns_above ? above->layer : 0,
                      turns_below ? below->layer + 1 : layers_.size()});
  }
}

RayParts RayFan::sum(const RayBand& band, const Snell& snell, const AbsorptionColumn* absorption, bool all) const {
  RayParts parts;
  const double p = snell.p_s_m();
  double c1 = layers_.empty() ? 0 : layers_[band.top].at_top_m_s;
  double s1 = snell.sine_at(c1);
  for (std::size_t k = band.top; k < band.end; ++k) {
    const Layer& layer = layers_[k];
    RaySum& part = k < between_ ? parts.above : k < below_ ? parts.between : parts.below;
    const double c2 = layer.at_bottom_m_s, s2 = snell.sine_at(c2);
    const bool turns_above = k == band.top && !band.at_surface;
    const bool turns_below = k + 1 == band.end && !band.at_bottom && band.returns && k >= below_;
    if (turns_above || turns_below) {
      const double s = turns_above ? s2 : s1, c = turns_above ? c2 : c1, g = std::abs(layer.gradient_1_s);
      part.across_per_p += s / (p * p * g);
      part.widening -= 1 / (p * p * g * s);
      if (all) {
        const double length = std::atan2(s, p * c) / (p * g), fast = 1 / p,
                     rise = s * s * fast * fast / ((fast + c) * g);
        const double from = turns_above ? layer.bottom_m : layer.top_m, to = from + (turns_above ? -rise : rise);
        part.time_s += std::atanh(s) / g;
        part.length_m += length;
        if (absorption) part.absorbed_db += absorption->mean_db_m(from, to) * length;
      }
    } else {
      const double h = layer.bottom_m - layer.top_m, across_per_p = (c1 + c2) * h / (s1 + s2);
      part.across_per_p += across_per_p;
      part.widening += across_per_p / (s1 * s2);
      if (all) {
        const double slope = h / (s2 * c1 + s1 * c2);
        const double half_turn = 0.5 * std::atan2(p * std::abs(s2 * c1 - s1 * c2), p * p * c1 * c2 + s1 * s2);
        const double length = std::hypot(p * across_per_p, h) * per_sinc(half_turn);
        part.time_s += 2 * slope * atanh_ratio(layer.gradient_1_s * slope);
        part.length_m += length;
        if (absorption) part.absorbed_db += absorption->mean_db_m(layer.top_m, layer.bottom_m) * length;
      }
    }
    c1 = c2, s1 = s2;
  }
  return parts;
}

double RayFan::top_m(const RayBand& band, const Snell& snell) const {
  if (band.at_surface) return 0;
  const Layer& layer = layers_[band.top];
  const double s = snell.sine_at(layer.at_bottom_m_s), fast = 1 / snell.p_s_m();
  return layer.bottom_m - s * s * fast * fast / ((fast + layer.at_bottom_m_s) * std::abs(layer.gradient_1_s));
}

double RayFan::bottom_m(const RayBand& band, const Snell& snell) const {
  const Layer& layer = layers_[band.end - 1];
  if (band.at_bottom || !band.returns) return layer.bottom_m;
  const double s = snell.sine_at(layer.at_top_m_s), fast = 1 / snell.p_s_m();
  return layer.top_m + s * s * fast * fast / ((fast + layer.at_top_m_s) * std::abs(layer.gradient_1_s));
}

}  // namespace uwsim
