#pragma once

#include <cstddef>
#include <cstdint>

#include "uwsim/acoustics/sound_speed_profile.h"

namespace uwsim {

/// The rays that are traced side by side.
inline constexpr std::size_t kBentTogether = 8;
/// The most pieces of a chord.
inline constexpr std::size_t kPiecesMax = 6;

/// The arcs of some rays, one row a quantity; see Arc.
struct ArcRows {
  using Row = double[kBentTogether];
  alignas(64) Row across_m, depth_m, dip_rad, time_s, length_m;
  alignas(64) Row cosine, sine, snell_s_m, curvature_1_m;
  alignas(64) Row top_m, bottom_m, reference_m, speed_m_s, gradient_1_s;
};

/// Rays being traced. The path of each lies in the vertical plane through (level_x, level_y).
struct BentRays {
  alignas(64) double level_x[kBentTogether], level_y[kBentTogether];
  ArcRows end;  ///< of the present chord
  /// The layers that the present chord passes: piece k leads from the start of pieces[k] to that of pieces[k + 1], or
  /// to the end of the chord.
  ArcRows pieces[kPiecesMax];
  alignas(64) double count[kBentTogether];  ///< of pieces
  alignas(64) double chord_m[kBentTogether];
  std::int32_t layer[kBentTogether];
  std::int32_t surfaces[kBentTogether];  ///< whether the chord ends at the water's surface; -1 or 0
  std::int32_t done[kBentTogether];      ///< -1 or 0
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
  alignas(64) double length_m[kBentTogether], time_s[kBentTogether];
  alignas(64) double x[kBentTogether], y[kBentTogether], z[kBentTogether];
  alignas(64) double arrival_x[kBentTogether], arrival_y[kBentTogether], arrival_z[kBentTogether];
};

/// Tracing of eight bent rays, compiled for one instruction set. All instruction sets produce the same bits.
struct BentKernels {
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
