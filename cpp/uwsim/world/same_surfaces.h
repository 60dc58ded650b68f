#pragma once

#include "uwsim/world/world.h"

namespace uwsim {

/// Whether terrain and solids are identical, value for value, with the same labels. Names and water may differ.
bool have_same_surfaces(const World& one, const World& other);

}  // namespace uwsim
