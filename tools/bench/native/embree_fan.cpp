// The limit that `uwsim bench sonar` measures against: rays built from poses and an angle table, cast in Embree's
// packets of sixteen, and nothing else. Usage: embree_fan CASE [coherent] [quads], then one line on stdin per run.
// `quads`: Embree gets pairs of triangles that make up a quad as one quad, which is faster.

#include <algorithm>
#include <cstring>

#include "embree_faces.h"
#include "ray_case.h"

namespace {

bool has_argument(int count, char** arguments, const char* word) {
  return std::any_of(arguments + 2, arguments + count, [&](const char* a) { return std::strcmp(a, word) == 0; });
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: embree_fan CASE [coherent] [quads]\n");
    return 2;
  }
  const bool coherent = has_argument(count, arguments, "coherent");
  const RayCase rays(arguments[1]);
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene =
      embree_faces::build(device, rays.vertices_m, rays.triangles, has_argument(count, arguments, "quads"));

  run_on_request(rays, [&](const double* pose) {
    RTCRayQueryContext context = embree::new_context();
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
      embree::intersect(valid, scene, context, coherent, packet);
      for (int k = 0; k < 16; ++k) {
        if (valid[k] != 0 && packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID) sum += packet.ray.tfar[k];
      }
    }
    return sum;
  });
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
}
