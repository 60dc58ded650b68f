#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "uwsim/rays/embree.h"

namespace embree = uwsim::embree;

/// Builds Embree's scene from a triangle mesh, for the peers.
namespace embree_faces {

template <std::size_t corners>
using Faces = std::vector<std::array<std::uint32_t, corners>>;

/// Sorts faces into triangles and quads: with `pair`, triangles a, b, d and b, c, d that follow each other become the
/// quad a, b, c, d, which Embree cuts from b to d.
inline void sort(const std::vector<std::uint32_t>& indices, bool pair, Faces<3>& triangles, Faces<4>& quads) {
  for (std::size_t k = 0; k + 3 <= indices.size(); k += 3) {
    const std::uint32_t* t = &indices[k];
    if (pair && k + 6 <= indices.size() && t[1] == t[3] && t[2] == t[5]) {
      quads.push_back({t[0], t[1], t[4], t[2]});
      k += 3;
    } else {
      triangles.push_back({t[0], t[1], t[2]});
    }
  }
}

template <std::size_t corners>
void attach(RTCDevice device, RTCScene scene, const std::vector<float>& vertices_m, const Faces<corners>& faces) {
  if (faces.empty()) return;
  RTCGeometry geometry = rtcNewGeometry(device, corners == 3 ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                           vertices_m.size() / 3);
  void* indices =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, corners == 3 ? RTC_FORMAT_UINT3 : RTC_FORMAT_UINT4,
                              corners * sizeof(std::uint32_t), faces.size());
  std::memcpy(vertices, vertices_m.data(), vertices_m.size() * sizeof(float));
  std::memcpy(indices, faces.data(), faces.size() * sizeof(faces[0]));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

/// `as_quads`: Embree gets pairs of triangles that make up a quad as one quad, which is faster.
inline RTCScene build(RTCDevice device, const std::vector<float>& vertices_m, const std::vector<std::uint32_t>& indices,
                      bool as_quads) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  Faces<3> triangles;
  Faces<4> quads;
  sort(indices, as_quads, triangles, quads);
  attach(device, scene, vertices_m, triangles);
  attach(device, scene, vertices_m, quads);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace embree_faces
