#include "uwsim/world/terrain_solve.h"

#include "uwsim/world/terrain_solve_kernel.h"

namespace uwsim {

void solve_terrain_baseline(const TerrainBlock& block, const std::uint32_t* triangles, const TerrainRays& rays,
                            const TerrainHits& hits) {
  solve_terrain(block, triangles, rays, hits);
}

TerrainSolve best_terrain_solve() {
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return &solve_terrain_avx512;
  if (__builtin_cpu_supports("avx2")) return &solve_terrain_avx2;
  return &solve_terrain_baseline;
}

}  // namespace uwsim
