#include "uwsim/camera/texturing.h"

#include <algorithm>
#include <cmath>

#include "uwsim/camera/block_lane.h"
#include "uwsim/camera/smoothing.h"

namespace uwsim {
namespace {

constexpr float kLeastSlant = 0.02f;  // sine of the angle below which a footprint becomes no longer

using camera::lane, camera::set_lane;

}  // namespace

void set_textures(const CameraScene& scene, const Tracer& tracer, const camera::View& view, const HitPacket& hits,
                  camera::Block& block) {
  for (int k = 0; k < camera::kBlockPixels; ++k) block.has_texture.at[k] = 0, block.is_glossy.at[k] = 0;
  if (!scene.has_textures()) return;
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
  std::uint32_t label = kTerrain, piece = 0;  // of `turn`
  for (std::size_t k = 0; k < camera::kBlockPixels; ++k) {
    const Texture* texture = scene.texture_of(block.label[k]);
    if (texture == nullptr) continue;
    if (block.label[k] != label || hits.piece[k] != piece) {
      label = block.label[k], piece = hits.piece[k];
      turn = tracer.mesh_turn(static_cast<Label>(label), piece);
    }
    const Eigen::Vector3f direction = lane(block.direction, k), normal = lane(block.normal, k);
    const float facing = normal.dot(direction), pixel_m = lane(block.point, k).norm() * view.pixel_rad;
    const Eigen::Matrix3f mesh_from_world = turn.transpose() / turn.col(0).squaredNorm();
    const Eigen::Vector3f across_m = normal.cross(direction).normalized() * pixel_m;
    const Eigen::Vector3f along_m =
        (direction - normal * facing).normalized() * (pixel_m / std::max(std::abs(facing), kLeastSlant));
    const TextureSample sample =
        texture->at(block.primitive[k], hits.u[k], hits.v[k], mesh_from_world * across_m, mesh_from_world * along_m);
    block.has_texture.at[k] = -1;
    block.texel_m.at[k] = sample.texel_m * turn.col(0).norm();
    set_lane(sample.albedo, k, block.texture_albedo);
    if (!texture->has_relief()) continue;
    const Eigen::Vector3f towards_eye = (facing > 0 ? -1.0f : 1.0f) * (turn * sample.normal_mesh).normalized();
    set_lane(seen_normal(towards_eye, direction), k, block.normal);
    if (!texture->has_gloss()) continue;
    block.is_glossy.at[k] = -1;
    block.roughness.at[k] = sample.roughness, block.metalness.at[k] = sample.metalness;
  }
}

}  // namespace uwsim
