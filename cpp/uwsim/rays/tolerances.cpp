#include "uwsim/rays/tolerances.h"

#include <algorithm>

namespace uwsim {

Tolerances tolerances_of(double diagonal_m, double steepest, bool has_solid_triangles) {
  Tolerances t{};
  t.rounding_m = std::max(kLeastFloatError_m, kFloatError * 0.5 * diagonal_m);
  t.hit_error_m = 8 * t.rounding_m;
  t.widening_m = 64 * t.rounding_m;
  t.setback_m = has_solid_triangles ? 256 * t.rounding_m : 0;
  t.raise_m = 0.5 * t.rounding_m;
  t.upward_raise_m = t.raise_m * steepest;
  t.clearance_m = 4 * t.upward_raise_m;
  t.search_margin_m = 4 * t.rounding_m + t.clearance_m;
  t.near_terrain_m = 16 * t.rounding_m + t.clearance_m;
  t.crowding_m = 8 * t.rounding_m;
  t.edge_margin_m = t.rounding_m;
  t.round_box_margin_m = 2 * t.rounding_m;
  t.box_margin_m = 2 * kLongestMitre * t.widening_m;
  return t;
}

}  // namespace uwsim
