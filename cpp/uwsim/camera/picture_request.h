#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "uwsim/camera/effects.h"
#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/lamp.h"
#include "uwsim/camera/ray_record.h"
#include "uwsim/core/body_state.h"
#include "uwsim/core/pose.h"

namespace uwsim {

/// One picture to render: position, time, light and effects.
struct PictureRequest {
  Pose world_from_camera;                       ///< in the middle of the middle row's exposure
  Vector6d velocity_camera = Vector6d::Zero();  ///< of the camera, in its own frame [m/s, rad/s]
  double time_s = 0;
  std::uint64_t tick = 0;  ///< keys the noise
  Effects effects = Effects::all();
  std::vector<SpotLamp> lamps;                ///< lamps that are switched on
  std::vector<Pose> world_from_vehicles;      ///< poses of all CameraScene::vehicles, or empty
  std::optional<std::size_t> hidden_vehicle;  ///< the vehicle that carries the camera and is not visible to it
  /// Light that adds at most this fraction to a pixel's radiance, summed over the bands, is added without a shadow ray.
  /// The default is half a step of 8 bits where a step is the smallest fraction of the signal: at full scale, where it
  /// is 0.9 %. So a shadow that is missed for this reason is hardly visible. At 0, all light is tested.
  float untested_share = 4e-3f;
  /// True if the picture needs no images of geometry, so that rays are cast only as far as one can see; the colours are
  /// the same.
  bool colours_only = false;
  bool geometry_only = false, keep_radiance = false;
  /// If set, the colours are written here, height x width x 3, instead of to the picture that is returned.
  std::uint8_t* rgb = nullptr;
  RayRecord* record = nullptr;               ///< if set, only one thread may be used
  const camera::Kernels* kernels = nullptr;  ///< if null, the fastest that this CPU supports; all produce the same bits
  int threads = 1;
};

}  // namespace uwsim
