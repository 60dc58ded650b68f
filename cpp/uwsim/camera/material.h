#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/water_optics.h"

namespace uwsim {

/// Returns a material by name: plain (a uniform grey of 0.5, for tests and targets), sand, gravel, mud, rock, steel,
/// concrete, paint, coral, leaf or land (vegetation above water). Albedos and patterns are assumed; their order of
/// magnitude agrees with tables of reflectance. `colour`, the albedo in each band, replaces the material's first colour
/// and scales its second. Throws InvalidValue.
camera::Material material(std::string_view name, const std::optional<Bands>& colour = std::nullopt);
const std::vector<std::string>& material_names();

}  // namespace uwsim
