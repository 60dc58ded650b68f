#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "uwsim/rays/ray_scene.h"

namespace uwsim {

/// The ray packets cast to render a picture, in order, for benchmarking against plain Embree.
struct RayRecord {
  struct Packet {
    std::int32_t kind;  ///< 0: cast, 1: occluded; plus 2 if coherent
    std::array<std::int32_t, kPacketRays> active;
    std::array<RayPacket::Lanes, 8> rows;  ///< origin x, y, z, direction x, y, z, near, far; relative to the camera
  };
  std::vector<Packet> packets;
};

}  // namespace uwsim
