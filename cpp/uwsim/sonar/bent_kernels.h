#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// The rays that are traced side by side.
inline constexpr std::size_t kBentTogether = 16;
/// The most pieces of a chord.
inline constexpr std::size_t kPiecesMax = 6;

/// Values of the rays.
using BentRow = double[kBentTogether];

/// Points on rays and the arcs from there on, see Arc.
struct PieceRows {
  alignas(64) BentRow across_m, depth_m, dip_rad, time_s, length_m;
  alignas(64) BentRow cosine, sine, curvature_1_m, reference_m, speed_m_s, gradient_1_s;
};

/// Rays being traced. The path of each lies in the vertical plane through (level_x, level_y).
struct BentRays {
  alignas(64) BentRow level_x, level_y;
  alignas(64) BentRow snell_s_m;
  alignas(64) BentRow top_m, bottom_m;  ///< the depths that bound the layer in which the present chord ends
  PieceRows end;                        ///< the end of the present chord
  /// The pieces of the present chord, one in each layer: piece k leads from the start of pieces[k] to that of
  /// pieces[k + 1], the last to the end of the chord.
  PieceRows pieces[kPiecesMax];
  alignas(64) BentRow count;  ///< of pieces
  alignas(64) BentRow chord_m;
  std::int32_t layer[kBentTogether];
  std::int32_t surfaces[kBentTogether];  ///< whether the chord ends at the water's surface; -1 or 0
  std::int32_t done[kBentTogether];      ///< -1 or 0
};

/// The place from which rays start, and the numbers of the layers that they enter there, downwards and upwards.
struct BentStart {
  double depth_m, speed_m_s;
  std::int32_t below, above;
};

/// Unit vectors.
struct DirectionRows {
  alignas(64) BentRow x, y, z;
};

/// Chords to be cast, relative to the start of the rays.
struct ChordRows {
  float *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *far_m;
  std::int32_t* active;
};

/// Hits on chords.
struct ChordHits {
  const float *distance_m, *normal_x, *normal_y, *normal_z;
  const std::int32_t* found;  ///< -1 or 0
};

/// Hits on paths: place [m] relative to the start of the rays, and the direction in which the path arrives.
struct PathHits {
  alignas(64) BentRow length_m, time_s;
  alignas(64) BentRow x, y, z;
  alignas(64) BentRow arrival_x, arrival_y, arrival_z;
};

/// Tracing of bent rays, compiled for one instruction set. All instruction sets produce the same bits.
struct BentKernels {
  /// Sets out rays in these directions. Those that start in air, and at the surface those that do not head down, are
  /// done.
  void (*start)(const SoundLayer* layers, const BentStart& from, const DirectionRows& directions, BentRays& rays);
  /// Sets the next chord of each ray that is not done: it ends where its distance from the path reaches the maximum, at
  /// the maximum time, or at the surface, whichever comes first. Rays without another chord are done.
  void (*next_chords)(const SoundLayer* layers, double start_depth_m, double time_max_s, BentRays& rays,
                      const ChordRows& chords);
  /// Moves hits from chords to paths, along the surface's tangent plane; where a ray grazes it, across the chord.
  void (*place_hits)(const BentRays& rays, double start_depth_m, const ChordHits& hits, PathHits& placed);
};

const BentKernels& baseline_bent_kernels();
const BentKernels& avx2_bent_kernels();
const BentKernels& avx512_bent_kernels();
/// The kernels for the widest instruction set that this processor supports.
const BentKernels& bent_kernels();

}  // namespace uwsim
