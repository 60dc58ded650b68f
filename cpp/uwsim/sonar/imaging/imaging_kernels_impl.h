#pragma once

#include <cmath>
#include <cstring>

#include "uwsim/core/lane_random.h"
#include "uwsim/sonar/hashed_noise.h"
#include "uwsim/sonar/imaging/imaging_kernels.h"

// Compiled once for each instruction set, hence the anonymous namespace.
namespace uwsim {
namespace {

constexpr float kFarField_m = 0.05f;  // at shorter ranges there is no far field, and 1 / R^2 would diverge

UWSIM_LANES Vector in_plane(const ArcFrame& arc, const float* cosine, const float* sine) {
  return broadcast(arc.ahead) * load(cosine) + broadcast(arc.up) * load(sine);
}

UWSIM_LANES Vector arc_direction(const ArcFrame& arc, const float* cosine, const float* sine) {
  return in_plane(arc, cosine, sine) * splat(arc.cos_aside) + broadcast(arc.aside) * splat(arc.sin_aside);
}

void directions(const ArcFrame& arc, const ArcAngles& angles, float* x, float* y, float* z) {
  const Vector direction = arc_direction(arc, angles.cosine, angles.sine);
  store(x, direction.x), store(y, direction.y), store(z, direction.z);
}

/// The range at which a ray in another direction meets the tangent plane, relative to the range of the hit. The
/// arguments are the dot products of the normal with the two directions.
UWSIM_LANES Float range_ratio(Float along, Float other) {
  const Float ratio = along / select(other < 0, other, splat(-1e-30f));
  return clamp(select(other < 0, ratio, splat(kPatchStretch)), 1 / kPatchStretch, kPatchStretch);
}

void patches(const ArcFrame& arc, const ArcAngles& angles, const ArcHits& hits, const PatchRule& rule,
             const ArcPatches& out) {
  const Float distance = load(hits.distance_m);
  const Int hit = distance < 1e30f;
  const Vector met =
      select(hit, {load(hits.normal_x), load(hits.normal_y), load(hits.normal_z)}, {Float{}, Float{}, splat(1)});
  const Vector normal = unit(met);
  const Vector direction = arc_direction(arc, angles.cosine, angles.sine);
  const Float along = dot(normal, direction);
  const Int echoes = hit & (along < 0) & (rule.head_z_m + distance * direction.z <= 0);
  const Float facing = select(echoes, along, splat(-1));
  const Float range = max(select(hit, distance, splat(1)), splat(kFarField_m));
  const Float one = range_ratio(facing, dot(normal, arc_direction(arc, angles.lower_cosine, angles.lower_sine)));
  const Float other = range_ratio(facing, dot(normal, arc_direction(arc, angles.upper_cosine, angles.upper_sine)));
  const Vector across =
      broadcast(arc.aside) * splat(arc.cos_aside) - in_plane(arc, angles.cosine, angles.sine) * splat(arc.sin_aside);
  const Float slope = dot(normal, across) * splat(arc.tan_half_width) / facing;
  const Float widened = min(abs(slope), splat(kPatchStretch - 1));
  const Float per_bin = range / splat(rule.bin_m);
  store(out.near_bin, per_bin * max(min(one, other) - widened, splat(1 / kPatchStretch)));
  store(out.far_bin, per_bin * (max(one, other) + widened));
  store(out.cosine, select(echoes, min(-along, splat(1)), Float{}));
  constexpr float kTwoWay = -0.2f * 2.30258509f;
  store(out.loss, exponential(range * (kTwoWay * rule.absorption_db_m)) / (range * range));
}

using Doubles = double __attribute__((vector_size(64), aligned(8)));

UWSIM_LANES Doubles doubles_at(const double* from) {
  Doubles value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

void sum_beams(const double* rows, const double* weights, std::size_t count, std::size_t step, std::size_t beams,
               std::size_t bins, double* sums) {
  constexpr std::size_t kBeams = 4, kWide = 2, kEach = 8;
  const std::size_t all = count + (beams - 1) * step;
  std::size_t bin = 0;
  for (; bin + kWide * kEach <= bins; bin += kWide * kEach) {
    Doubles sum[kBeams][kWide] = {};
    for (std::size_t k = 0; k < all; ++k) {
      const Doubles value[kWide] = {doubles_at(rows + k * bins + bin), doubles_at(rows + k * bins + bin + kEach)};
#pragma GCC unroll 4
      for (std::size_t beam = 0; beam < kBeams; ++beam) {
        const double weight = weights[k + (kBeams - 1 - beam) * step];
#pragma GCC unroll 2
        for (std::size_t w = 0; w < kWide; ++w) sum[beam][w] += weight * value[w];
      }
    }
    for (std::size_t beam = 0; beam < kBeams; ++beam) {
      for (std::size_t w = 0; w < kWide; ++w) {
        std::memcpy(sums + beam * bins + bin + w * kEach, &sum[beam][w], sizeof(Doubles));
      }
    }
  }
  for (; bin < bins; ++bin) {
    for (std::size_t beam = 0; beam < beams; ++beam) {
      double sum = 0;
      for (std::size_t k = 0; k < count; ++k) {
        sum += weights[(kBeams - 1) * step + k] * rows[(beam * step + k) * bins + bin];
      }
      sums[beam * bins + bin] = sum;
    }
  }
}

void add_noise(std::uint32_t key, float weight, std::size_t cells, float* row) {
#pragma GCC ivdep
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const auto [one, two] = byte_sums(mixed(key + static_cast<std::uint32_t>(cell)));
    row[2 * cell] += weight * one;
    row[2 * cell + 1] += weight * two;
  }
}

void add_row(float weight, const float* from, std::size_t count, float* row) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < count; ++k) row[k] += weight * from[k];
}

UWSIM_LANES Double load_double(const double* from) {
  Double value;
  std::memcpy(value.part, from, sizeof value.part);
  return value;
}
UWSIM_LANES void store_double(double* to, Double value) { std::memcpy(to, value.part, sizeof value.part); }

/// 10 log10 of positive numbers, from the logarithm of their mantissas in float.
UWSIM_LANES Float decibels(Double power) {
  const Wide bits = bits_as<std::uint64_t>(power);
  const Int exponent = bits_as<std::int32_t>(narrowed<std::uint32_t>(bits >> 52));
  const Wide mantissa = (bits & Wide(0x000fffffffffffffULL)) | Wide(0x3ff0000000000000ULL);
  const Float m = narrowed<float>(bits_as<double>(mantissa));
  return to_float(exponent - 1023) * 3.01029996f + logarithm(m) * 4.34294482f;
}

/// Sixteen bins.
UWSIM_LANES void receive_lanes(const ReceiverLanes& receiver, const double* echo, const float* speckle,
                               std::uint32_t first_cell, double* received, Float gain_db, float* level_db) {
  const Double mean = load_double(echo) * Double(receiver.source);
  Double power;
  if (receiver.looks == 0) {
    power = mean + Double(receiver.noise);
  } else {
    alignas(64) double root[kLanes];
    store_double(root, mean);
    for (int k = 0; k < kLanes; ++k) root[k] = std::sqrt(root[k]);
    const Double amplitude = load_double(root), noise(std::sqrt(receiver.noise / 2));
    const auto looks = static_cast<std::uint32_t>(receiver.looks);
    for (std::uint32_t look = 0; look < looks; ++look) {
      Unsigned index;
      Float real, imaginary;
      for (int k = 0; k < kLanes; ++k) {
        const auto lane = static_cast<std::uint32_t>(k);
        index[k] = (first_cell + lane * receiver.cell_step) * looks + look;
        real[k] = speckle[2 * (lane * looks + look)];
        imaginary[k] = speckle[2 * (lane * looks + look) + 1];
      }
      const PhiloxWords words =
          philox(Wide(receiver.ping & 0xffffffffu), Wide(receiver.ping >> 32), widened<std::uint64_t>(index),
                 Wide(std::uint64_t{receiver.stream}), receiver.key);
      const Float radius = square_root(-2 * logarithm(open_unit(words.word[0])));
      const SineCosine angle = sine_cosine_of_turns(open_unit(words.word[2]));
      const Double x = amplitude * widened<double>(real) + noise * widened<double>(radius * angle.cosine);
      const Double y = amplitude * widened<double>(imaginary) + noise * widened<double>(radius * angle.sine);
      power = power + (x * x + y * y);
    }
    power = power * Double(1.0 / receiver.looks);
  }
  store_double(received, power);
  store(level_db, decibels(power) + gain_db);
}

void receive(const ReceiverLanes& receiver, const double* echo, const float* speckle, const float* gain_db,
             std::size_t bins, double* received, float* level_db) {
  const auto looks = static_cast<std::size_t>(receiver.looks);
  std::size_t bin = 0;
  for (; bin + kLanes <= bins; bin += kLanes) {
    receive_lanes(receiver, echo + bin, speckle + 2 * bin * looks,
                  receiver.first_cell + static_cast<std::uint32_t>(bin) * receiver.cell_step, received + bin,
                  load(gain_db + bin), level_db + bin);
  }
  if (bin == bins) return;
  const std::size_t left = bins - bin;
  double echoes[kLanes] = {}, powers[kLanes];
  float gains[kLanes] = {}, levels[kLanes], amplitudes[2 * 16 * kLanes] = {};
  std::memcpy(echoes, echo + bin, left * sizeof(double));
  std::memcpy(gains, gain_db + bin, left * sizeof(float));
  if (looks > 0) std::memcpy(amplitudes, speckle + 2 * bin * looks, 2 * left * looks * sizeof(float));
  receive_lanes(receiver, echoes, amplitudes,
                receiver.first_cell + static_cast<std::uint32_t>(bin) * receiver.cell_step, powers, load(gains),
                levels);
  std::memcpy(received + bin, powers, left * sizeof(double));
  std::memcpy(level_db + bin, levels, left * sizeof(float));
}

constexpr ImagingKernels kKernels{&directions, &patches, &sum_beams, &add_noise, &add_row, &receive};

}  // namespace
}  // namespace uwsim
