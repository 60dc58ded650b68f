// Bullet's bare stepSimulation with one free body, with which `uwsim bench dynamics` compares.
// Usage: bullet_bare_step STEPS. Prints the processor time of that many steps of 5 ms, in seconds.
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

int main(int count, char** arguments) {
  const long steps = count == 2 ? std::strtol(arguments[1], nullptr, 10) : 0;
  if (steps <= 0) {
    std::fprintf(stderr, "usage: bullet_bare_step STEPS\n");
    return 2;
  }
  constexpr btScalar kStep_s = 0.005;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, 0});
  btBoxShape shape({0.2285, 0.2875, 0.127});  // the extents of a BlueROV2 Heavy
  btVector3 inertia;
  shape.calculateLocalInertia(13.5, inertia);
  btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(13.5, nullptr, &shape, inertia));
  body.setActivationState(DISABLE_DEACTIVATION);
  body.setAngularVelocity({0.1, 0.2, 0.3});
  world.addRigidBody(&body);

  for (int k = 0; k < 1000; ++k) world.stepSimulation(kStep_s, 1, kStep_s);
  const std::clock_t start = std::clock();
  for (long k = 0; k < steps; ++k) world.stepSimulation(kStep_s, 1, kStep_s);
  std::printf("%.9f\n", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  world.removeRigidBody(&body);
  return 0;
}
