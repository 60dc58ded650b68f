// The limit that `uwsim bench sonar` measures against: rays built from pose and angle table, cast in Embree's 16-wide
// packets, and nothing else. Usage: embree_fan CASE [coherent] [quads], then a line on stdin for every run. `quads`:
// pairs of triangles that make up a quad are handed over as one, which is faster.
#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "ray_case.h"

namespace {

template <std::size_t corners>
using Faces = std::vector<std::array<std::uint32_t, corners>>;

/// Takes the pairs a, b, d and b, c, d that follow each other as quads a, b, c, d; Embree cuts these from b to d.
void sort(const RayCase& rays, bool pair, Faces<3>& triangles, Faces<4>& quads) {
  for (std::uint64_t k = 0; k < rays.triangle_count; ++k) {
    const std::uint32_t* t = &rays.triangles[3 * k];
    if (pair && k + 1 < rays.triangle_count && t[1] == t[3] && t[2] == t[5]) {
      quads.push_back({t[0], t[1], t[4], t[2]});
      ++k;
    } else {
      triangles.push_back({t[0], t[1], t[2]});
    }
  }
}

template <std::size_t corners>
void attach(RTCDevice device, RTCScene scene, const RayCase& rays, const Faces<corners>& faces) {
  if (faces.empty()) return;
  RTCGeometry geometry = rtcNewGeometry(device, corners == 3 ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                           rays.vertex_count);
  void* indices =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, corners == 3 ? RTC_FORMAT_UINT3 : RTC_FORMAT_UINT4,
                              corners * sizeof(std::uint32_t), faces.size());
  std::memcpy(vertices, rays.vertices_m.data(), rays.vertices_m.size() * sizeof(float));
  std::memcpy(indices, faces.data(), faces.size() * sizeof(faces[0]));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

bool asked(int count, char** arguments, const char* word) {
  return std::any_of(arguments + 2, arguments + count, [&](const char* a) { return std::strcmp(a, word) == 0; });
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: embree_fan CASE [coherent] [quads]\n");
    return 2;
  }
  const bool coherent = asked(count, arguments, "coherent");
  const RayCase rays(arguments[1]);
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  Faces<3> triangles;
  Faces<4> quads;
  sort(rays, asked(count, arguments, "quads"), triangles, quads);
  attach(device, scene, rays, triangles);
  attach(device, scene, rays, quads);
  rtcCommitScene(scene);

  answer(rays, [&](const double* pose) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) RTCRayHit16 packet;
    alignas(64) int valid[16];
    for (int k = 0; k < 16; ++k) {
      packet.ray.org_x[k] = static_cast<float>(pose[9]);
      packet.ray.org_y[k] = static_cast<float>(pose[10]);
      packet.ray.org_z[k] = static_cast<float>(pose[11]);
      packet.ray.tnear[k] = 0;
      packet.ray.time[k] = 0;
      packet.ray.mask[k] = ~0u;
      packet.ray.flags[k] = 0;
    }
    double sum = 0;
    for (std::uint64_t first = 0; first < rays.beam_count; first += 16) {
      for (std::uint64_t k = 0; k < 16; ++k) {
        const double* beam = &rays.beams[2 * std::min(first + k, rays.beam_count - 1)];
        packet.ray.dir_x[k] = static_cast<float>(pose[0] * beam[0] + pose[1] * beam[1]);
        packet.ray.dir_y[k] = static_cast<float>(pose[3] * beam[0] + pose[4] * beam[1]);
        packet.ray.dir_z[k] = static_cast<float>(pose[6] * beam[0] + pose[7] * beam[1]);
        packet.ray.tfar[k] = static_cast<float>(rays.range_max_m);
        packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        valid[k] = first + k < rays.beam_count ? -1 : 0;
      }
      rtcIntersect16(valid, scene, &context, &packet);
      for (int k = 0; k < 16; ++k) {
        if (valid[k] != 0 && packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID) sum += packet.ray.tfar[k];
      }
    }
    return sum;
  });
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
}
