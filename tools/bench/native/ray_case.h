#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

/// The input of the native peers of `uwsim bench sonar`: a surface, a fan of beams, and poses to cast it from.
struct RayCase {
  std::uint64_t vertex_count, triangle_count, beam_count, pose_count;
  double range_max_m;
  std::vector<float> vertices_m;         // x, y, z
  std::vector<std::uint32_t> triangles;  // three corners
  std::vector<double> beams;             // cosine and sine of each angle
  std::vector<double> poses;             // rotation by rows, then position [m]

  template <typename T>
  static void read(std::FILE* file, T* into, std::size_t count) {
    if (std::fread(into, sizeof(T), count, file) == count) return;
    std::fprintf(stderr, "the case file is too short\n");
    std::exit(2);
  }

  explicit RayCase(const char* path) {
    std::FILE* file = std::fopen(path, "rb");
    if (file == nullptr) {
      std::perror(path);
      std::exit(2);
    }
    read(file, &vertex_count, 1);
    read(file, &triangle_count, 1);
    read(file, &beam_count, 1);
    read(file, &pose_count, 1);
    read(file, &range_max_m, 1);
    vertices_m.resize(3 * vertex_count);
    triangles.resize(3 * triangle_count);
    beams.resize(2 * beam_count);
    poses.resize(12 * pose_count);
    read(file, vertices_m.data(), vertices_m.size());
    read(file, triangles.data(), triangles.size());
    read(file, beams.data(), beams.size());
    read(file, poses.data(), poses.size());
    std::fclose(file);
  }
};

/// For each line on stdin, calls `cast` once for every pose; prints the processor time [s] and the sum of the results.
template <typename Cast>
void run_on_request(const RayCase& rays, const Cast& cast) {
  std::printf("ready\n");
  std::fflush(stdout);
  char line[64];
  while (std::fgets(line, sizeof line, stdin) != nullptr) {
    const std::clock_t start = std::clock();
    double sum = 0;
    for (std::uint64_t k = 0; k < rays.pose_count; ++k) sum += cast(&rays.poses[12 * k]);
    std::printf("%.9f %.9g\n", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, sum);
    std::fflush(stdout);
  }
}
