#pragma once

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The water's speed of sound by depth: as its profile gives it, else Mackenzie's of temperature, salinity and depth,
/// straight between depths so near that it is within 0.05 m/s.
SoundSpeedProfile sound_speed_profile(const Water& water);

/// Speed of sound at a depth [m/s], as the profile above has it but without interpolation.
double sound_speed_m_s(const Water& water, double z_world_m);

/// Francois-Garrison absorption of the water's temperature and salinity by depth, down to `bottom_m`.
AbsorptionColumn absorption_column(const Water& water, double frequency_hz, double acidity_ph, double bottom_m);

}  // namespace uwsim
