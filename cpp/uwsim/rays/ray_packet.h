#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace uwsim {

inline constexpr std::size_t kPacketRays = 16;

/// Whether the rays of a packet start together and run side by side (a camera's block of pixels) or not (reflections):
/// this affects the cost, not the result.
enum class RayOrder { kIncoherent, kCoherent };

/// Sixteen rays in float, one row per coordinate, as vector units load them. Origins are in metres relative to an
/// anchor given in double, so that float suffices; directions are unit vectors, world axes. A ray extends from `near_m`
/// to `far_m`. Idle lanes are not read.
struct RayPacket {
  using Lanes = std::array<float, kPacketRays>;
  alignas(64) Lanes origin_x, origin_y, origin_z;
  alignas(64) Lanes direction_x, direction_y, direction_z;
  alignas(64) Lanes near_m, far_m;
  alignas(64) std::array<std::int32_t, kPacketRays> active;  ///< -1 active, 0 idle
};

/// The first surface that each ray of a packet hit, in float, as found by Embree. Idle lanes are uninitialised; so are
/// u, v and the normal where nothing was hit.
struct HitPacket {
  using Lanes = std::array<float, kPacketRays>;
  alignas(64) Lanes distance_m;                                  ///< infinity where nothing was hit
  alignas(64) Lanes u, v;                                        ///< barycentric on triangles, 0 on round shapes
  alignas(64) Lanes normal_x, normal_y, normal_z;                ///< of any length; on the same side as in RayHit
  alignas(64) std::array<std::uint32_t, kPacketRays> label;      ///< a Label; 0 where nothing was hit
  alignas(64) std::array<std::uint32_t, kPacketRays> primitive;  ///< triangle or round shape of the labelled object
  /// -1 where the distance was computed in double, else 0
  alignas(64) std::array<std::int32_t, kPacketRays> settled;
};

/// For each ray of a packet: -1 where something lies between near_m and far_m, else 0.
using Blocked = std::array<std::int32_t, kPacketRays>;

/// Sixteen rays in double, world frame, each from its origin to `far_m` along a unit vector.
struct ExactRays {
  using Lanes = std::array<double, kPacketRays>;
  alignas(64) Lanes origin_x, origin_y, origin_z;
  alignas(64) Lanes direction_x, direction_y, direction_z;
  alignas(64) Lanes far_m;
  alignas(64) std::array<std::int32_t, kPacketRays> active;  ///< -1 active, 0 idle; idle lanes hit nothing
};

/// Where each ray first hits the true surface, computed in double.
struct ExactHits {
  using Lanes = std::array<double, kPacketRays>;
  alignas(64) Lanes distance_m;                              ///< infinity where nothing was hit
  alignas(64) Lanes normal_x, normal_y, normal_z;            ///< unit, as in RayHit; zero where nothing was hit
  alignas(64) std::array<std::uint32_t, kPacketRays> label;  ///< a Label; 0 where nothing was hit
};

}  // namespace uwsim
