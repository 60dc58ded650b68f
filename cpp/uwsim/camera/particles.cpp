#include "uwsim/camera/particles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace uwsim {
namespace {

constexpr double kParticleCell_m = 0.25;
constexpr double kCellRadius_m = 0.867 * kParticleCell_m;  // more than from its centre to a corner
constexpr double kReach_m = 2.5, kNearest_m = 0.15;
constexpr double kSwirl_m = 0.03;  // more than particles swirl
constexpr float kAlbedo = 0.5f;
constexpr double kAperture_rad_m = 0.0015;  // defocus of near objects, in radians times metres
constexpr double kGeneration_s = 4;         // each particle is visible for two of these intervals and brightest halfway

std::uint64_t mixed(std::uint64_t x) {  // SplitMix64 (Steele, Lea and Flood 2014)
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
double unit_of(std::uint64_t bits, int part) { return static_cast<double>((bits >> (16 * part)) & 0xffff) / 65536; }

/// The displacement of the water at the eye since a time a few seconds ago: the integral of the flow, which may have
/// changed in the meantime.
Eigen::Vector3d drift_since(double begun_s, const Water& water, const Eigen::Vector3d& eye, double time_s) {
  constexpr int kSteps = 16;
  const double step_s = (time_s - begun_s) / kSteps;
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();
  for (int k = 0; k < kSteps; ++k) drift += step_s * water.flow_at(eye, begun_s + (k + 0.5) * step_s).velocity_m_s;
  return drift;
}

/// Particles that appear together and drift together.
struct Generation {
  std::int64_t number;
  double begun_s;
  double strength;  ///< fades in and out; two generations add up to 1
};

std::array<Generation, 2> generations_at(double time_s) {
  const double last = std::floor(time_s / kGeneration_s), age = time_s / kGeneration_s - last;
  const auto number = static_cast<std::int64_t>(last);
  return {{{number - 1, (last - 1) * kGeneration_s, 1 - age}, {number, last * kGeneration_s, age}}};
}

/// Radiance that reaches the eye from a particle, without a shadow: daylight from all directions and the light of each
/// lamp, attenuated on its path to the eye. `at`: relative to the eye.
std::array<float, 3> light_on(const Eigen::Vector3f& at, const camera::View& view) {
  std::array<float, 3> light;
  const float depth = std::max(0.0f, view.surface_z - (at.z() + view.camera_z)), range = at.norm();
  for (int band = 0; band < 3; ++band) {
    light[band] = 0.5f * view.total_level[band] * std::exp(-view.kd[band] * depth);
  }
  for (int k = 0; k < view.lamp_count; ++k) {
    const camera::SpotLight& lamp = view.lamps[k];
    const Eigen::Vector3f from = at - Eigen::Map<const Eigen::Vector3f>(lamp.position);
    const float distance = std::max(from.norm(), 0.05f);
    const float cone = from.dot(Eigen::Map<const Eigen::Vector3f>(lamp.axis)) / distance;
    const float edge = std::clamp((cone - lamp.cos_outer) / (lamp.cos_inner - lamp.cos_outer), 0.0f, 1.0f);
    const float spot = edge * edge * (3 - 2 * edge) / (distance * distance);
    for (int band = 0; band < 3; ++band)
      light[band] += lamp.intensity[band] * spot * std::exp(-view.c[band] * distance);
  }
  for (int band = 0; band < 3; ++band) {
    const float transmitted = view.has_attenuation ? std::exp(-view.c[band] * range) : 1.0f;
    light[band] *= kAlbedo * static_cast<float>(1 / std::numbers::pi) * transmitted;
  }
  return light;
}

void add_generation(const Generation& generation, const CameraScene& scene, const Camera& camera, const Optics& optics,
                    const PictureRequest& request, const camera::View& view, std::vector<Particle>& found) {
  const Eigen::Vector3d eye = request.world_from_camera.position_m;
  const Eigen::Vector3d drift = drift_since(generation.begun_s, scene.world().water, eye, request.time_s);
  const Eigen::Vector3d lattice_eye = eye - drift;
  const Eigen::Matrix3d optical_from_world = [&] {
    const Eigen::Matrix3d turn = request.world_from_camera.rotation();
    Eigen::Matrix3d rows;
    rows << -turn.col(1).transpose(), -turn.col(2).transpose(), turn.col(0).transpose();
    return rows;
  }();
  const Lens& lens = camera.lens();
  const bool distort = request.effects.has(Effect::kDistortion);
  const double focal = view.has_offsets ? kWaterIndex * lens.fx : lens.fx;
  const double chance = optics.particles_per_m3 * kParticleCell_m * kParticleCell_m * kParticleCell_m;
  const std::uint64_t key = mixed(mixed(scene.seed() ^ 0x5eedca11) ^ static_cast<std::uint64_t>(generation.number));
  const auto first = ((lattice_eye.array() - kReach_m) / kParticleCell_m).floor().cast<std::int64_t>().eval();
  const auto count = static_cast<std::int64_t>(2 * kReach_m / kParticleCell_m) + 2;
  for (std::int64_t k = 0; k < count * count * count; ++k) {
    const Eigen::Array<std::int64_t, 3, 1> cell =
        first + Eigen::Array<std::int64_t, 3, 1>(k % count, k / count % count, k / (count * count));
    const Eigen::Vector3d centre = (cell.cast<double>() + 0.5).matrix() * kParticleCell_m - lattice_eye;
    if (centre.norm() > kReach_m + kSwirl_m + kCellRadius_m) continue;
    if (optical_from_world.row(2).dot(centre) < kNearest_m - kSwirl_m - kCellRadius_m) continue;
    const std::uint64_t bits =
        mixed(mixed(mixed(key ^ static_cast<std::uint64_t>(cell.x())) ^ static_cast<std::uint64_t>(cell.y())) ^
              static_cast<std::uint64_t>(cell.z()));
    const std::uint64_t more = mixed(bits);
    if (unit_of(bits, 3) >= chance) continue;
    const Eigen::Vector3d in_cell(unit_of(bits, 0), unit_of(bits, 1), unit_of(bits, 2));
    const Eigen::Vector3d about = (cell.cast<double>().matrix() + in_cell) * kParticleCell_m - lattice_eye;
    if (about.norm() > kReach_m + kSwirl_m || optical_from_world.row(2).dot(about) < kNearest_m - kSwirl_m) continue;
    const double turn = request.time_s * (0.3 + 0.4 * unit_of(more, 0)) + 2 * std::numbers::pi * unit_of(more, 1);
    const Eigen::Vector3d swirl = 0.02 * Eigen::Vector3d(std::sin(turn), std::cos(turn), std::sin(1.3 * turn));
    const Eigen::Vector3d at = (cell.cast<double>().matrix() + in_cell) * kParticleCell_m + swirl - lattice_eye;
    const Eigen::Vector3d seen = optical_from_world * at;
    if (seen.z() < kNearest_m || at.norm() > kReach_m || at.z() + eye.z() > view.surface_z) continue;
    const Eigen::Vector2d ray(seen.x() / seen.z(), seen.y() / seen.z());
    if (ray.norm() > (lens.is_equidistant ? kWidestRay : 3) || (distort && !shows(lens, ray))) continue;
    const std::optional<Eigen::Vector2d> image =
        view.has_offsets ? project_through_port(lens, seen, distort) : project(lens, ray, distort);
    if (!image) continue;
    const Eigen::Vector2d pixel = *image;
    const double size_m = 2e-4 * std::exp(1.6 * unit_of(more, 2));
    const double sharp = focal * size_m / seen.z(), blur = 0.8 + focal * kAperture_rad_m / seen.z();
    const double radius = sharp + blur;
    if (!(pixel.x() > -radius && pixel.y() > -radius && pixel.x() < lens.width + radius &&
          pixel.y() < lens.height + radius)) {
      continue;
    }
    // Distant particles fade out, so that none appears suddenly.
    const double fade = std::clamp(3 * (1 - at.norm() / kReach_m), 0.0, 1.0);
    const auto share = static_cast<float>(3 * generation.strength * fade * sharp * sharp / (radius * radius));
    const std::array<float, 3> light = light_on(at.cast<float>(), view);
    found.push_back({static_cast<float>(pixel.x()),
                     static_cast<float>(pixel.y()),
                     static_cast<float>(seen.z()),
                     static_cast<float>(radius),
                     {share * light[0], share * light[1], share * light[2]}});
  }
}

}  // namespace

std::vector<Particle> visible_particles(const CameraScene& scene, const Camera& camera, const Optics& optics,
                                        const PictureRequest& request, const camera::View& view) {
  std::vector<Particle> found;
  if (!view.camera_in_water || !request.effects.has(Effect::kParticles)) return found;
  for (const Generation& generation : generations_at(request.time_s)) {
    add_generation(generation, scene, camera, optics, request, view, found);
  }
  return found;
}

void draw_particles(const std::vector<Particle>& particles, std::span<const float> depth_m, const camera::View& view,
                    int first, int last, const camera::RadiancePlanes& radiance) {
  for (const Particle& particle : particles) {
    const int top = std::max(first, static_cast<int>(std::ceil(particle.v - particle.radius)));
    const int bottom = std::min(last - 1, static_cast<int>(std::floor(particle.v + particle.radius)));
    const int left = std::max(0, static_cast<int>(std::ceil(particle.u - particle.radius)));
    const int right = std::min(view.width - 1, static_cast<int>(std::floor(particle.u + particle.radius)));
    for (int v = top; v <= bottom; ++v) {
      for (int u = left; u <= right; ++u) {
        const int at = v * view.width + u;
        if (depth_m[static_cast<std::size_t>(at)] < particle.depth_m) continue;
        const float du = static_cast<float>(u) - particle.u, dv = static_cast<float>(v) - particle.v;
        const float inside = 1 - (du * du + dv * dv) / (particle.radius * particle.radius);
        if (inside <= 0) continue;
        radiance.red[at] += particle.light[0] * inside * inside;
        radiance.green[at] += particle.light[1] * inside * inside;
        radiance.blue[at] += particle.light[2] * inside * inside;
      }
    }
  }
}

}  // namespace uwsim
