#pragma once

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The water's speed of sound by depth, at levels close enough for linear interpolation to be within 0.06 m/s. Between
/// bottom_depth_m, or the profile's last level, and a depth of 12 km (the deepest ocean bed), temperature and salinity
/// are constant and the equation accounts for pressure, beyond its range of validity if necessary. A ray that leaves
/// the terrain's area thus bends as the water requires, and no ray that stays above the bed is affected. A profile that
/// specifies the speed of sound is constant below its last level.
SoundSpeedProfile sound_speed_profile(const Water& water);

/// Francois-Garrison absorption by depth, from the water's temperature and salinity, down to the deepest ocean bed: in
/// fine steps to `bottom_m`, and in coarser ones below, where only the pressure varies.
AbsorptionColumn absorption_column(const Water& water, double frequency_hz, double acidity_ph, double bottom_m);

}  // namespace uwsim
