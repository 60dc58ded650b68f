#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace uwsim {

/// A layer in which the speed of sound is linear in depth: c(d) = speed_m_s + gradient_1_s (d - reference_m).
struct SoundLayer {
  double top_m;     ///< -infinity for the first layer
  double bottom_m;  ///< +infinity for the last layer
  double reference_m;
  double speed_m_s;  ///< at reference_m
  double gradient_1_s;

  double at(double depth_m) const { return speed_m_s + gradient_1_s * (depth_m - reference_m); }
};

/// Speed of sound, linear in depth between levels, constant above the first and below the last.
class SoundSpeedProfile {
 public:
  /// Throws InvalidValue naming sound_speed_profile unless depths [m] increase and are in [0, 12000], and speeds [m/s],
  /// one for each depth, are in [1300, 1900]. For comparison, in water of -2..40 deg C and 0..45 psu, every equation in
  /// uwsim yields 1392 to 1777 m/s down to 12 km, and less than 1830 m/s under a column of 1300 kg/m3.
  SoundSpeedProfile(std::span<const double> depths_m, std::span<const double> speeds_m_s);

  /// A profile with the same speed at all depths.
  static SoundSpeedProfile even(double speed_m_s);

  const std::vector<SoundLayer>& layers() const { return layers_; }
  /// Index of the layer that contains a depth; at a boundary, the index of the lower layer.
  std::size_t layer_at(double depth_m) const;
  /// Index of the layer that a ray enters at a depth; this only differs at a boundary.
  std::size_t layer_ahead(double depth_m, bool rises) const {
    const std::size_t layer = layer_at(depth_m);
    return rises && layer > 0 && depth_m == layers_[layer].top_m ? layer - 1 : layer;
  }
  double at(double depth_m) const { return layers_[layer_at(depth_m)].at(depth_m); }
  /// Largest |dc/dz| [1/s]; 0 if all rays are straight.
  double steepest_1_s() const { return steepest_1_s_; }

 private:
  std::vector<SoundLayer> layers_;
  double steepest_1_s_ = 0;
};

}  // namespace uwsim
