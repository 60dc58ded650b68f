#include "uwsim/acoustics/sound_path.h"

#include <cmath>

#include "uwsim/acoustics/sound_arc.h"

namespace uwsim {
namespace {

ArcPoint<double> point_of(const SoundState& s) { return {s.across_m, s.depth_m, s.dip_rad, s.time_s, s.length_m}; }
SoundState state_of(const ArcPoint<double>& p) { return {p.across_m, p.depth_m, p.dip_rad, p.time_s, p.length_m}; }

}  // namespace

SoundPath::SoundPath(const SoundSpeedProfile& profile, double depth_m, double dip_rad)
    : profile_(&profile), cosine_(std::cos(dip_rad)), sine_(std::sin(dip_rad)) {
  state_.depth_m = depth_m;
  state_.dip_rad = dip_rad;
  snell_s_m_ = cosine_ / profile.at(depth_m);
  enter(profile.layer_ahead(depth_m, dip_rad < 0));
}

void SoundPath::enter(std::size_t layer) {
  layer_ = layer;
  curvature_1_m_ = -snell_s_m_ * profile_->layers()[layer].gradient_1_s;
}

template <typename Arc>
Arc SoundPath::arc() const {
  const SoundLayer& in = profile_->layers()[layer_];
  return {point_of(state_), cosine_,     sine_,          snell_s_m_,   curvature_1_m_,
          in.top_m,         in.bottom_m, in.reference_m, in.speed_m_s, in.gradient_1_s};
}

SoundState SoundPath::ahead(double length_m) const { return state_of(point_ahead(arc<Arc<double>>(), length_m)); }

SoundPath::Step SoundPath::step(double length_max_m) const {
  const ArcStep<double> step = next_step(arc<Arc<double>>(), length_max_m);
  return {state_of(step.end), step.leaves};
}

bool SoundPath::advance(const Step& step) {
  state_ = step.end;
  const ArcDirection<double> direction = direction_on(arc<Arc<double>>(), point_of(state_));
  cosine_ = direction.cosine, sine_ = direction.sine;
  if (!step.leaves) return false;
  const bool down = state_.dip_rad > 0;
  if (!down && profile_->layers()[layer_].top_m <= 0) return true;
  enter(down ? layer_ + 1 : layer_ - 1);
  return false;
}

double SoundPath::length_after(double time_s) const { return uwsim::length_after(arc<Arc<double>>(), time_s); }

SoundState travel(const SoundSpeedProfile& profile, double depth_m, double dip_rad, double time_s) {
  SoundPath path(profile, depth_m, dip_rad);
  if (depth_m <= 0 && dip_rad <= 0) return path.state();
  for (;;) {
    // The step to the end of the layer. Its length is limited, because the outermost layers have no end.
    const SoundPath::Step whole = path.step(2000 * (time_s - path.state().time_s) + 1);
    if (whole.end.time_s >= time_s || !whole.leaves) return path.ahead(path.length_after(time_s - path.state().time_s));
    if (path.advance(whole)) return path.state();
  }
}

}  // namespace uwsim
