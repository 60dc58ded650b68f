#pragma once

#include <cstddef>

#include "uwsim/camera/kernels/block_lanes.h"
#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/kernels/view.h"
#include "uwsim/core/lane_random.h"

/// Development: conversion of radiance to 8-bit sRGB, with vignetting and noise. Included only by the kernels.
namespace uwsim::camera {
namespace {

/// Standard normal draws for the three bands of sixteen pixels, keyed by tick and pixel (Box and Muller 1958).
UWSIM_LANES Vector standard_normals(const Development& d, int pixel) {
  Unsigned index;
  for (int k = 0; k < kLanes; ++k) index[k] = static_cast<std::uint32_t>(pixel + k);
  const PhiloxWords words = philox(Wide(d.tick & 0xffffffffu), Wide(d.tick >> 32), widened<std::uint64_t>(index),
                                   Wide(std::uint64_t{d.stream}), d.key);
  const Float r1 = square_root(-2 * logarithm(open_unit(words.word[0])));
  const Float r2 = square_root(-2 * logarithm(open_unit(words.word[2])));
  const SineCosine first = sine_cosine_of_turns(open_unit(words.word[1])),
                   second = sine_cosine_of_turns(open_unit(words.word[3]));
  return {r1 * first.cosine, r1 * first.sine, r2 * second.cosine};
}

/// The sRGB transfer curve (IEC 61966-2-1), within 4e-5: its power law is approximated by a polynomial in the fourth
/// root of the signal.
UWSIM_LANES Float srgb(Float linear) {
  const Float x = clamp(linear, 0, 1), q = square_root(square_root(x));
  const Float power = -6.4611606e-2f + q * (0.19613619f + q * (1.1226813f + q * (-0.33550179f + q * 8.1330307e-2f)));
  return select(x <= 0.0031308f, x * 12.92f, power);
}

UWSIM_LANES Float load_some(const float* from, int count) {
  if (count == kLanes) return load(from);
  Float value;
  for (int k = 0; k < count; ++k) value[k] = from[k];
  return value;
}

UWSIM_LANES void write_bytes(Int red, Int green, Int blue, int count, std::uint8_t* rgb) {
  alignas(64) std::int32_t pixels[kLanes];
  store(pixels, red | green << 8 | blue << 16);
  // Four bytes each; the next pixel overwrites the last one.
  for (int k = 0; k + 1 < count; ++k) __builtin_memcpy(rgb + 3 * k, pixels + k, 4);
  __builtin_memcpy(rgb + 3 * (count - 1), pixels + count - 1, 3);
}

/// Converts one row of radiance to bytes: vignetting (cos^4 of the angle off the axis, in part), gain, photon and read
/// noise (variance iso x / full_well + (iso read / full_well)^2 for a signal x with full scale 1), and the transfer
/// curve.
void develop_row(const View& view, const Development& d, const RadiancePlanes& planes, int row, std::uint8_t* rgb) {
  const float shot_noise = d.iso / d.full_well, read = d.iso * d.read_noise / d.full_well;
  for (int first = 0; first < view.width; first += kLanes) {
    const int count = view.width - first < kLanes ? view.width - first : kLanes;
    const int at = row * view.width + first;
    Vector light = {load_some(planes.red + at, count), load_some(planes.green + at, count),
                    load_some(planes.blue + at, count)};
    const Float x = load_some(view.lens_x + at, count), y = load_some(view.lens_y + at, count);
    const Float cos2 = 1 / (1 + x * x + y * y);
    light = light * (d.gain * (1 - d.vignetting + d.vignetting * cos2 * cos2));
    if (d.has_noise) {
      const Vector drawn = standard_normals(d, at);
      const auto noisy = [&](Float value, Float normal) {
        return value + normal * square_root(max(value, Float{}) * shot_noise + read * read);
      };
      light = {noisy(light.x, drawn.x), noisy(light.y, drawn.y), noisy(light.z, drawn.z)};
    }
    const auto level = [](Float linear) { return to_int(srgb(linear) * 255.0f + 0.5f); };
    write_bytes(level(light.x), level(light.y), level(light.z), count, rgb + 3 * static_cast<std::size_t>(at));
  }
}

}  // namespace
}  // namespace uwsim::camera
