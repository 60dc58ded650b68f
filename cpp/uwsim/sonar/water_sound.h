#pragma once

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The speed of sound by depth: as given by the water's profile, or else Mackenzie's, from temperature, salinity and
/// depth, at depths that are close enough for linear interpolation to be within 0.05 m/s.
SoundSpeedProfile sound_speed_profile(const Water& water);

/// The same at one depth [m/s], without interpolation.
double sound_speed_m_s(const Water& water, double z_world_m);

/// Francois-Garrison absorption by depth from the water's temperature and salinity, down to `bottom_m`.
AbsorptionColumn absorption_column(const Water& water, double frequency_hz, double acidity_ph, double bottom_m);

}  // namespace uwsim
