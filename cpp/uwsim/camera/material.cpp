#include "uwsim/camera/material.h"

#include <algorithm>
#include <array>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

struct Named {
  const char* name;
  camera::MaterialRow row;  // base, other, contrast, fine a metre, bump, ripple length and slope
};

constexpr std::array<Named, 9> kMaterials = {{
    {"plain", {{.50f, .50f, .50f}, {.50f, .50f, .50f}, 0, 1, 0, 0, 0}},
    {"sand", {{.40f, .35f, .25f}, {.22f, .18f, .12f}, 1.1f, 7, .35f, .28f, .45f}},
    {"gravel", {{.30f, .29f, .27f}, {.14f, .13f, .12f}, 1.6f, 12, .9f, 0, 0}},
    {"mud", {{.20f, .17f, .12f}, {.14f, .12f, .09f}, .7f, 3, .15f, 0, 0}},
    {"rock", {{.24f, .23f, .21f}, {.09f, .10f, .09f}, 1.4f, 4, .8f, 0, 0}},
    {"steel", {{.34f, .34f, .34f}, {.30f, .17f, .09f}, .9f, 6, .06f, 0, 0}},
    {"concrete", {{.46f, .45f, .42f}, {.31f, .31f, .27f}, .7f, 9, .15f, 0, 0}},
    {"paint", {{.78f, .58f, .08f}, {.66f, .47f, .06f}, .3f, 8, .03f, 0, 0}},
    {"land", {{.13f, .17f, .06f}, {.26f, .24f, .13f}, 1.2f, 2, .6f, 0, 0}},
}};

}  // namespace

camera::MaterialRow material(std::string_view name, const std::optional<Bands>& colour) {
  const auto found = std::find_if(kMaterials.begin(), kMaterials.end(), [&](const Named& m) { return name == m.name; });
  if (found == kMaterials.end()) {
    std::string names;
    for (const Named& known : kMaterials) names += (names.empty() ? "" : ", ") + std::string(known.name);
    require(false, "material", name, "must be one of " + names);
  }
  camera::MaterialRow row = found->row;
  if (colour) {
    require((*colour >= 0).all() && (*colour <= 1).all(), "material.colour", colour->transpose(),
            "must be in [0, 1] in each band");
    for (int band = 0; band < 3; ++band) {
      const auto own = static_cast<float>((*colour)(band));
      row.other[band] = std::min(1.0f, own * row.other[band] / row.base[band]);
      row.base[band] = own;
    }
  }
  return row;
}

const std::vector<std::string>& material_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Named& known : kMaterials) all.emplace_back(known.name);
    return all;
  }();
  return names;
}

}  // namespace uwsim
