#include "uwsim/camera/water_optics.h"

#include <array>

#include "uwsim/core/check.h"
#include "uwsim/core/names.h"

namespace uwsim {
namespace {

struct Type {
  const char* name;
  std::array<double, 3> kd, a, b;  // 600, 550, 450 nm
};

constexpr std::array<Type, 10> kTypes = {{
    {"I", {.235, .063, .019}, {.228, .062, .018}, {.0012, .0017, .0038}},
    {"IA", {.24, .067, .026}, {.228, .0622, .0221}, {.0028, .0035, .0063}},
    {"IB", {.245, .072, .036}, {.2278, .0623, .0235}, {.0488, .0536, .068}},
    {"II", {.26, .089, .068}, {.231, .0724, .0623}, {.170, .177, .195}},
    {"III", {.295, .12, .135}, {.241, .0878, .112}, {.278, .287, .309}},
    {"1C", {.30, .12, .25}, {.248, .0988, .148}, {.416, .427, .455}},
    {"3C", {.33, .19, .39}, {.268, .128, .200}, {.627, .644, .686}},
    {"5C", {.40, .30, .56}, {.285, .159, .313}, {1.16, 1.19, 1.27}},
    {"7C", {.48, .46, .89}, {.301, .195, .542}, {2.03, 2.35, 3.30}},
    {"9C", {.60, .63, 1.6}, {.390, .348, .943}, {2.69, 3.12, 4.39}},
}};

Bands bands(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

}  // namespace

void WaterOptics::check() const {
  const auto require_positive = [](const char* name, const Bands& values) {
    require(values.isFinite().all() && (values > 0).all() && (values < 100).all(), std::string("optics.") + name,
            values.transpose(), "must be above 0 and below 100 1/m in each band");
  };
  require_positive("diffuse_attenuation", diffuse_attenuation);
  require_positive("absorption", absorption);
  require_positive("scattering", scattering);
  require((absorption <= diffuse_attenuation).all(), "optics.absorption", absorption.transpose(),
          "must be at most diffuse_attenuation in each band: light that goes down a metre has gone at least a metre");
  require(refractive_index >= 1 && refractive_index <= 2, "optics.refractive_index", refractive_index,
          "must be in [1, 2]");
}

WaterOptics jerlov_water(std::string_view type) {
  const Type& known = kTypes[index_of("optics.jerlov", type, jerlov_types())];
  return {bands(known.kd), bands(known.a), bands(known.b)};
}

const std::vector<std::string>& jerlov_types() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Type& known : kTypes) all.emplace_back(known.name);
    return all;
  }();
  return names;
}

Bands molecular_scattering() { return bands(kTypes[0].b); }

Bands upwelling_share(const WaterOptics& water) {
  const Bands molecular = molecular_scattering().min(water.scattering);
  const Bands back = 0.5 * molecular + 0.018 * (water.scattering - molecular);
  return (0.33 * back / water.absorption).min(0.3);
}

}  // namespace uwsim
