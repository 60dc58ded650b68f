#include "uwsim/acoustics/absorption_column.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"

namespace uwsim {
namespace {

constexpr double kDeepest_m = 12000;  // deeper than any ocean

/// Returns `bottom_m` if it and `knots` are valid.
double checked(double bottom_m, int knots) {
  require(bottom_m > 0 && bottom_m <= kDeepest_m, "absorption.bottom_m", with_unit(bottom_m, "m"),
          "must be in (0, 12000] m");
  require(knots >= 2, "absorption.knots", knots, "must be at least 2");
  return bottom_m;
}

}  // namespace

AbsorptionColumn::Part::Part(const std::function<double(double)>& absorption_db_km, double top, double bottom_m,
                             int knots, double down_to_top_db)
    : top_m(top), spacing_m((bottom_m - top) / (knots - 1)), per_spacing_1_m(1 / spacing_m) {
  for (int k = 0; k < knots; ++k) {
    at_db_m.push_back(absorption_db_km(std::min(top + k * spacing_m, kDeepest_m)) / 1000);
    down_db.push_back(k == 0 ? down_to_top_db : down_db.back() + 0.5 * spacing_m * (at_db_m[k - 1u] + at_db_m.back()));
  }
}

double AbsorptionColumn::Part::at(double depth_m) const {
  const double place = std::clamp((depth_m - top_m) * per_spacing_1_m, 0.0, static_cast<double>(at_db_m.size() - 1));
  const auto k = std::min(static_cast<std::size_t>(place), at_db_m.size() - 2);
  const double part = place - static_cast<double>(k);
  return at_db_m[k] + part * (at_db_m[k + 1] - at_db_m[k]);
}

double AbsorptionColumn::Part::down_to(double depth_m) const {
  const double place = std::max(0.0, (depth_m - top_m) * per_spacing_1_m);
  const auto k = static_cast<std::size_t>(std::min(place, static_cast<double>(at_db_m.size() - 1)));
  const double below_m = depth_m - top_m - static_cast<double>(k) * spacing_m;
  const std::size_t next = std::min(k + 1, at_db_m.size() - 1);
  const double rise = 0.5 * below_m * per_spacing_1_m * (at_db_m[next] - at_db_m[k]);
  return down_db[k] + below_m * (at_db_m[k] + rise);
}

AbsorptionColumn::AbsorptionColumn(const std::function<double(double)>& absorption_db_km, double bottom_m, int knots)
    : above_(absorption_db_km, 0, checked(bottom_m, knots), knots, 0),
      below_(absorption_db_km, bottom_m, std::max(kDeepest_m, bottom_m + 1), knots, above_.down_db.back()) {}

double AbsorptionColumn::at_db_m(double depth_m) const { return part_of(depth_m).at(depth_m); }

double AbsorptionColumn::down_to_db(double depth_m) const { return part_of(depth_m).down_to(depth_m); }

double AbsorptionColumn::mean_db_m(double from_depth_m, double to_depth_m) const {
  return mean_db_m(from_depth_m, down_to_db(from_depth_m), to_depth_m);
}

double AbsorptionColumn::mean_db_m(double from_depth_m, double down_to_from_db, double to_depth_m) const {
  const double down_m = to_depth_m - from_depth_m;
  // On a nearly level path, subtracting the two integrals would lose precision.
  if (std::abs(down_m) < 0.01 * above_.spacing_m) return at_db_m(0.5 * (from_depth_m + to_depth_m));
  return (down_to_db(to_depth_m) - down_to_from_db) / down_m;
}

}  // namespace uwsim
