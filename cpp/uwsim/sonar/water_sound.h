#pragma once

#include "uwsim/acoustics/absorption_column.h"
#include "uwsim/acoustics/sound_speed_profile.h"
#include "uwsim/world/water.h"

namespace uwsim {

/// The water's speed of sound by depth, at levels close enough for linear interpolation to be within 0.06 m/s. From
/// bottom_depth_m, or the profile's last level, down to the ocean's deepest bed at 12 km, temperature and salinity are
/// constant and the equation adds the pressure, beyond its range of validity if need be: so a ray that passes beside
/// the terrain bends as the water does, and no ray that stays above the bed depends on it. A profile given as speed of
/// sound keeps its last value below its last level.
SoundSpeedProfile sound_speed_profile(const Water& water);

/// Francois-Garrison absorption by depth from the water's temperature and salinity, down to the ocean's deepest bed: in
/// fine steps to `bottom_m`, and in coarser ones below, where only pressure changes it.
AbsorptionColumn absorption_column(const Water& water, double frequency_hz, double acidity_ph, double bottom_m);

}  // namespace uwsim
