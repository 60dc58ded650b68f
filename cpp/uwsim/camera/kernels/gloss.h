#pragma once

#include "uwsim/camera/kernels/scattering.h"

/// The light that glossy surfaces reflect. Included only by the kernels.
namespace uwsim::camera {
namespace {

constexpr float kDielectricIndex = 1.5f;  // of glTF's materials

UWSIM_LANES Vector reflected_per_irradiance(const Block& block) {
  return load(block.albedo) * load(block.throughput) * splat(1 / kPi);
}

/// The same for light from one direction, of which glossy surfaces reflect a part like a mirror: the metallic-roughness
/// material of glTF 2.0 (appendix B): GGX's facets (Walter et al. 2007, eq. 33) with Smith's masking, correlated (Heitz
/// 2014, eq. 99), and Schlick's Fresnel term (1994, eq. 15). A dielectric has an index of 1.5, so that under water it
/// reflects 0.3 % instead of 4 % head on.
UWSIM_LANES Vector reflected_from(const View& view, const Block& block, Vector normal, Vector to_light, Int in_water) {
  const Vector matt = reflected_per_irradiance(block);
  const Int is_glossy = load(block.is_glossy.at);
  if (!view.has_gloss || !any(is_glossy)) return matt;
  const Vector to_eye = load(block.direction) * splat(-1), half = unit(to_eye + to_light);
  const Float facets = max(dot(normal, half), Float{}), eye = max(dot(normal, to_eye), splat(1e-3f)),
              light = max(dot(normal, to_light), splat(1e-3f)), bent = max(dot(to_eye, half), Float{});
  const Float rough = load(block.roughness.at), metal = load(block.metalness.at);
  const Float width = rough * rough, square = width * width;
  const Float spread = facets * facets * (square - 1) + 1;
  const Float masked =
      light * square_root(eye * eye * (1 - square) + square) + eye * square_root(light * light * (1 - square) + square);
  const Float lobe = square / (spread * spread * masked) * (0.5f / kPi);
  const float per = (kDielectricIndex - view.refractive_index) / (kDielectricIndex + view.refractive_index);
  const float in_air = (kDielectricIndex - 1) / (kDielectricIndex + 1);
  const Float dielectric = select(in_water, splat(per * per), splat(in_air * in_air));
  const Vector albedo = load(block.albedo),
               head_on = {mix(dielectric, albedo.x, metal), mix(dielectric, albedo.y, metal),
                          mix(dielectric, albedo.z, metal)};
  const Float miss = 1 - bent, fifth = miss * miss * (miss * miss) * miss;
  const Vector mirrored = head_on + (Vector{splat(1), splat(1), splat(1)} - head_on) * fifth;
  const Vector left = (Vector{splat(1), splat(1), splat(1)} - mirrored) * (1 - metal);
  return select(is_glossy, matt * left + mirrored * load(block.throughput) * lobe, matt);
}

}  // namespace
}  // namespace uwsim::camera
