#include "uwsim/camera/material.h"

#include <algorithm>
#include <array>

#include "uwsim/core/check.h"
#include "uwsim/core/names.h"
#include "uwsim/world/sand_ripples.h"

namespace uwsim {
namespace {

struct NamedMaterial {
  const char* name;
  camera::Material material;  // base, other, contrast, fine_per_m, bump, ripple_m, ripple_tilt, detail
};

constexpr std::array<NamedMaterial, 11> kMaterials = {{
    {"plain", {{.50f, .50f, .50f}, {.50f, .50f, .50f}, 0, 1, 0, 0, 0, {1, 0, 0, 1, 1, 0, 0, 1, 0}}},
    {"sand",
     {{.40f, .35f, .25f},
      {.22f, .18f, .12f},
      1.1f,
      7,
      .35f,
      kRipple_m,
      kRippleTilt,
      {24, .16f, .90f, 1, 10, .55f, 1.2f, .85f, .70f}}},
    {"gravel",
     {{.30f, .29f, .27f}, {.14f, .13f, .12f}, 1.6f, 12, .9f, 0, 0, {26, .16f, .60f, 1, 16, .92f, 1.5f, 1.0f, .60f}}},
    {"mud",
     {{.20f, .17f, .12f}, {.14f, .12f, .09f}, .7f, 3, .15f, 0, 0, {18, .07f, .40f, 1, 7, .14f, -1.2f, .55f, .45f}}},
    {"rock",
     {{.24f, .23f, .21f}, {.09f, .10f, .09f}, 1.4f, 4, .8f, 0, 0, {9, .20f, .60f, 3.0f, 14, .25f, -.8f, .70f, .45f}}},
    {"steel",
     {{.34f, .34f, .34f}, {.30f, .17f, .09f}, .9f, 6, .06f, 0, 0, {11, .05f, .75f, .25f, 18, .35f, .7f, 1.3f, .45f}}},
    {"concrete",
     {{.46f, .45f, .42f}, {.31f, .31f, .27f}, .7f, 9, .15f, 0, 0, {22, .07f, .40f, 1, 22, .40f, -1.0f, .55f, .45f}}},
    {"paint",
     {{.78f, .58f, .08f}, {.66f, .47f, .06f}, .3f, 8, .03f, 0, 0, {6, .03f, .55f, .3f, 10, .12f, -.4f, .45f, .45f}}},
    {"coral",
     {{.52f, .36f, .24f}, {.26f, .16f, .12f}, 1.3f, 22, .5f, 0, 0, {40, .22f, .55f, 1, 34, .55f, .8f, .85f, .45f}}},
    {"leaf",
     {{.16f, .20f, .06f}, {.07f, .10f, .03f}, 1.0f, 14, .12f, 0, 0, {45, .08f, .5f, .3f, 60, .10f, .3f, 1.3f, .45f}}},
    {"land", {{.13f, .17f, .06f}, {.26f, .24f, .13f}, 1.2f, 2, .6f, 0, 0, {6, .12f, .5f, 1, 6, .4f, .6f, .9f, .45f}}},
}};

}  // namespace

camera::Material material(std::string_view name, const std::optional<Bands>& colour) {
  camera::Material material = kMaterials[index_of("material", name, material_names())].material;
  if (colour) {
    require((*colour >= 0).all() && (*colour <= 1).all(), "material.colour", colour->transpose(),
            "must be in [0, 1] in each band");
    for (int band = 0; band < 3; ++band) {
      const auto own = static_cast<float>((*colour)(band));
      material.other[band] = std::min(1.0f, own * material.other[band] / material.base[band]);
      material.base[band] = own;
    }
  }
  return material;
}

const std::vector<std::string>& material_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedMaterial& known : kMaterials) all.emplace_back(known.name);
    return all;
  }();
  return names;
}

}  // namespace uwsim
