#include "uwsim/world/terrain_solve_kernel.h"

namespace uwsim {

void solve_terrain_avx512(const TerrainBlock& block, const std::uint32_t* triangles, const TerrainRays& rays,
                          const TerrainHits& hits) {
  solve_terrain(block, triangles, rays, hits);
}

}  // namespace uwsim
