// Embree alone, casting recorded packets of sixteen rays: the peer that `uwsim bench camera` measures against.
// Usage: embree_bare_rays FILE THREADS [quads]. For each line on stdin it casts all packets and prints the wall time
// and the processor time [s]. FILE, little-endian: uint64 counts of vertices, triangles, packets; float vertices x 3;
// uint32 triangles x 3; then for each packet int32 kind (0 cast, 1 occluded, + 2 where coherent), int32 active x 16,
// and eight rows of 16 floats: origin x, y, z, direction x, y, z, near, far.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <thread>
#include <vector>

#include "embree_faces.h"

namespace {

struct Packet {
  std::int32_t kind;
  std::int32_t active[16];
  float rows[8][16];
};

template <typename T>
std::vector<T> read(std::ifstream& file, std::size_t count) {
  std::vector<T> values(count);
  file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
  return values;
}

double cast(RTCScene scene, const Packet& packet) {
  RTCRayQueryContext context = embree::new_context();
  const bool coherent = (packet.kind & 2) != 0;
  alignas(64) RTCRayHit16 both;
  alignas(64) std::int32_t active[16];
  std::memcpy(active, packet.active, sizeof(active));
  float* rows[8] = {both.ray.org_x, both.ray.org_y, both.ray.org_z, both.ray.dir_x,
                    both.ray.dir_y, both.ray.dir_z, both.ray.tnear, both.ray.tfar};
  for (int row = 0; row < 8; ++row) std::memcpy(rows[row], packet.rows[row], sizeof(packet.rows[row]));
  for (int k = 0; k < 16; ++k) {
    both.ray.time[k] = 0;
    both.ray.mask[k] = ~0u;
    both.ray.flags[k] = 0;
    both.hit.geomID[k] = both.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
  if (packet.kind & 1) {
    embree::occluded(active, scene, context, coherent, both.ray);
  } else {
    embree::intersect(active, scene, context, coherent, both);
  }
  return both.ray.tfar[0];
}

}  // namespace

int main(int count, char** arguments) {
  const int threads = count >= 3 ? std::atoi(arguments[2]) : 0;
  const bool as_quads = count == 4 && std::strcmp(arguments[3], "quads") == 0;
  if (threads < 1) {
    std::fprintf(stderr, "usage: embree_bare_rays FILE THREADS [quads]\n");
    return 2;
  }
  std::ifstream file(arguments[1], std::ios::binary);
  const auto counts = read<std::uint64_t>(file, 3);
  const auto vertices = read<float>(file, 3 * counts[0]);
  const auto triangles = read<std::uint32_t>(file, 3 * counts[1]);
  const auto packets = read<Packet>(file, counts[2]);
  if (!file) {
    std::fprintf(stderr, "embree_bare_rays: cannot read %s\n", arguments[1]);
    return 1;
  }
  RTCDevice device = rtcNewDevice("verbose=0");
  RTCScene scene = embree_faces::build(device, vertices, triangles, as_quads);
  constexpr std::size_t kChunk = 160;  // packets; as many blocks as a picture has in a row
  std::printf("ready\n");
  std::fflush(stdout);
  while (std::getchar() != EOF) {
    std::atomic<std::size_t> next{0};
    std::atomic<double> sum{0};
    const auto run = [&] {
      double own = 0;
      for (std::size_t first = next.fetch_add(kChunk); first < packets.size(); first = next.fetch_add(kChunk)) {
        for (std::size_t k = first; k < first + kChunk && k < packets.size(); ++k) own += cast(scene, packets[k]);
      }
      sum = own;
    };
    const auto begun = std::chrono::steady_clock::now();
    const std::clock_t processor = std::clock();
    {
      std::vector<std::jthread> others;
      for (int k = 1; k < threads; ++k) others.emplace_back(run);
      run();
    }
    std::printf("%.9f %.9f\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(),
                static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC);
    std::fflush(stdout);
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return 0;
}
