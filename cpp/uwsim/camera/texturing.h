#pragma once

#include "uwsim/camera/camera_scene.h"
#include "uwsim/camera/kernels/block.h"
#include "uwsim/camera/kernels/view.h"
#include "uwsim/camera/tracer.h"

namespace uwsim {

/// Sets the albedo, and for textures with more than colours the normal and the gloss, of a block's hits on textured
/// surfaces; has_texture and is_glossy of all lanes.
void set_textures(const CameraScene& scene, const Tracer& tracer, const camera::View& view, const HitPacket& hits,
                  camera::Block& block);

}  // namespace uwsim
