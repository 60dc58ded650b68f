#include "uwsim/acoustics/arrivals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <utility>

#include "uwsim/acoustics/modem/bottom_reflection.h"
#include "uwsim/acoustics/ray_family.h"
#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kMostReversals = 1000;
constexpr double kExact = 1e-13;        // relative error of a ray's dip
constexpr double kFlattest_rad = 1e-8;  // steeper than a level ray, whose sums may be infinite
// Ends at nearly the same depth are moved apart by this fraction of their distance, which changes the length by 5e-15
constexpr double kLevel = 1e-7;
constexpr double kNearest_m = 1e-6;
constexpr double kFocusing_db = 6;  // largest focusing assumed in the estimate that ends the search
// Dips, relative to a band's range, between which the distance of a family has at most one extreme
constexpr std::array kDips = {0x1p-27, 0x1p-23, 0x1p-19, 0x1p-14, 0x1p-10, 0x1p-8, 0x1p-7, 0x1p-6,
                              0x1p-5,  0x1p-4,  0x1p-3,  0.1875,  0.25,    0.3125, 0.375,  0.4375,
                              0.5,     0.625,   0.75,    0.8125,  0.875,   0.9375, 0.98,   1.0};

double db(double power) { return 10 * std::log10(power); }

/// The search for arrivals between two points.
class Search {
 public:
  /// Returns the arrivals, sorted by time, until the next call.
  const std::vector<Arrival>& run(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses,
                                  const ArrivalLimits& limits) {
    profile_ = &profile, ends_ = ends, losses_ = losses, limits_ = limits;
    fan_.set(profile, ends);
    if (limits.most_bounces > 0) set_least_loss();
    found_.clear();
    strongest_db_ = -1e9;
    for (const RayBand& band : fan_.bands()) search(band);
    const double least_db = strongest_db_ - limits.within_db;
    std::erase_if(found_, [&](const Arrival& one) { return one.level_db < least_db; });
    if (found_.size() > limits.most) {
      const auto stronger = [](const Arrival& a, const Arrival& b) { return a.level_db > b.level_db; };
      std::sort(found_.begin(), found_.end(), stronger);
      found_.resize(limits.most);
    }
    const auto earlier = [](const Arrival& a, const Arrival& b) {
      return std::pair(a.time_s, a.launch_dip_rad) < std::pair(b.time_s, b.launch_dip_rad);
    };
    std::sort(found_.begin(), found_.end(), earlier);
    return found_;
  }

 private:
  /// The table is kept from call to call, because most calls have the same bottom.
  void set_least_loss() {
    if (least_loss_of_ == losses_.bottom) return;
    least_loss_of_ = losses_.bottom;
    double least = bottom_loss_db(losses_.bottom, 0.5 * kPi);
    for (std::size_t k = least_loss_db_.size(); k-- > 0;) {
      const double grazing = 0.5 * kPi * static_cast<double>(k) / static_cast<double>(least_loss_db_.size());
      least_loss_db_[k] = least = std::min(least, bottom_loss_db(losses_.bottom, grazing));
    }
  }

  void search(const RayBand& band) {
    dips_.clear(), snells_.clear(), parts_.clear();
    for (const double part : kDips) {
      dips_.push_back(std::max(part * band.end_rad, std::min(kFlattest_rad, 1e-3 * band.end_rad)));
      snells_.push_back(Snell::of(band.speed_m_s, dips_.back()));
      parts_.push_back(fan_.parts(band, snells_.back()));
    }
    const bool source_above = ends_.from_depth_m <= ends_.to_depth_m;
    find(band, RayFamily::of(0, !source_above, source_above), !source_above, 0);
    for (int reversals = 1; reversals <= kMostReversals; ++reversals) {
      if (reversals > 1 && !band.returns) break;
      const int at_top = band.at_surface ? reversals / 2 : 0, at_bottom = band.at_bottom ? reversals / 2 : 0;
      if (at_top + at_bottom > limits_.most_bounces) break;
      if (too_weak(band, reversals)) break;
      bool any_reaches = false;
      for (const bool first_up : {true, false}) {
        if (!first_up && !band.returns) continue;
        const RayFamily family = RayFamily::of(reversals, first_up, source_above);
        if (bounces(band, family) > limits_.most_bounces) continue;
        any_reaches |= find(band, family, first_up, reversals);
      }
      if (!any_reaches) break;  // each crossing leads farther away
    }
  }

  static int bounces(const RayBand& band, const RayFamily& family) {
    return (band.at_surface ? family.above / 2 : 0) + (band.at_bottom ? family.below / 2 : 0);
  }

  /// Whether rays that bounce off both boundaries, this often or more often, are all weaker than the limit.
  bool too_weak(const RayBand& band, int reversals) const {
    if (!band.at_surface || !band.at_bottom || found_.empty()) return false;
    const double rise = (reversals - 1) * ends_.bottom_m, dip = 0.5 * std::atan2(rise, ends_.across_m);
    const int bounces = reversals / 2;  // off each boundary, at least
    const double surface = surface_loss_db(losses_.frequency_hz, profile_->at(0), losses_.surface_rms_m, dip);
    const auto steepness = static_cast<std::size_t>(dip / (0.5 * kPi) * static_cast<double>(least_loss_db_.size()));
    const double best = kFocusing_db - db(ends_.across_m * ends_.across_m + rise * rise + 1) -
                        bounces * (least_loss_db_[steepness] + surface);
    return best < strongest_db_ - limits_.within_db;
  }

  /// Adds a family's arrivals in a band; returns whether the distance of any of its rays is at most that of the
  /// receiver.
  bool find(const RayBand& band, const RayFamily& family, bool first_up, int reversals) {
    const double across = ends_.across_m;
    const auto reach = [&](double dip) {
      const Snell snell = Snell::of(band.speed_m_s, dip);
      return RayReach(family, fan_.parts(band, snell), snell, dip);
    };
    const auto at = [&](std::size_t k) { return RayReach(family, parts_[k], snells_[k], dips_[k]); };
    bool reaches = false;
    RayReach last = at(0);
    for (std::size_t k = 1; k < dips_.size(); ++k) {
      const RayReach next = at(k);
      const bool beyond = last.across_m > across;
      reaches |= !beyond;
      if (beyond != (next.across_m > across)) {
        add(band, family, first_up, reversals, root(reach, last, next));
      } else if ((last.slope_m > 0) != (next.slope_m > 0) && (last.slope_m > 0) != beyond) {
        const RayReach extreme = level(reach, last, next);
        if (beyond != (extreme.across_m > across)) {
          reaches = true;
          add(band, family, first_up, reversals, root(reach, last, extreme));
          add(band, family, first_up, reversals, root(reach, extreme, next));
        }
      }
      last = next;
    }
    return reaches || !(last.across_m > across);
  }

  /// The dip, between two others, at which the ray reaches the receiver's distance: Newton's method within a bracket.
  template <typename ReachAt>
  double root(const ReachAt& reach, const RayReach& low, const RayReach& high) const {
    const double across = ends_.across_m;
    if (high.across_m == across) return high.dip_rad;
    double a = low.dip_rad, b = high.dip_rad;
    const bool a_beyond = low.across_m > across;
    RayReach here = std::abs(low.across_m - across) < std::abs(high.across_m - across) ? low : high;
    for (int k = 0; k < 100; ++k) {
      double dip = here.dip_rad - (here.across_m - across) / here.slope_m;
      if (!(dip > a && dip < b) || k > 30) dip = 0.5 * (a + b);
      if (!(dip > a && dip < b)) return here.dip_rad;
      const double step = std::abs(dip - here.dip_rad);
      here = reach(dip);
      ((here.across_m > across) == a_beyond ? a : b) = dip;
      if (step <= kExact * dip || here.across_m == across) break;
    }
    return here.dip_rad;
  }

  /// The extreme of the distance between two dips where its slope has opposite signs.
  template <typename ReachAt>
  static RayReach level(const ReachAt& reach, const RayReach& low, const RayReach& high) {
    double a = low.dip_rad, b = high.dip_rad, slope_a = low.slope_m, slope_b = high.slope_m;
    RayReach here = low;
    for (int k = 0; k < 80 && b - a > 1e-13 * b; ++k) {
      double dip = (a * slope_b - b * slope_a) / (slope_b - slope_a);
      if (!(dip > a && dip < b) || k % 3 == 2) dip = 0.5 * (a + b);
      here = reach(dip);
      if (here.slope_m == 0) break;
      if ((here.slope_m > 0) == (slope_a > 0)) {
        a = dip, slope_a = here.slope_m;
      } else {
        b = dip, slope_b = here.slope_m;
      }
    }
    return here;
  }

  void add(const RayBand& band, const RayFamily& family, bool first_up, int reversals, double dip_rad) {
    const Snell snell = Snell::of(band.speed_m_s, dip_rad);
    const RayParts parts = fan_.all_parts(band, snell, losses_.absorption);
    const RaySum sum = family.sum(parts);
    const bool last_up = first_up == (reversals % 2 == 0);
    const double from_m_s = profile_->at(ends_.from_depth_m), to_m_s = profile_->at(ends_.to_depth_m);
    const double from_sine = snell.sine_at(from_m_s), to_sine = snell.sine_at(to_m_s), p = snell.p_s_m();
    Arrival one;
    const int at_top = family.above / 2, at_bottom = family.below / 2;
    one.surface_bounces = band.at_surface ? at_top : 0;
    one.bottom_bounces = band.at_bottom ? at_bottom : 0;
    one.turns = reversals - one.surface_bounces - one.bottom_bounces;
    one.launch_dip_rad = std::atan2(first_up ? -from_sine : from_sine, p * from_m_s);
    one.arrival_dip_rad = std::atan2(last_up ? -to_sine : to_sine, p * to_m_s);
    one.time_s = sum.time_s;
    one.length_m = sum.length_m;
    one.widening_m2_s = sum.widening;
    add_legs(band, snell, parts, first_up, reversals, one);
    const double length = std::max(sum.length_m, 1.0), wave_number = 2 * kPi * losses_.frequency_hz / to_m_s;
    const double spread = from_m_s * to_m_s / (sum.across_per_p * std::abs(sum.widening) * from_sine * to_sine);
    const double focused = std::cbrt(std::max(1.0, 0.5 * wave_number * length)) / (length * length);
    one.level_db = std::min(0.0, db(std::min(spread, focused))) - sum.absorbed_db;
    const int caustics = one.turns - (sum.widening < 0 ? 1 : 0);
    double phase = kPi * one.surface_bounces - 0.5 * kPi * caustics;
    if (one.surface_bounces > 0) {
      one.level_db -= one.surface_bounces * surface_loss_db(losses_.frequency_hz, profile_->at(0),
                                                            losses_.surface_rms_m, one.top_grazing_rad);
    }
    if (one.bottom_bounces > 0) {
      one.level_db -= one.bottom_bounces * bottom_loss_db(losses_.bottom, one.bottom_grazing_rad);
      phase += one.bottom_bounces * std::arg(bottom_reflection(losses_.bottom, one.bottom_grazing_rad));
    }
    one.phase_rad = std::remainder(phase, 2 * kPi);
    if (one.phase_rad <= -kPi) one.phase_rad = kPi;
    strongest_db_ = std::max(strongest_db_, one.level_db);
    found_.push_back(one);
  }

  void add_legs(const RayBand& band, const Snell& snell, const RayParts& parts, bool first_up, int reversals,
                Arrival& one) const {
    one.top_m = fan_.top_m(band, snell);
    one.bottom_m = fan_.bottom_m(band, snell);
    if (band.at_surface) one.top_grazing_rad = std::asin(std::min(1.0, snell.sine_at(profile_->at(0))));
    if (band.at_bottom) one.bottom_grazing_rad = std::asin(std::min(1.0, snell.sine_at(profile_->at(one.bottom_m))));
    const double p = snell.p_s_m(), above = p * parts.above.across_per_p, between = p * parts.between.across_per_p;
    const double below = p * parts.below.across_per_p;
    const bool source_above = ends_.from_depth_m <= ends_.to_depth_m, last_up = first_up == (reversals % 2 == 0);
    one.first_m = reversals == 0 ? between : (first_up ? above : below) + (first_up != source_above ? between : 0);
    one.last_m = reversals == 0 ? 0 : (last_up ? below : above) + (last_up != source_above ? between : 0);
    one.crossing_m = reversals < 2 ? 0 : above + between + below;
  }

  const SoundSpeedProfile* profile_ = nullptr;
  RayEnds ends_{};
  SoundLosses losses_{};
  ArrivalLimits limits_;
  RayFan fan_;
  std::array<double, 32> least_loss_db_{};  // at the bottom, of all rays at least as steep; evenly spaced dips
  std::optional<FluidBottom> least_loss_of_;
  std::vector<double> dips_;
  std::vector<Snell> snells_;
  std::vector<RayParts> parts_;
  std::vector<Arrival> found_;
  double strongest_db_ = 0;
};

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
  const double least_m = std::max(kNearest_m, kLevel * ends.across_m);
  if (std::abs(ends.to_depth_m - ends.from_depth_m) < least_m) {
    ends.to_depth_m = ends.from_depth_m + (ends.from_depth_m + least_m <= ends.bottom_m ? least_m : -least_m);
  }
  return ends;
}

const std::vector<Arrival>& search(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses,
                                   const ArrivalLimits& limits) {
  thread_local Search search;
  check(ends);
  return search.run(profile, never_level(ends), losses, limits);
}

}  // namespace

std::vector<Arrival> arrivals(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses,
                              const ArrivalLimits& limits) {
  return search(profile, ends, losses, limits);
}

void find_arrivals(const SoundSpeedProfile& profile, const RayEnds& ends, const SoundLosses& losses,
                   const ArrivalLimits& limits, std::vector<Arrival>& found) {
  const auto& all = search(profile, ends, losses, limits);
  found.assign(all.begin(), all.end());
}

std::optional<Arrival> direct_arrival(const SoundSpeedProfile& profile, const RayEnds& ends) {
  constexpr double kAny_hz = 1e4;
  const SoundLosses losses{.frequency_hz = kAny_hz, .bottom = {}};
  const ArrivalLimits limits{.within_db = 1e9, .most_bounces = 0};
  const auto& found = search(profile, ends, losses, limits);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

}  // namespace uwsim
