#include "uwsim/camera/camera_scene.h"

#include <algorithm>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
CameraScene::CameraScene(const World& world, std::shared_ptr<const RayScene> rays, std::uint64_t seed)
    : world_(world), rays_(std::move(rays)), seed_(seed) {
  require(rays_ != nullptr, "scene", "none", "must be a RayScene");
  materials_ = {material("sand"), material("rock"), material("land")};
  classes_ = {static_cast<std::uint8_t>(SurfaceClass::kNothing), static_cast<std::uint8_t>(SurfaceClass::kTerrain)};
  for (std::size_t k = 0; k < world_.solids().size(); ++k) {
    materials_.push_back(material("steel"));
    classes_.push_back(static_cast<std::uint8_t>(SurfaceClass::kStructure));
  }
  textures_.resize(classes_.size());
}

void CameraScene::set_look(Label label, const SurfaceLook& look) {
  require(label > kTerrain && label < world_.solids().size() + kTerrain + 1, "label", label, "must be a solid's label");
  if (look.texture) {
    look.texture->check();
    const std::size_t triangles = world_.solids()[label - kTerrain - 1]->mesh_world.triangles.size();
    require(look.texture->corners.size() == 6 * triangles, "texture.corners", look.texture->corners.size(),
            "must be six a triangle");
  }
  materials_[static_cast<std::size_t>(material_of(label))] = look.material;
  classes_[label] = static_cast<std::uint8_t>(look.kind);
  textures_[label] = look.texture;
  has_textures_ = has_textures_ || look.texture;
}

void CameraScene::set_ground(const camera::MaterialRow& bed, const camera::MaterialRow& steep,
                             const camera::MaterialRow& land) {
  materials_[0] = bed;
  materials_[1] = steep;
  materials_[2] = land;
}

std::size_t CameraScene::add_body(std::string name, const TriangleMesh& hull_body_m, const SurfaceLook& look) {
  World own;
  own.add_solid(name, hull_body_m);
  Eigen::Vector3d low = hull_body_m.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& v : hull_body_m.vertices_m) low = low.cwiseMin(v), high = high.cwiseMax(v);
  Body body{std::move(name), std::make_shared<const RayScene>(own), 0.5 * (low + high), 0.5 * (high - low).norm(),
            look};
  materials_.push_back(look.material);
  classes_.push_back(static_cast<std::uint8_t>(look.kind));
  textures_.push_back(nullptr);
  bodies_.push_back(std::move(body));
  return bodies_.size() - 1;
}

std::vector<std::string> CameraScene::label_names() const {
  std::vector<std::string> names = world_.label_names();
  for (const Body& body : bodies_) names.push_back(body.name);
  return names;
}

std::vector<std::uint8_t> CameraScene::classes_by_label() const { return classes_; }

std::shared_ptr<const Ripples::Moment> CameraScene::ripples(double wind_m_s, double towards_rad, double time_s,
                                                            double index, int threads) const {
  const std::lock_guard alone(mutex_);
  const bool same_wind = kept_ && kept_->wind_m_s == wind_m_s && kept_->towards_rad == towards_rad;
  if (same_wind && kept_->time_s == time_s && kept_->index == index) return kept_->moment;
  Kept now{wind_m_s,
           towards_rad,
           time_s,
           index,
           same_wind ? kept_->ripples : std::make_shared<const Ripples>(wind_m_s, towards_rad, seed_),
           nullptr};
  now.moment = std::make_shared<const Ripples::Moment>(now.ripples->at(time_s, index, threads));
  kept_ = std::move(now);
  return kept_->moment;
}

}  // namespace uwsim
