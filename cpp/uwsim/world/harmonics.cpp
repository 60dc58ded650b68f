#include "uwsim/world/harmonics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "uwsim/world/field_number.h"

namespace uwsim {
namespace {

constexpr double kWindow_rad = 2e-4;  // half of it to the fourth power, over 4!, is 4e-18; of M2, a window of 1.4 s
constexpr std::size_t kTerms = 4;
constexpr double kSlowest_rad_s = 1e-9;

}  // namespace

/// The longer half-axis of the ellipse of the two quantities.
double Harmonic::largest() const {
  const double half = 0.5 * (cosine.square().sum() + sine.square().sum());
  const double area = cosine(0) * sine(1) - cosine(1) * sine(0);
  return std::sqrt(half + std::sqrt(std::max(0.0, half * half - area * area)));
}

struct HarmonicSum::Series {
  std::uint64_t number = 0;  ///< of the sum; 0: none
  double from_s = 0, until_s = 0;
  double middle_s = 0;
  std::array<Eigen::Array2d, kTerms> terms;  ///< of the powers of the time since the middle
};

HarmonicSum::HarmonicSum(std::vector<Harmonic> harmonics)
    : harmonics_(std::move(harmonics)), number_(next_field_number()) {
  double fastest_rad_s = kSlowest_rad_s;
  for (const Harmonic& each : harmonics_) {
    fastest_rad_s = std::max(fastest_rad_s, std::abs(each.speed_rad_s));
    bound_ += each.largest();
  }
  window_s_ = kWindow_rad / fastest_rad_s;
}

HarmonicSum::Series HarmonicSum::series(double time_s) const {
  double window = std::floor(time_s / window_s_);
  if (time_s < window * window_s_) --window;  // the quotient was rounded
  if (time_s >= (window + 1) * window_s_) ++window;
  Series found{number_, window * window_s_, (window + 1) * window_s_, (window + 0.5) * window_s_, {}};
  found.terms.fill(Eigen::Array2d::Zero());
  for (const Harmonic& each : harmonics_) {
    const double cosine = std::cos(each.speed_rad_s * found.middle_s),
                 sine = std::sin(each.speed_rad_s * found.middle_s);
    Eigen::Array2d here = cosine * each.cosine + sine * each.sine, ahead = cosine * each.sine - sine * each.cosine;
    double share = 1;  // speed^k / k!
    for (std::size_t k = 0; k < kTerms; ++k) {
      found.terms[k] += share * here;
      share *= each.speed_rad_s / static_cast<double>(k + 1);
      here = std::exchange(ahead, -here);
    }
  }
  return found;
}

HarmonicSum::Sample HarmonicSum::at(double time_s) const {
  static thread_local struct {
    std::array<Series, 4> series;
    std::size_t oldest = 0;
  } kept;
  const Series* found = kept.series.data();
  while (found->number != number_ || time_s < found->from_s || time_s >= found->until_s) {
    if (++found != kept.series.data() + kept.series.size()) continue;
    found = &(kept.series[kept.oldest] = series(time_s));
    kept.oldest = (kept.oldest + 1) % kept.series.size();
    break;
  }
  const double since_s = time_s - found->middle_s;
  Sample sum{found->terms[kTerms - 1], Eigen::Array2d::Zero()};
  for (std::size_t k = kTerms - 1; k-- > 0;) {
    sum.rate_1_s = since_s * sum.rate_1_s + sum.value;
    sum.value = since_s * sum.value + found->terms[k];
  }
  return sum;
}

}  // namespace uwsim
