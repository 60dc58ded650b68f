// Bullet's rayTest over the same fans: a peer of `uwsim bench sonar`. Usage: bullet_fan CASE, then one line on stdin
// per run.
#include <btBulletCollisionCommon.h>

#include "ray_case.h"

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: bullet_fan CASE\n");
    return 2;
  }
  RayCase rays(arguments[1]);
  btIndexedMesh mesh;
  mesh.m_numTriangles = static_cast<int>(rays.triangle_count);
  mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(rays.triangles.data());
  mesh.m_triangleIndexStride = 3 * sizeof(std::uint32_t);
  mesh.m_numVertices = static_cast<int>(rays.vertex_count);
  mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(rays.vertices_m.data());
  mesh.m_vertexStride = 3 * sizeof(float);
  mesh.m_vertexType = PHY_FLOAT;
  btTriangleIndexVertexArray surface;
  surface.addIndexedMesh(mesh, PHY_INTEGER);
  btBvhTriangleMeshShape shape(&surface, true);
  btCollisionObject object;
  object.setCollisionShape(&shape);
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btCollisionWorld world(&dispatcher, &broadphase, &configuration);
  world.addCollisionObject(&object);

  run_on_request(rays, [&](const double* pose) {
    const btVector3 from(pose[9], pose[10], pose[11]);
    double sum = 0;
    for (std::uint64_t k = 0; k < rays.beam_count; ++k) {
      const double* beam = &rays.beams[2 * k];
      const btVector3 direction(pose[0] * beam[0] + pose[1] * beam[1], pose[3] * beam[0] + pose[4] * beam[1],
                                pose[6] * beam[0] + pose[7] * beam[1]);
      const btVector3 to = from + rays.range_max_m * direction;
      btCollisionWorld::ClosestRayResultCallback hit(from, to);
      world.rayTest(from, to, hit);
      if (hit.hasHit()) sum += rays.range_max_m * hit.m_closestHitFraction;
    }
    return sum;
  });
  world.removeCollisionObject(&object);
}
