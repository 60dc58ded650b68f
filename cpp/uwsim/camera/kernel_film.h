#pragma once

#include "uwsim/camera/kernel_surface.h"

/// From light to film and from film to bytes. Included by kernel_*.cpp only.
namespace uwsim::camera {
namespace {

UWSIM_LANES Float brightness_of(Vector light) { return light.x * 0.2126f + light.y * 0.7152f + light.z * 0.0722f; }

/// How lit the water is in a pixel: 1 without shafts, less in shadows, more in bundled light; between blocks.
UWSIM_LANES Float shaft_at(const Shot& shot, int left, int top) {
  const int height = (shot.height + kBlockSide - 1) / kBlockSide;
  const int i = left / kBlockSide, j = top / kBlockSide;
  const auto value = [&](int x, int y) {
    x = x < 0 ? 0 : (x >= shot.shaft_width ? shot.shaft_width - 1 : x);
    y = y < 0 ? 0 : (y >= height ? height - 1 : y);
    return shot.shafts[y * shot.shaft_width + x];
  };
  Float light;
  for (int k = 0; k < kLanes; ++k) {
    // A block's value stands at its middle, 1.5 pixels from its first.
    const float x = static_cast<float>(k % kBlockSide) / kBlockSide - 0.375f;
    const float y = static_cast<float>(k / kBlockSide) / kBlockSide - 0.375f;
    const int di = x < 0 ? -1 : 0, dj = y < 0 ? -1 : 0;
    const float u = x - static_cast<float>(di), v = y - static_cast<float>(dj);
    light[k] = (1 - v) * ((1 - u) * value(i + di, j + dj) + u * value(i + di + 1, j + dj)) +
               v * ((1 - u) * value(i + di, j + dj + 1) + u * value(i + di + 1, j + dj + 1));
  }
  return light;
}

void expose(const Shot& shot, int left, int top, const Block& block, const Film& film, Row& brightness) {
  Vector light = load(block.light);
  const Vector beam = load(block.veil_beam);
  light = light + (shot.shaft_width > 0 ? beam * shaft_at(shot, left, top) : beam);
  for (int k = 0; k < kLanes; ++k) {
    const int u = left + k % kBlockSide, v = top + k / kBlockSide;
    if (u >= shot.width || v >= shot.height) continue;
    const int at = v * shot.width + u;
    film.red[at] = light.x[k];
    film.green[at] = light.y[k];
    film.blue[at] = light.z[k];
  }
  store(brightness.at, square_root(max(brightness_of(light), Float{})));
}

struct Words {
  Unsigned word[4];
};

/// Philox4x32-10 as core/random.h has it, sixteen counters at once: the same words.
UWSIM_LANES Words philox(Unsigned c0, Unsigned c1, Unsigned c2, Unsigned c3, std::uint64_t key) {
  auto k0 = static_cast<std::uint32_t>(key), k1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round) {
    const Wide p0 = widened<std::uint64_t>(c0) * 0xD2511F53ull, p1 = widened<std::uint64_t>(c2) * 0xCD9E8D57ull;
    const Unsigned high0 = narrowed<std::uint32_t>(p0 >> 32), low0 = narrowed<std::uint32_t>(p0);
    const Unsigned high1 = narrowed<std::uint32_t>(p1 >> 32), low1 = narrowed<std::uint32_t>(p1);
    c0 = high1 ^ c1 ^ k0;
    c1 = low1;
    c2 = high0 ^ c3 ^ k1;
    c3 = low0;
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  return {{c0, c1, c2, c3}};
}
UWSIM_LANES Float open_unit(Unsigned word) { return (to_float(bits_as<std::int32_t>(word >> 8)) + 0.5f) * 0x1p-24f; }

/// Standard normal numbers for the three bands of sixteen pixels, counted by tick and pixel (Box and Muller 1958).
UWSIM_LANES Vector normals(const Developing& d, int pixel) {
  Unsigned index;
  for (int k = 0; k < kLanes; ++k) index[k] = static_cast<std::uint32_t>(pixel + k);
  const Unsigned low = Unsigned{} + static_cast<std::uint32_t>(d.tick);
  const Unsigned high = Unsigned{} + static_cast<std::uint32_t>(d.tick >> 32);
  const Words words = philox(low, high, index, Unsigned{} + d.stream, d.key);
  const Float r1 = square_root(-2 * logarithm(open_unit(words.word[0])));
  const Float r2 = square_root(-2 * logarithm(open_unit(words.word[2])));
  const Float a1 = open_unit(words.word[1]) * (2 * kPi), a2 = open_unit(words.word[3]) * (2 * kPi);
  return {r1 * cosine(a1), r1 * sine(a1), r2 * cosine(a2)};
}

/// The transfer curve of sRGB (IEC 61966-2-1).
UWSIM_LANES Float srgb(Float linear) {
  const Float x = clamp(linear, 0, 1);
  const Float power = 1.055f * exponential(logarithm(max(x, splat(1e-6f))) * (1 / 2.4f)) - 0.055f;
  return select(x <= 0.0031308f, x * 12.92f, power);
}

/// One row of the film to bytes: vignetting (cos^4 of the angle off the axis, in part), gain, photon and read noise
/// (variance iso x / full_well + (iso read / full_well)^2 of a signal x whose full scale is 1), the transfer curve.
void develop(const Shot& shot, const Developing& d, const Film& film, int row, std::uint8_t* rgb) {
  const int start = row * shot.width;
  for (int first = 0; first < shot.width; first += kLanes) {
    const int count = shot.width - first < kLanes ? shot.width - first : kLanes;
    Vector light = zero();
    Float x{}, y{};
    for (int k = 0; k < count; ++k) {
      const int at = start + first + k;
      light.x[k] = film.red[at], light.y[k] = film.green[at], light.z[k] = film.blue[at];
      x[k] = shot.ray_x[at], y[k] = shot.ray_y[at];
    }
    const Float cos2 = 1 / (1 + x * x + y * y);
    light = light * (d.gain * (1 - d.vignetting + d.vignetting * cos2 * cos2));
    if (d.has_noise) {
      const float shot_noise = d.iso / d.full_well, read = d.iso * d.read_noise / d.full_well;
      const Vector drawn = normals(d, start + first);
      const auto noisy = [&](Float value, Float normal) {
        return value + normal * square_root(max(value, Float{}) * shot_noise + read * read);
      };
      light = {noisy(light.x, drawn.x), noisy(light.y, drawn.y), noisy(light.z, drawn.z)};
    }
    const Int red = to_int(srgb(light.x) * 255.0f + 0.5f), green = to_int(srgb(light.y) * 255.0f + 0.5f);
    const Int blue = to_int(srgb(light.z) * 255.0f + 0.5f);
    for (int k = 0; k < count; ++k) {
      std::uint8_t* pixel = rgb + 3 * (start + first + k);
      pixel[0] = static_cast<std::uint8_t>(red[k]);
      pixel[1] = static_cast<std::uint8_t>(green[k]);
      pixel[2] = static_cast<std::uint8_t>(blue[k]);
    }
  }
}

}  // namespace
}  // namespace uwsim::camera
