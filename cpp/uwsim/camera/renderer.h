#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "uwsim/camera/camera.h"
#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/daylight.h"
#include "uwsim/camera/effects.h"
#include "uwsim/camera/picture.h"

namespace uwsim {

/// What light is like in a place: its water, the sun, the wind that ruffles the surface, what drifts in the water.
struct Optics {
  WaterOptics water;
  Sun sun;
  double wind_m_s = 3;
  double wind_towards_rad = 0;
  double particles_per_m3 = 60;  ///< that are large enough to be seen one by one: assumed

  void check() const;
};

/// Packets that a picture cast through the world, in order, for benchmarks: what Embree alone would have to do.
struct RayRecord {
  struct Packet {
    std::int32_t kind;  ///< 0 cast, 1 occluded; + 2 where coherent
    std::array<std::int32_t, kPacketRays> active;
    std::array<RayPacket::Lanes, 8> rows;  ///< origin x, y, z, direction x, y, z, near, far; from the camera
  };
  std::vector<Packet> packets;
};

/// One picture to take.
struct Exposure {
  Pose world_from_camera;
  double time_s = 0;
  std::uint64_t tick = 0;  ///< keys the noise
  Effects effects = Effects::all();
  std::vector<Lamp> lamps;              ///< those that shine
  std::vector<Pose> world_from_bodies;  ///< of CameraScene::bodies
  std::optional<std::size_t> hidden;    ///< body that the camera rides on, which it does not see
  bool geometry_only = false, keep_radiance = false;
  bool measure = false;                      ///< the stages' cost
  RayRecord* record = nullptr;               ///< needs one thread
  const camera::Kernels* kernels = nullptr;  ///< null: the fastest that this CPU runs; all give the same bits
  int threads = 1;
};

/// Renders what a camera sees. Model, per band (Akkaynak and Treibitz 2018, "A revised underwater image formation
/// model", CVPR, in its single-scattering form): L = L_surface exp(-c r) + veil, the veil as in kernel_water.h, of
/// daylight by Kd and of lamps by their own integral. Lit surfaces are Lambertian. Valid where light is scattered into
/// the camera's path once: blur by forward scattering is left out, and light that surfaces throw on each other. Water
/// and its effects end at the world's surface; what refraction sends on is followed once. Same bytes whatever the
/// number of threads. Throws InvalidValue where the camera is below the ground; inside another solid it sees that
/// solid's inner side.
Picture render(const CameraScene& scene, const Camera& camera, const Optics& optics, const Exposure& exposure,
               PictureCost* cost = nullptr);

}  // namespace uwsim
