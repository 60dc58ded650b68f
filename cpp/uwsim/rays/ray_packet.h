#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace uwsim {

inline constexpr std::size_t kPacketRays = 16;

/// Whether the rays of a packet are coherent: they start close together and run in similar directions, as for a block
/// of a camera's pixels. Reflections are not coherent. This affects the speed, not the result.
enum class RayOrder { kIncoherent, kCoherent };

/// Sixteen rays in float, one row per coordinate, as loaded by vector units. Origins are in metres relative to an
/// anchor in double, so that float suffices; directions are unit vectors, world axes. A ray extends from `near_m` to
/// `far_m`. Idle lanes are not read.
struct RayPacket {
  using Lanes = std::array<float, kPacketRays>;
  alignas(64) Lanes origin_x, origin_y, origin_z;
  alignas(64) Lanes direction_x, direction_y, direction_z;
  alignas(64) Lanes near_m, far_m;
  alignas(64) std::array<std::int32_t, kPacketRays> active;  ///< -1 active, 0 idle
};

/// The first surface that each ray of a packet hit, in float, as found by Embree. Idle lanes hit nothing; u, v and
/// the normal of misses are uninitialised.
struct HitPacket {
  using Lanes = std::array<float, kPacketRays>;
  alignas(64) Lanes distance_m;                                  ///< infinity for a miss
  alignas(64) Lanes u, v;                                        ///< barycentric on triangles, 0 on round shapes
  alignas(64) Lanes normal_x, normal_y, normal_z;                ///< of any length, on the same side as in RayHit
  alignas(64) std::array<std::uint32_t, kPacketRays> label;      ///< a Label; 0 for a miss
  alignas(64) std::array<std::uint32_t, kPacketRays> primitive;  ///< triangle or round shape of the labelled object
  /// The number of the piece of cover or of the fish, 0 for other surfaces
  alignas(64) std::array<std::uint32_t, kPacketRays> piece;
  /// On cover: the unit normal, on the winding side, and the rise of the smooth surface that its facets stand for
  /// (CornerNormals). The normal is zero on other surfaces, and where there is none.
  alignas(64) Lanes smooth_x, smooth_y, smooth_z, rise_m;
  /// -1 if the distance was computed in double, else 0
  alignas(64) std::array<std::int32_t, kPacketRays> settled;
};

/// For each ray of a packet: -1 if something lies between near_m and far_m, else 0.
using Blocked = std::array<std::int32_t, kPacketRays>;

/// Sixteen rays in double, world frame, each from its origin to `far_m` along a unit vector.
struct ExactRays {
  using Lanes = std::array<double, kPacketRays>;
  alignas(64) Lanes origin_x, origin_y, origin_z;
  alignas(64) Lanes direction_x, direction_y, direction_z;
  alignas(64) Lanes far_m;
  alignas(64) std::array<std::int32_t, kPacketRays> active;  ///< -1 active, 0 idle; idle lanes hit nothing
};

/// The first hit of each ray on the true surface, computed in double.
struct ExactHits {
  using Lanes = std::array<double, kPacketRays>;
  alignas(64) Lanes distance_m;                              ///< infinity for a miss
  alignas(64) Lanes normal_x, normal_y, normal_z;            ///< unit, as in RayHit; zero for a miss
  alignas(64) std::array<std::uint32_t, kPacketRays> label;  ///< a Label; 0 for a miss
};

}  // namespace uwsim
