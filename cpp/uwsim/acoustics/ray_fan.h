#pragma once

#include <cstddef>
#include <vector>

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// The ends of rays. Depths [m] are in [0, bottom_m]; bottom_m may be infinite, which disables reflections from the
/// bottom.
struct RayEnds {
  double from_depth_m;
  double to_depth_m;
  double across_m;
  double bottom_m;
};

/// A ray's Snell invariant p = cos(dip) / c, stored as the dip at the speed of sound `speed_m_s`: p itself cannot
/// resolve rays that are nearly level there.
struct Snell {
  double speed_m_s;
  double sine, cosine;  ///< of the dip at speed_m_s

  /// The invariant of a ray whose dip at that speed is `dip_rad`.
  static Snell of(double speed_m_s, double dip_rad);

  double p_s_m() const { return cosine / speed_m_s; }
  /// The sine of the dip at the depth where the speed of sound is c.
  double sine_at(double c) const;
};

/// Distances and times summed along a ray through a part of the water.
struct RaySum {
  double across_per_p = 0;  ///< horizontal distance x, divided by p [m^2/s]
  double widening = 0;      ///< dx / dp at the depth where the part ends [m^2/s]
  double time_s = 0;        ///< like the following members, set only in a full sum
  double length_m = 0;
  double absorbed_db = 0;
};

/// The sums for one passage through each part of the water: from the upper end of the fan's rays to the turning point
/// or reflection above it, between the depths of the ends, and from the lower end to the turning point or reflection
/// below it.
struct RayParts {
  RaySum above, between, below;
};

/// A range of rays, bounded by rays that graze a level of the profile, in which all rays turn in the same layers.
/// Within a band, x is a smooth function of the dip.
struct RayBand {
  double speed_m_s;  ///< the greatest speed of sound that all rays of the band pass: its flattest ray is level there
  double end_rad;    ///< dip of its steepest ray at that speed
  bool at_surface;   ///< whether its rays reflect from the surface, otherwise they turn below it
  bool at_bottom;    ///< whether its rays reflect from the bottom
  bool returns;      ///< whether its rays return from below; they do not if the water has no bottom
  std::size_t top, end;  ///< the layers that its rays pass, including those in which they turn
};

/// All rays through two depths of layered water, with closed forms for each layer. With s the sine of the dip at the
/// top and the bottom of a layer of thickness h, and p the Snell invariant: x = p h (c1 + c2) / (s1 + s2) and
/// dx / dp = x / (p s1 s2); from the depth where the ray's sine is s to its turning point in a gradient g:
/// x = s / (p |g|) and dx / dp = -1 / (p^2 |g| s).
class RayFan {
 public:
  /// Replaces the sound speed profile and the ends of the rays. Allocates only if the profile has more layers than any
  /// previous one.
  void set(const SoundSpeedProfile& profile, const RayEnds& ends);

  const std::vector<RayBand>& bands() const { return bands_; }
  /// x / p and dx / dp of the band's ray with the given dip.
  RayParts parts(const RayBand& band, const Snell& snell) const { return sum(band, snell, nullptr, false); }
  /// All sums; absorption may be null.
  RayParts all_parts(const RayBand& band, const Snell& snell, const AbsorptionColumn* absorption) const {
    return sum(band, snell, absorption, true);
  }
  /// The least and the greatest depth of a ray.
  double top_m(const RayBand& band, const Snell& snell) const;
  double bottom_m(const RayBand& band, const Snell& snell) const;

 private:
  struct Layer {
    double top_m, bottom_m, at_top_m_s, at_bottom_m_s, gradient_1_s;
  };
  /// A layer in which rays turn, and the range of the speed of sound at their turning points.
  struct Turn {
    double from_m_s, to_m_s;
    std::size_t layer;
  };
  RayParts sum(const RayBand& band, const Snell& snell, const AbsorptionColumn* absorption, bool all) const;
  void add_bands(double passed_m_s, bool has_bottom);

  std::vector<Layer> layers_;
  std::size_t between_ = 0, below_ = 0;  // first layers of the parts between and below the ends
  std::vector<RayBand> bands_;
  std::vector<Turn> up_, down_;  // by increasing speed
  std::vector<double> speeds_m_s_;
};

}  // namespace uwsim
