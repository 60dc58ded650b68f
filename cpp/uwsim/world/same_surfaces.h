#pragma once

#include "uwsim/world/world.h"

namespace uwsim {

/// Whether terrain and solids are identical, number for number, each under the same label. Names and water may differ.
bool have_same_surfaces(const World& one, const World& other);

}  // namespace uwsim
