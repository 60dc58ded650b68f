#pragma once

#include "uwsim/camera/kernel_surface.h"

/// From light to film and from film to bytes. Included by kernel_*.cpp only.
namespace uwsim::camera {
namespace {

UWSIM_LANES Float brightness_of(Vector light) { return light.x * 0.2126f + light.y * 0.7152f + light.z * 0.0722f; }

/// How much each lane takes of the blocks before, of and after its own along one axis: a block's value stands at its
/// middle, 1.5 pixels from its first.
struct Hats {
  alignas(64) float across[3][kLanes], down[3][kLanes];
};
constexpr Hats hats() {
  Hats hats{};
  for (int k = 0; k < kLanes; ++k) {
    const float x = static_cast<float>(k % kBlockSide) / kBlockSide - 0.375f;
    const float y = static_cast<float>(k / kBlockSide) / kBlockSide - 0.375f;
    hats.across[0][k] = x < 0 ? -x : 0, hats.across[1][k] = 1 - (x < 0 ? -x : x), hats.across[2][k] = x < 0 ? 0 : x;
    hats.down[0][k] = y < 0 ? -y : 0, hats.down[1][k] = 1 - (y < 0 ? -y : y), hats.down[2][k] = y < 0 ? 0 : y;
  }
  return hats;
}
constexpr Hats kHats = hats();

/// How lit the water is in a pixel: 1 without shafts, less in shadows, more in bundled light; between blocks.
UWSIM_LANES Float shaft_at(const Shot& shot, int left, int top) {
  const int height = (shot.height + kBlockSide - 1) / kBlockSide;
  const int i = left / kBlockSide, j = top / kBlockSide;
  const int i0 = i > 0 ? i - 1 : 0, i2 = i + 1 < shot.shaft_width ? i + 1 : i;
  Float light;
  for (int n = 0; n < 3; ++n) {
    const int y = j + n - 1 < 0 ? 0 : (j + n - 1 < height ? j + n - 1 : height - 1);
    const float* row = shot.shafts + y * shot.shaft_width;
    const Float here =
        load(kHats.across[0]) * row[i0] + load(kHats.across[1]) * row[i] + load(kHats.across[2]) * row[i2];
    light = light + load(kHats.down[n]) * here;
  }
  return light;
}

UWSIM_LANES void write_film(const Shot& shot, int left, int top, const float* light, float* plane) {
  const std::size_t first = static_cast<std::size_t>(top) * shot.width + left;
  if (is_whole(shot, left, top)) {
    for (int row = 0; row < kBlockSide; ++row) {
      __builtin_memcpy(plane + first + row * shot.width, light + row * kBlockSide, kBlockSide * sizeof(float));
    }
    return;
  }
  for (int k = 0; k < kLanes; ++k) {
    const int u = k % kBlockSide, v = k / kBlockSide;
    if (left + u < shot.width && top + v < shot.height) plane[first + v * shot.width + u] = light[k];
  }
}

void expose(const Shot& shot, int left, int top, const Block& block, const Film& film, Row& brightness) {
  Vector light = load(block.light);
  const Vector beam = load(block.veil_beam);
  light = light + (shot.shaft_width > 0 ? beam * shaft_at(shot, left, top) : beam);
  Row3 out;
  store(out, light);
  write_film(shot, left, top, out.x.at, film.red);
  write_film(shot, left, top, out.y.at, film.green);
  write_film(shot, left, top, out.z.at, film.blue);
  store(brightness.at, square_root(max(brightness_of(light), Float{})));
}

struct Words {
  Unsigned word[4];
};

/// Philox4x32-10 as core/random.h has it, sixteen counters at once: the same words. Numbers stay in the low halves of
/// wide lanes throughout; what gathers in the high ones is never read.
UWSIM_LANES Words philox(Wide c0, Wide c1, Wide c2, Wide c3, std::uint64_t key) {
  auto k0 = static_cast<std::uint32_t>(key), k1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round) {
    const Wide p0 = times_low(c0, 0xD2511F53u), p1 = times_low(c2, 0xCD9E8D57u);
    c0 = (p1 >> 32) ^ c1 ^ k0;
    c1 = p1;
    c2 = (p0 >> 32) ^ c3 ^ k1;
    c3 = p0;
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  const auto low = [](Wide c) { return narrowed<std::uint32_t>(c); };
  return {{low(c0), low(c1), low(c2), low(c3)}};
}
UWSIM_LANES Float open_unit(Unsigned word) { return (to_float(bits_as<std::int32_t>(word >> 8)) + 0.5f) * 0x1p-24f; }

/// Standard normal numbers for the three bands of sixteen pixels, counted by tick and pixel (Box and Muller 1958).
UWSIM_LANES Vector normals(const Developing& d, int pixel) {
  Unsigned index;
  for (int k = 0; k < kLanes; ++k) index[k] = static_cast<std::uint32_t>(pixel + k);
  const Words words = philox(Wide(d.tick & 0xffffffffu), Wide(d.tick >> 32), widened<std::uint64_t>(index),
                             Wide(std::uint64_t{d.stream}), d.key);
  const Float r1 = square_root(-2 * logarithm(open_unit(words.word[0])));
  const Float r2 = square_root(-2 * logarithm(open_unit(words.word[2])));
  const Turn first = turned(open_unit(words.word[1])), second = turned(open_unit(words.word[3]));
  return {r1 * first.cosine, r1 * first.sine, r2 * second.cosine};
}

/// The transfer curve of sRGB (IEC 61966-2-1), within 4e-5: its power as a polynomial of the signal's fourth root.
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
  // Four bytes each, of which the next pixel overwrites the last.
  for (int k = 0; k + 1 < count; ++k) __builtin_memcpy(rgb + 3 * k, pixels + k, 4);
  __builtin_memcpy(rgb + 3 * (count - 1), pixels + count - 1, 3);
}

/// One row of the film to bytes: vignetting (cos^4 of the angle off the axis, in part), gain, photon and read noise
/// (variance iso x / full_well + (iso read / full_well)^2 of a signal x whose full scale is 1), the transfer curve.
void develop(const Shot& shot, const Developing& d, const Film& film, int row, std::uint8_t* rgb) {
  const float shot_noise = d.iso / d.full_well, read = d.iso * d.read_noise / d.full_well;
  for (int first = 0; first < shot.width; first += kLanes) {
    const int count = shot.width - first < kLanes ? shot.width - first : kLanes;
    const int at = row * shot.width + first;
    Vector light = {load_some(film.red + at, count), load_some(film.green + at, count),
                    load_some(film.blue + at, count)};
    const Float x = load_some(shot.ray_x + at, count), y = load_some(shot.ray_y + at, count);
    const Float cos2 = 1 / (1 + x * x + y * y);
    light = light * (d.gain * (1 - d.vignetting + d.vignetting * cos2 * cos2));
    if (d.has_noise) {
      const Vector drawn = normals(d, at);
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
