#pragma once

#include <cstddef>

#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// A point on a ray of sound, in the ray's vertical plane.
struct SoundState {
  double across_m = 0;  ///< horizontal distance from the start
  double depth_m = 0;
  double dip_rad = 0;   ///< below the horizontal, in [-pi/2, pi/2]
  double time_s = 0;    ///< travel time from the start
  double length_m = 0;  ///< along the path
};

/// A ray of sound through a layered profile by Snell's law: cos(dip) / c is constant. In a layer of constant gradient
/// g, the path is an arc of curvature g cos(dip) / c, bent towards slower water (Urick 1983, "Principles of Underwater
/// Sound", ch. 5, not consulted; the closed forms are derived here and compared with BELLHOP by `uwsim validate
/// sound`). Steps and times are closed forms that remain exact for a vanishing gradient, a vertical ray, or a turning
/// point. High-frequency limit: no diffraction, no focusing. The water is layered in depth only.
class SoundPath {
 public:
  /// `profile` must outlive this object. dip_rad: below the horizontal.
  SoundPath(const SoundSpeedProfile& profile, double depth_m, double dip_rad);

  const SoundState& state() const { return state_; }

  /// A section of the arc within one layer.
  struct Step {
    SoundState end;
    bool leaves = false;  ///< whether it ends at the layer's boundary or at the surface
  };
  /// The next step, at most `length_max_m` long; it is shorter if the layer or the water ends first. If the maximum is
  /// infinite, the step leads to the end of the layer, or is infinitely long if the ray never leaves it.
  Step step(double length_max_m) const;
  /// Moves to the end of the step. Returns true if the path has reached the surface, where it ends.
  bool advance(const Step& step);
  /// The point `length_m` ahead on this layer's arc.
  SoundState ahead(double length_m) const;
  /// The distance along this layer's arc that sound travels in `time_s`.
  double length_after(double time_s) const;

 private:
  template <typename Arc>
  Arc arc() const;  // of sound_arc.h
  void enter(std::size_t layer);

  const SoundSpeedProfile* profile_;
  std::size_t layer_ = 0;
  double snell_s_m_;          ///< cos(dip) / c
  double curvature_1_m_ = 0;  ///< positive bends down
  double cosine_, sine_;      ///< of the dip
  SoundState state_;
};

/// The end of a ray after `time_s`, or the point where it meets the surface before that time.
SoundState travel(const SoundSpeedProfile& profile, double depth_m, double dip_rad, double time_s);

}  // namespace uwsim
