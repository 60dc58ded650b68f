#pragma once

#include <vector>

#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

inline SoundSpeedProfile profile_of(const std::vector<double>& depths_m, const std::vector<double>& speeds_m_s) {
  return SoundSpeedProfile(depths_m, speeds_m_s);
}

}  // namespace uwsim
