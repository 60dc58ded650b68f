#pragma once

#include <cstddef>

#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// Where a ray of sound is, in its own vertical plane.
struct SoundState {
  double across_m = 0;  ///< horizontal distance from its start
  double depth_m = 0;
  double dip_rad = 0;   ///< below the horizontal, in [-pi/2, pi/2]
  double time_s = 0;    ///< since its start
  double length_m = 0;  ///< along the path
};

/// A ray of sound through a layered profile, after Snell: cos(dip) / c is kept. In a layer of constant gradient g the
/// path is an arc of curvature g cos(dip) / c, bent towards slower water (Urick 1983, "Principles of Underwater Sound",
/// ch. 5; cited from memory, the closed forms derived here). Steps and times are closed forms
/// that stay exact where the gradient vanishes, the ray is vertical, or it turns. High-frequency limit: no diffraction,
/// no focusing; the water is layered in depth alone.
class SoundPath {
 public:
  /// `profile` must outlive it. dip_rad: below the horizontal.
  SoundPath(const SoundSpeedProfile& profile, double depth_m, double dip_rad);

  const SoundState& state() const { return state_; }
  /// [1/m], of the arc that comes next; positive bends down.
  double curvature_1_m() const { return curvature_1_m_; }
  /// Speed of sound where it is [m/s].
  double speed_m_s() const { return layer().at(state_.depth_m); }

  /// A part of the arc within one layer.
  struct Step {
    SoundState end;
    bool leaves = false;  ///< ends on the layer's boundary, or at the surface
  };
  /// The way ahead: `length_max_m` of it, or less where the layer or the water ends before; infinity asks for the whole
  /// layer, and gets an infinite length where the ray never leaves it.
  Step step(double length_max_m) const;
  /// Goes it. Returns whether the surface was reached: there is no beyond.
  bool take(const Step& step);
  /// State `length_m` ahead in this layer.
  SoundState ahead(double length_m) const;
  /// Length along this layer's arc after which `time_s` more have passed.
  double length_after(double time_s) const;

 private:
  const SoundLayer& layer() const { return profile_->layers()[layer_]; }
  double to_boundary_m() const;
  void enter(std::size_t layer);

  const SoundSpeedProfile* profile_;
  std::size_t layer_ = 0;
  double snell_s_m_;  ///< cos(dip) / c
  double curvature_1_m_ = 0;
  double cosine_, sine_;  ///< of the dip
  SoundState state_;
};

/// Where a ray is after `time_s`; at the surface where it meets that before.
SoundState travel(const SoundSpeedProfile& profile, double depth_m, double dip_rad, double time_s);

}  // namespace uwsim
