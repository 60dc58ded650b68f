#pragma once

#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/kernels/block.h"
#include "uwsim/camera/tracer.h"

namespace uwsim {

/// Replaces the normals of a block's hits on round surfaces without relief by those of the smooth surface for which
/// their facets stand, and sets `rise` of all lanes.
void set_smooth_normals(const CameraScene& scene, const Tracer& tracer, const HitPacket& hits, camera::Block& block);

/// Turns a surface's normal towards the eye, which cannot see a slope from behind; `direction` is that of the sight.
Eigen::Vector3f seen_normal(const Eigen::Vector3f& normal, const Eigen::Vector3f& direction);

}  // namespace uwsim
