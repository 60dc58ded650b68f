#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/camera/kernel.h"
#include "uwsim/camera/water_optics.h"

namespace uwsim {

/// What a surface is made of, by name: plain (an even grey of 0.5, for tests and targets), sand, gravel, mud, rock,
/// steel, concrete, paint, land (what grows above water). Albedos and patterns are assumed, of the order of tables of
/// reflectance. `colour`, the albedo in each band, replaces the material's own; the second colour of its patches
/// changes alike. Throws InvalidValue.
camera::MaterialRow material(std::string_view name, const std::optional<Bands>& colour = std::nullopt);
const std::vector<std::string>& material_names();

}  // namespace uwsim
