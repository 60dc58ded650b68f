#pragma once

#include "uwsim/acoustics/ray_fan.h"

namespace uwsim {

/// The number of times that the rays of a family pass through each part of the water. The rays start upwards or
/// downwards and reverse their vertical direction `reversals` times, by bouncing or turning.
struct RayFamily {
  int above, between, below;

  /// `first_up`: whether the ray starts upwards, `source_above`: whether it starts at the upper of its ends
  static RayFamily of(int reversals, bool first_up, bool source_above) {
    const int at_top = (reversals + (first_up ? 1 : 0)) / 2, at_bottom = reversals - at_top;
    const bool last_up = first_up == (reversals % 2 == 0);
    const bool leaves = first_up != source_above, reaches = last_up != source_above;
    const int between = reversals == 0 ? 1 : reversals - 1 + (leaves ? 1 : 0) + (reaches ? 1 : 0);
    return {2 * at_top, between, 2 * at_bottom};
  }

  RaySum sum(const RayParts& parts) const {
    RaySum sum;
    const auto add = [&](int times, const RaySum& part) {
      if (times == 0) return;  // the part may be infinite
      sum.across_per_p += times * part.across_per_p;
      sum.widening += times * part.widening;
      sum.time_s += times * part.time_s;
      sum.length_m += times * part.length_m;
      sum.absorbed_db += times * part.absorbed_db;
    };
    add(above, parts.above);
    add(between, parts.between);
    add(below, parts.below);
    return sum;
  }
};

/// A family's horizontal distance and its derivative with respect to the dip, at one dip.
struct RayReach {
  double dip_rad, across_m, slope_m;

  RayReach(const RayFamily& family, const RayParts& parts, const Snell& snell, double dip) : dip_rad(dip) {
    const RaySum sum = family.sum(parts);
    across_m = snell.p_s_m() * sum.across_per_p;
    slope_m = -sum.widening * snell.sine / snell.speed_m_s;
  }
};

}  // namespace uwsim
