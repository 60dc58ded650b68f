#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "uwsim/rays/ray_packet.h"
#include "uwsim/sonar/acoustic_multibeam.h"

// The parts of a ping that the files of AcousticMultibeam share.
namespace uwsim {

struct AcousticMultibeam::Transmission {
  const RayScene& scene;
  Pose world_from_sonar;
  Eigen::Matrix3f rotation;
  Eigen::Vector3f mach;         // velocity divided by the speed of sound, world frame
  double turn_rad_s;            // rate of the fan about its normal
  double depth_m, absorbed_db;  // depth of the head; absorption from the surface down to the head
  double sound_speed_m_s;       // at the head
  float cell_m;
  double false_alarm;  // probability that noise exceeds the threshold somewhere in a beam
  SpeckleField::View speckle;
  std::uint64_t tick;
  std::size_t samples;  // of each beam's water column
};

struct AcousticMultibeam::HitLanes {
  std::array<bool, kPacketRays> met;
  alignas(64) std::array<float, kPacketRays> length_m, range_m;  // of the path; half the way there and back
  alignas(64) std::array<float, kPacketRays> cosine;             // of the incidence
  std::array<std::array<float, 2>, kPacketRays> facets;          // the same, of two facets; only over ripples
  std::array<double, kPacketRays> depth_m;
  std::array<std::uint32_t, kPacketRays> label;
  std::array<std::size_t, kPacketRays> beam;
};

struct AcousticMultibeam::FanRays {
  Eigen::Matrix3Xf directions_world;  // beam by beam
  std::size_t first_beam;
  float beams_per_ray;

  std::size_t beam(std::size_t ray) const {
    return first_beam + static_cast<std::size_t>((static_cast<float>(ray) + 0.5f) * beams_per_ray);
  }
};

}  // namespace uwsim
