#pragma once

#include <Eigen/Core>
#include <limits>

#include "uwsim/rays/ray_kernels.h"
#include "uwsim/rays/ray_packet.h"
#include "uwsim/rays/triangle_hit.h"
#include "uwsim/world/world.h"

namespace uwsim {

// Converts one lane of a packet to vectors, and back.

template <typename Packet>  // RayPacket, relative to its anchor; or ExactRays
Eigen::Vector3d origin_of(const Packet& rays, std::size_t lane) {
  return {rays.origin_x[lane], rays.origin_y[lane], rays.origin_z[lane]};
}

template <typename Packet>
Eigen::Vector3d direction_of(const Packet& rays, std::size_t lane) {
  return {rays.direction_x[lane], rays.direction_y[lane], rays.direction_z[lane]};
}

inline TileRay ray_of(const ExactRays& rays, std::size_t lane) {
  return {origin_of(rays, lane), direction_of(rays, lane), rays.far_m[lane]};
}

inline void set_ray(ExactRays& rays, std::size_t lane, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                    double far_m, bool active) {
  rays.origin_x[lane] = origin.x(), rays.origin_y[lane] = origin.y(), rays.origin_z[lane] = origin.z();
  rays.direction_x[lane] = direction.x(), rays.direction_y[lane] = direction.y(),
  rays.direction_z[lane] = direction.z();
  rays.far_m[lane] = far_m;
  rays.active[lane] = active ? -1 : 0;
}

inline void set_hit(ExactHits& hits, std::size_t lane, double distance_m, const Eigen::Vector3d& normal, Label label) {
  hits.distance_m[lane] = distance_m;
  hits.normal_x[lane] = normal.x(), hits.normal_y[lane] = normal.y(), hits.normal_z[lane] = normal.z();
  hits.label[lane] = label;
}

inline void set_miss(ExactHits& hits, std::size_t lane) {
  set_hit(hits, lane, std::numeric_limits<double>::infinity(), Eigen::Vector3d::Zero(), kNothing);
}

inline void set_all_missed(ExactHits& hits) {
  hits.distance_m.fill(std::numeric_limits<double>::infinity());
  hits.normal_x.fill(0);
  hits.normal_y.fill(0);
  hits.normal_z.fill(0);
  hits.label.fill(kNothing);
}

inline Eigen::Vector3d normal_of(const ExactHits& hits, std::size_t lane) {
  return {hits.normal_x[lane], hits.normal_y[lane], hits.normal_z[lane]};
}

inline void copy_lane(const ExactHits& from, ExactHits& to, std::size_t lane) {
  set_hit(to, lane, from.distance_m[lane], normal_of(from, lane), static_cast<Label>(from.label[lane]));
}

/// A packet of rays in the form that kernels accept.
inline LaneRays lanes_of(const ExactRays& rays) {
  return {rays.origin_x.data(),    rays.origin_y.data(),    rays.origin_z.data(), rays.direction_x.data(),
          rays.direction_y.data(), rays.direction_z.data(), rays.far_m.data(),    rays.active.data()};
}

}  // namespace uwsim
