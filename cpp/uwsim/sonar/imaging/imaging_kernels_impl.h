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

UWSIM_LANES Vector axes(const float (&rows)[3][16]) { return {load(rows[0]), load(rows[1]), load(rows[2])}; }

UWSIM_LANES Vector in_plane(const ArcFrames& arcs, const float* cosine, const float* sine) {
  return axes(arcs.ahead) * load(cosine) + axes(arcs.up) * load(sine);
}

UWSIM_LANES Vector arc_direction(const ArcFrames& arcs, const float* cosine, const float* sine) {
  return in_plane(arcs, cosine, sine) * load(arcs.cos_aside) + axes(arcs.aside) * load(arcs.sin_aside);
}

void directions(const ArcFrames& arcs, const ArcAngles& angles, float* x, float* y, float* z) {
  const Vector direction = arc_direction(arcs, angles.cosine, angles.sine);
  store(x, direction.x), store(y, direction.y), store(z, direction.z);
}

/// The range at which a ray in another direction meets the tangent plane, relative to the range of the hit. The
/// arguments are the dot products of the normal with the two directions.
UWSIM_LANES Float range_ratio(Float along, Float other) {
  const Float ratio = along / select(other < 0, other, splat(-1e-30f));
  return clamp(select(other < 0, ratio, splat(kPatchStretch)), 1 / kPatchStretch, kPatchStretch);
}

void patches(const ArcFrames& arcs, const ArcAngles& angles, const ArcHits& hits, const PatchRule& rule,
             const ArcPatches& out) {
  const Float distance = load(hits.distance_m);
  const Int hit = distance < 1e30f;
  const Vector met =
      select(hit, {load(hits.normal_x), load(hits.normal_y), load(hits.normal_z)}, {Float{}, Float{}, splat(1)});
  const Vector normal = unit(met);
  const Vector direction = arc_direction(arcs, angles.cosine, angles.sine);
  const Float along = dot(normal, direction);
  const Int echoes = hit & (along < 0) & (rule.head_z_m + distance * direction.z <= 0);
  const Float facing = select(echoes, along, splat(-1));
  const Float range = max(select(hit, distance, splat(1)), splat(kFarField_m));
  const Float one = range_ratio(facing, dot(normal, arc_direction(arcs, angles.lower_cosine, angles.lower_sine)));
  const Float other = range_ratio(facing, dot(normal, arc_direction(arcs, angles.upper_cosine, angles.upper_sine)));
  const Vector across =
      axes(arcs.aside) * load(arcs.cos_aside) - in_plane(arcs, angles.cosine, angles.sine) * load(arcs.sin_aside);
  const Float slope = dot(normal, across) * load(arcs.tan_half_width) / facing;
  const Float widened = min(abs(slope), splat(kPatchStretch - 1));
  const Float per_bin = range / splat(rule.bin_m);
  store(out.near_bin, per_bin * max(min(one, other) - widened, splat(1 / kPatchStretch)));
  store(out.far_bin, per_bin * (max(one, other) + widened));
  store(out.cosine, select(echoes, min(-along, splat(1)), Float{}));
  constexpr float kTwoWay = -0.2f * 2.30258509f;
  store(out.loss, exponential(range * (kTwoWay * rule.absorption_db_m)) / (range * range));
}

/// Adds an echo to the bins from `bin` on, a register at a time.
UWSIM_LANES void spread_one(double power, double near_bin, double far_bin, std::size_t bins, double* profile) {
  using Doubles = Native<double>::Part;
  using InMemory = Native<double>::InMemory;
  constexpr std::size_t kEach = sizeof(Doubles) / sizeof(double);
  alignas(64) static constexpr double kFirst[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  const Doubles numbers = *reinterpret_cast<const InMemory*>(kFirst);
  const double end = static_cast<double>(bins), length = far_bin - near_bin;
  if (!(near_bin < end)) return;
  auto bin = static_cast<std::size_t>(near_bin);
  if (length < 1e-9) {
    profile[bin] += power;
    return;
  }
  const double last = far_bin < end ? far_bin : end, whole = power / length;
  for (; static_cast<double>(bin) < last && bin + kEach <= bins; bin += kEach) {
    const double at = static_cast<double>(bin);
    Doubles added = Doubles{} + whole;
    if (at < near_bin || at + kEach > last) {
      const Doubles low = numbers + at, high = low + 1;
      const Doubles covered = (high < last ? high : Doubles{} + last) - (low > near_bin ? low : Doubles{} + near_bin);
      added = (covered > 0 ? power * covered : Doubles{}) / length;
    }
    *reinterpret_cast<InMemory*>(profile + bin) += added;
  }
  for (; static_cast<double>(bin) < last; ++bin) {
    const double at = static_cast<double>(bin);
    const double covered = (at + 1 < last ? at + 1 : last) - (at > near_bin ? at : near_bin);
    profile[bin] += power * covered / length;
  }
}

void spread(const double* power, const double* near_bin, const double* far_bin, std::size_t count, std::size_t bins,
            double* profile) {
  for (std::size_t k = 0; k < count; ++k) {
    if (power[k] > 0) spread_one(power[k], near_bin[k], far_bin[k], bins, profile);
  }
}

void store_row(const double* row, std::size_t bins, std::size_t rows, float* blocks) {
  for (std::size_t first = 0; first < bins; first += kBlockBins) {
    float* const block = blocks + first * rows;
    const std::size_t count = bins - first < kBlockBins ? bins - first : kBlockBins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < count; ++k) block[k] = static_cast<float>(row[first + k]);
    for (std::size_t k = count; k < kBlockBins; ++k) block[k] = 0;
  }
}

void sum_beams(const ProfileBlocks& profiles, const float* weights, std::size_t count, std::size_t step,
               std::size_t beams, double* sums) {
  constexpr std::size_t kBeams = 4, kWide = kNativeBytes == 64 ? 4 : 1, kEach = kWide * kLanes;
  const std::size_t all = count + (beams - 1) * step, bins = profiles.count * kBlockBins;
  for (std::size_t bin = 0; bin < bins; bin += kEach) {
    const float* const rows = profiles.blocks + bin / kBlockBins * profiles.rows * kBlockBins + bin % kBlockBins;
    Float sum[kBeams][kWide];
    for (std::size_t k = 0; k < all; ++k) {
      Float value[kWide];
#pragma GCC unroll 4
      for (std::size_t w = 0; w < kWide; ++w) value[w] = load(rows + k * kBlockBins + w * kLanes);
#pragma GCC unroll 4
      for (std::size_t beam = 0; beam < kBeams; ++beam) {
        const Float weight = splat(weights[k + (kBeams - 1 - beam) * step]);
#pragma GCC unroll 4
        for (std::size_t w = 0; w < kWide; ++w) sum[beam][w] += weight * value[w];
      }
    }
#pragma GCC unroll 4
    for (std::size_t beam = 0; beam < kBeams; ++beam) {
#pragma GCC unroll 4
      for (std::size_t w = 0; w < kWide; ++w) {
        store(sums + beam * bins + bin + w * kLanes, widened<double>(sum[beam][w]));
      }
    }
  }
}

void noise(const std::uint32_t* keys, const float* weights, std::size_t noises, std::size_t cells, float* row) {
  for (std::size_t first = 0; first < cells; first += kLanes) {
    alignas(64) float real[kLanes] = {}, imaginary[kLanes] = {};
    for (std::size_t noise = 0; noise < noises; ++noise) {
      const std::uint32_t key = keys[noise] + static_cast<std::uint32_t>(first);
      const float weight = weights[noise];
#pragma GCC ivdep
      for (int k = 0; k < kLanes; ++k) {
        const auto [one, two] = byte_sums(mixed(key + static_cast<std::uint32_t>(k)));
        real[k] += weight * one;
        imaginary[k] += weight * two;
      }
    }
    const std::size_t count = cells - first < kLanes ? cells - first : kLanes;
#pragma GCC ivdep
    for (std::size_t k = 0; k < count; ++k) {
      row[2 * (first + k)] = real[k];
      row[2 * (first + k) + 1] = imaginary[k];
    }
  }
}

void sum_rows(const float* from, const float* weights, std::size_t rows, std::size_t count, float* sum) {
  std::size_t k = 0;
  for (; k + kLanes <= count; k += kLanes) {
    Float total;
    for (std::size_t row = 0; row < rows; ++row) total += splat(weights[row]) * load(from + row * count + k);
    store(sum + k, total);
  }
  for (; k < count; ++k) {
    float total = 0;
    for (std::size_t row = 0; row < rows; ++row) total += weights[row] * from[row * count + k];
    sum[k] = total;
  }
}

/// 10 log10 of positive numbers, from the logarithm of their mantissas in float.
UWSIM_LANES Float decibels(Double power) {
  const Wide bits = bits_as<std::uint64_t>(power);
  const Int exponent = bits_as<std::int32_t>(narrowed<std::uint32_t>(bits >> 52));
  const Wide mantissa = (bits & Wide(0x000fffffffffffffULL)) | Wide(0x3ff0000000000000ULL);
  const Float m = narrowed<float>(bits_as<double>(mantissa));
  return to_float(exponent - 1023) * 3.01029996f + logarithm(m) * 4.34294482f;
}

#if defined(__AVX512F__)
#define UWSIM_EVEN_LANES 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30
#define UWSIM_ODD_LANES 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31
#elif defined(__AVX2__)
#define UWSIM_EVEN_LANES 0, 2, 4, 6, 8, 10, 12, 14
#define UWSIM_ODD_LANES 1, 3, 5, 7, 9, 11, 13, 15
#else
#define UWSIM_EVEN_LANES 0, 2, 4, 6
#define UWSIM_ODD_LANES 1, 3, 5, 7
#endif

/// The amplitudes of sixteen cells for one of `looks` looks per cell.
template <bool kOneLook>
UWSIM_LANES void load_amplitudes(const float* speckle, std::uint32_t looks, std::uint32_t look, Float& real,
                                 Float& imaginary) {
  if constexpr (kOneLook) {
    constexpr int kParts = Float::kParts;
    const auto* const parts = reinterpret_cast<const Native<float>::InMemory*>(speckle);
    UWSIM_UNROLLED {
      const Float::Part first = parts[2 * p], second = parts[2 * p + 1];
      real.part[p] = __builtin_shufflevector(first, second, UWSIM_EVEN_LANES);
      imaginary.part[p] = __builtin_shufflevector(first, second, UWSIM_ODD_LANES);
    }
  } else {
    for (int k = 0; k < kLanes; ++k) {
      real[k] = speckle[2 * (static_cast<std::uint32_t>(k) * looks + look)];
      imaginary[k] = speckle[2 * (static_cast<std::uint32_t>(k) * looks + look) + 1];
    }
  }
}

#define UWSIM_BLOCKS _Pragma("GCC unroll 2") for (int b = 0; b < kBlocks; ++b)

/// Complex noise of one or two blocks of cells, from the words of the first block's counters: words 0 and 2 for the
/// first block, 1 and 3 for the second.
template <int kBlocks>
UWSIM_LANES void draw_noise(const ReceiverLanes& receiver, Unsigned cell, Float (&real)[kBlocks],
                            Float (&imaginary)[kBlocks]) {
  const PhiloxWords words = philox(Wide(receiver.ping & 0xffffffffu), Wide(receiver.ping >> 32),
                                   widened<std::uint64_t>(cell), Wide(std::uint64_t{receiver.stream}), receiver.key);
  Float radius[kBlocks];
  UWSIM_BLOCKS radius[b] = square_root(-2 * logarithm(open_unit(words.word[b])));
  UWSIM_BLOCKS {
    const SineCosine angle = sine_cosine_of_turns(open_unit(words.word[2 + b]));
    real[b] = radius[b] * angle.cosine;
    imaginary[b] = radius[b] * angle.sine;
  }
}

/// Converts blocks of sixteen bins. Amplitudes are computed in float, limited to its range, and powers in double.
template <int kBlocks, bool kOneLook>
UWSIM_LANES void receive_blocks(const ReceiverLanes& receiver, const double* echo, const float* speckle,
                                const float* gain_db, std::uint32_t first_cell, double* received, float* level_db) {
  Double mean[kBlocks], power[kBlocks];
  UWSIM_BLOCKS mean[b] = load(echo + b * kLanes) * Double(receiver.source);
  if (receiver.looks == 0) {
    UWSIM_BLOCKS power[b] = mean[b] + Double(receiver.noise);
  } else {
    const std::uint32_t looks = kOneLook ? 1 : static_cast<std::uint32_t>(receiver.looks);
    alignas(64) static constexpr std::uint32_t kNumbers[kLanes] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                                   8, 9, 10, 11, 12, 13, 14, 15};
    const Float noise = splat(static_cast<float>(std::sqrt(receiver.noise / 2)));
    const Unsigned first_index =
        (Unsigned(first_cell) + load(kNumbers) * Unsigned(receiver.cell_step)) * Unsigned(looks);
    Float amplitude[kBlocks];
    UWSIM_BLOCKS amplitude[b] = square_root(min(narrowed<float>(mean[b]), splat(3e38f)));
    for (std::uint32_t look = 0; look < looks; ++look) {
      Float noise_real[kBlocks], noise_imaginary[kBlocks];
      draw_noise<kBlocks>(receiver, first_index + Unsigned(look), noise_real, noise_imaginary);
      UWSIM_BLOCKS {
        Float real, imaginary;
        load_amplitudes<kOneLook>(speckle + 2 * static_cast<std::uint32_t>(b * kLanes) * looks, looks, look, real,
                                  imaginary);
        const Double x = widened<double>(amplitude[b] * real + noise * noise_real[b]);
        const Double y = widened<double>(amplitude[b] * imaginary + noise * noise_imaginary[b]);
        power[b] = power[b] + (x * x + y * y);
      }
    }
    if constexpr (!kOneLook) UWSIM_BLOCKS power[b] = power[b] * Double(1.0 / receiver.looks);
  }
  UWSIM_BLOCKS {
    store(received + b * kLanes, power[b]);
    store(level_db + b * kLanes, decibels(power[b]) + load(gain_db + b * kLanes));
  }
}
#undef UWSIM_BLOCKS

template <bool kOneLook>
void receive_all(const ReceiverLanes& receiver, const double* echo, const float* speckle, const float* gain_db,
                 std::size_t bins, double* received, float* level_db) {
  const auto looks = static_cast<std::size_t>(receiver.looks);
  const auto cell = [&](std::size_t bin) {
    return receiver.first_cell + static_cast<std::uint32_t>(bin) * receiver.cell_step;
  };
  std::size_t bin = 0;
  for (; bin + 2 * kLanes <= bins; bin += 2 * kLanes) {
    receive_blocks<2, kOneLook>(receiver, echo + bin, speckle + 2 * bin * looks, gain_db + bin, cell(bin),
                                received + bin, level_db + bin);
  }
  for (; bin < bins; bin += kLanes) {
    const std::size_t left = bins - bin < kLanes ? bins - bin : kLanes;
    double echoes[kLanes] = {}, powers[kLanes];
    float gains[kLanes] = {}, levels[kLanes], amplitudes[2 * 16 * kLanes] = {};
    std::memcpy(echoes, echo + bin, left * sizeof(double));
    std::memcpy(gains, gain_db + bin, left * sizeof(float));
    if (looks > 0) std::memcpy(amplitudes, speckle + 2 * bin * looks, 2 * left * looks * sizeof(float));
    receive_blocks<1, kOneLook>(receiver, echoes, amplitudes, gains, cell(bin), powers, levels);
    std::memcpy(received + bin, powers, left * sizeof(double));
    std::memcpy(level_db + bin, levels, left * sizeof(float));
  }
}

void receive(const ReceiverLanes& receiver, const double* echo, const float* speckle, const float* gain_db,
             std::size_t bins, double* received, float* level_db) {
  const auto& run = receiver.looks == 1 ? receive_all<true> : receive_all<false>;
  run(receiver, echo, speckle, gain_db, bins, received, level_db);
}

constexpr ImagingKernels kKernels{&directions, &patches, &spread, &store_row, &sum_beams, &noise, &sum_rows, &receive};

}  // namespace
}  // namespace uwsim
