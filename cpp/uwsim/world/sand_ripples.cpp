#include "uwsim/world/sand_ripples.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace uwsim {
namespace {

constexpr double kFirst_m = 256;        // where the patterns begin, west and south of the origin: kTextureRepeat_m
constexpr double kPatches_per_m = 0.7;  // kPatch_per_m
constexpr double kBend_m = 0.35;        // of a crest, by a patch
constexpr std::uint32_t kSalt = 17;

double hash_unit(std::uint32_t x) {
  const std::uint32_t state = x * 747796405u + 2891336453u, word = ((state >> 13) ^ state) * 277803737u;
  return static_cast<double>(((word >> 16) ^ word) >> 8) * 0x1p-24;
}

/// The share of a patch, in [0, 1]: value_noise of camera/kernels/materials.h.
double patch_at(const Eigen::Vector3d& point_world_m) {
  const Eigen::Vector3d p = kPatches_per_m * (point_world_m + Eigen::Vector3d(kFirst_m, kFirst_m, 0));
  const auto cell = [](double x) { return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(x))); };
  const auto eased = [](double x) { return x * x * (3 - 2 * x); };
  const double u = eased(p.x() - std::floor(p.x())), v = eased(p.y() - std::floor(p.y())),
               w = eased(p.z() - std::floor(p.z()));
  const std::uint32_t x0 = cell(p.x()) * 0x8da6b343u, y0 = cell(p.y()) * 0xd8163841u,
                      z0 = cell(p.z()) * 0xcb1ab31fu + kSalt;
  const std::uint32_t x1 = x0 + 0x8da6b343u, y1 = y0 + 0xd8163841u, z1 = z0 + 0xcb1ab31fu;
  const auto row = [&](std::uint32_t y, std::uint32_t z) {
    return std::lerp(hash_unit(x0 ^ y ^ z), hash_unit(x1 ^ y ^ z), u);
  };
  return std::lerp(std::lerp(row(y0, z0), row(y1, z0), v), std::lerp(row(y0, z1), row(y1, z1), v), w);
}

}  // namespace

SandRipples::SandRipples(double across_rad) : across_(std::cos(across_rad), std::sin(across_rad)) {}

SandRipples::Wave SandRipples::at(const Eigen::Vector3d& point_world_m) const {
  const double patch = patch_at(point_world_m);
  const Eigen::Vector2d from = point_world_m.head<2>() + Eigen::Vector2d(kFirst_m, kFirst_m);
  const double along_m = from.dot(across_) + kBend_m * patch;
  return {double{kRippleTilt} * (0.4 + patch), 2 * std::numbers::pi * along_m / double{kRipple_m}};
}

double SandRipples::steepest(const Eigen::Vector3d& point_world_m) { return 0.72 + 0.16 * patch_at(point_world_m); }

}  // namespace uwsim
