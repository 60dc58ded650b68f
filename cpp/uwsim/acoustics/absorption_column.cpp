#include "uwsim/acoustics/absorption_column.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {

AbsorptionColumn::AbsorptionColumn(const std::function<double(double)>& absorption_db_km, double bottom_m, int knots) {
  require(bottom_m > 0 && bottom_m <= 12000, "absorption.bottom_m", bottom_m, "must be in (0, 12000] m");
  require(knots >= 2, "absorption.knots", knots, "must be at least 2");
  spacing_m_ = bottom_m / (knots - 1);
  per_spacing_1_m_ = 1 / spacing_m_;
  for (int k = 0; k < knots; ++k) {
    at_db_m_.push_back(absorption_db_km(k * spacing_m_) / 1000);
    down_db_.push_back(k == 0 ? 0 : down_db_.back() + 0.5 * spacing_m_ * (at_db_m_[k - 1u] + at_db_m_.back()));
  }
}

double AbsorptionColumn::at_db_m(double depth_m) const {
  const double place = std::clamp(depth_m * per_spacing_1_m_, 0.0, static_cast<double>(at_db_m_.size() - 1));
  const auto k = std::min(static_cast<std::size_t>(place), at_db_m_.size() - 2);
  const double part = place - static_cast<double>(k);
  return at_db_m_[k] + part * (at_db_m_[k + 1] - at_db_m_[k]);
}

double AbsorptionColumn::down_to_db(double depth_m) const {
  const double place = std::max(0.0, depth_m * per_spacing_1_m_);
  const auto k = static_cast<std::size_t>(std::min(place, static_cast<double>(at_db_m_.size() - 1)));
  const double below_m = depth_m - static_cast<double>(k) * spacing_m_;
  const std::size_t next = std::min(k + 1, at_db_m_.size() - 1);
  const double rise = 0.5 * below_m * per_spacing_1_m_ * (at_db_m_[next] - at_db_m_[k]);
  return down_db_[k] + below_m * (at_db_m_[k] + rise);
}

double AbsorptionColumn::mean_db_m(double from_depth_m, double to_depth_m) const {
  return mean_db_m(from_depth_m, down_to_db(from_depth_m), to_depth_m);
}

double AbsorptionColumn::mean_db_m(double from_depth_m, double down_to_from_db, double to_depth_m) const {
  const double down_m = to_depth_m - from_depth_m;
  // For a nearly level path the difference of the integrals would cancel.
  if (std::abs(down_m) < 0.01 * spacing_m_) return at_db_m(0.5 * (from_depth_m + to_depth_m));
  return (down_to_db(to_depth_m) - down_to_from_db) / down_m;
}

}  // namespace uwsim
