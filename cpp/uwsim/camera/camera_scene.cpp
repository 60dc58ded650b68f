#include "uwsim/camera/camera_scene.h"

#include <algorithm>
#include <utility>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

std::shared_ptr<const Texture> laid_on(const TriangleMesh& mesh, const std::optional<TextureImage>& image) {
  return image ? std::make_shared<const Texture>(*image, mesh) : nullptr;
}

}  // namespace

CameraScene::CameraScene(const World& world, std::shared_ptr<const RayScene> rays, std::uint64_t seed)
    : world_(world), rays_(std::move(rays)), seed_(seed), hulls_(world.labels_end(), world.schools()) {
  require(rays_ != nullptr, "scene", "none", "must be a RayScene");
  materials_ = {material("sand"), material("rock"), material("land")};
  classes_ = {static_cast<std::uint8_t>(SurfaceClass::kNothing), static_cast<std::uint8_t>(SurfaceClass::kTerrain)};
  for (std::size_t k = 0; k < world_.solids().size(); ++k) {
    materials_.push_back(material("steel"));
    classes_.push_back(static_cast<std::uint8_t>(SurfaceClass::kStructure));
  }
  for (std::size_t k = 0; k < world_.cover().size(); ++k) {
    materials_.push_back(material("rock"));
    classes_.push_back(static_cast<std::uint8_t>(SurfaceClass::kStructure));
  }
  class_names_.assign(kSurfaceClassNames.begin(), kSurfaceClassNames.end());
  textures_.resize(classes_.size());
  smooth_meshes_.resize(classes_.size());
  for (std::size_t k = 0; k < world_.solids().size(); ++k)
    smooth_meshes_[kTerrain + 1 + k] = std::make_shared<const SmoothMesh>(world_.solids()[k]->mesh_world);
  thin_solids_ = uwsim::thin_solids(world_);
}

CameraScene::CameraScene(const CameraScene& like, const Water& water, std::uint64_t seed)
    : world_(like.world_),
      rays_(like.rays_),
      seed_(seed),
      materials_(like.materials_),
      classes_(like.classes_),
      class_names_(like.class_names_),
      textures_(like.textures_),
      smooth_meshes_(like.smooth_meshes_),
      thin_solids_(like.thin_solids_),
      has_textures_(like.has_textures_),
      has_gloss_(like.has_gloss_),
      has_detail_(like.has_detail_),
      ripples_rad_(like.ripples_rad_),
      vehicle_names_(like.vehicle_names_),
      before_schools_(like.before_schools_),
      hulls_(like.hulls_) {
  world_.water = water;
}

void CameraScene::set_appearance(Label label, const SurfaceAppearance& appearance) {
  require(label > kTerrain && label < world_.first_cover(), "label", label, "must be a solid's label");
  set_texture(label, laid_on(world_.solids()[label - kTerrain - 1]->mesh_world, appearance.texture));
  materials_[static_cast<std::size_t>(material_of(label))] = appearance.material;
  classes_[label] = static_cast<std::uint8_t>(appearance.kind);
}

void CameraScene::set_cover_appearance(Label label, const camera::Material& material, const std::string& surface_class,
                                       const std::optional<TextureImage>& texture) {
  require(label >= world_.first_cover() && label < world_.labels_end(), "label", label, "must be a cover's label");
  const std::vector<TriangleMesh>& meshes = world_.cover()[label - world_.first_cover()]->meshes;
  require(!texture || meshes.size() == 1, "texture", meshes.size(), "needs a layer with one mesh");
  set_texture(label, laid_on(meshes.front(), texture));
  materials_[static_cast<std::size_t>(material_of(label))] = material;
  classes_[label] = class_of(surface_class);
}

void CameraScene::set_texture(std::size_t label, std::shared_ptr<const Texture> texture) {
  has_textures_ = has_textures_ || texture;
  has_gloss_ = has_gloss_ || (texture && texture->has_gloss());
  textures_[label] = std::move(texture);
}

std::uint8_t CameraScene::class_of(const std::string& surface_class) {
  const auto known = static_cast<std::size_t>(std::ranges::find(class_names_, surface_class) - class_names_.begin());
  require(known < 255, "class", surface_class, "too many classes");
  if (known == class_names_.size()) class_names_.push_back(surface_class);
  return static_cast<std::uint8_t>(known);
}

void CameraScene::set_ground(const camera::Material& bed, const camera::Material& steep, const camera::Material& land) {
  materials_[0] = bed;
  materials_[1] = steep;
  materials_[2] = land;
}

std::size_t CameraScene::add_vehicle(std::string name, const TriangleMesh& hull_body_m,
                                     const SurfaceAppearance& appearance) {
  std::shared_ptr<const Texture> texture = laid_on(hull_body_m, appearance.texture);
  const std::size_t labels = world_.labels_end() + vehicles();
  const bool is_before = classes_.size() == labels;
  require(is_before || classes_.size() == labels + world_.schools().size(), "vehicle", name,
          "must be added before schools, or after all of them");
  if (!is_before) hulls_.add_after_schools();
  hulls_.add(hull_body_m);
  if (is_before) ++before_schools_;
  vehicle_names_.push_back(std::move(name));
  materials_.push_back(appearance.material);
  classes_.push_back(static_cast<std::uint8_t>(appearance.kind));
  textures_.emplace_back();
  smooth_meshes_.push_back(std::make_shared<const SmoothMesh>(hull_body_m));
  set_texture(textures_.size() - 1, std::move(texture));
  return vehicle_names_.size() - 1;
}

void CameraScene::add_school(const camera::Material& material, const std::string& surface_class) {
  const std::size_t all = world_.labels_end() + vehicles() + world_.schools().size();
  require(classes_.size() < all, "life", surface_class, "must be one for each school of the world");
  classes_.push_back(class_of(surface_class));
  materials_.push_back(material);
  textures_.push_back(nullptr);
  smooth_meshes_.push_back(nullptr);
}

RayScene CameraScene::rays_among(std::span<const Pose> poses, std::optional<std::size_t> hidden, double time_s) const {
  require(poses.empty() || poses.size() == vehicles(), "vehicles", poses.size(),
          "must be a pose for each vehicle, or none");
  const std::shared_ptr<const Sway> sway = Sway::of(world_, time_s);
  const RayScene rays = sway ? rays_->with_plants(sway) : *rays_;
  if (poses.empty()) return rays;
  const auto placed = std::make_shared<MovingBodies>(hulls_);
  for (std::size_t k = 0; k < poses.size(); ++k) placed->place(k, poses[k]);
  placed->place_schools(time_s);
  return rays.with(placed, hidden.value_or(MovingBodies::kNone));
}

std::vector<std::string> CameraScene::label_names() const {
  std::vector<std::string> names = world_.label_names();
  const auto schools = vehicle_names_.begin() + static_cast<std::ptrdiff_t>(before_schools_);
  names.insert(names.end(), vehicle_names_.begin(), schools);
  for (const auto& school : world_.schools()) names.push_back(school->name());
  names.insert(names.end(), schools, vehicle_names_.end());
  return names;
}

std::vector<std::uint8_t> CameraScene::classes_by_label() const { return classes_; }

std::shared_ptr<const Ripples::Snapshot> CameraScene::ripples(double wind_m_s, double towards_rad, double fetch_m,
                                                              double time_s, const FocusedSun& sun, int first_level,
                                                              int threads) const {
  const std::lock_guard lock(mutex_);
  const bool same_wind = cached_ripples_ && cached_ripples_->wind_m_s == wind_m_s &&
                         cached_ripples_->towards_rad == towards_rad && cached_ripples_->fetch_m == fetch_m;
  if (same_wind && cached_ripples_->time_s == time_s && cached_ripples_->sun == sun &&
      cached_ripples_->snapshot->first_level <= first_level) {
    return cached_ripples_->snapshot;
  }
  CachedRipples now{
      wind_m_s,
      towards_rad,
      fetch_m,
      time_s,
      sun,
      same_wind ? cached_ripples_->ripples : std::make_shared<const Ripples>(wind_m_s, towards_rad, fetch_m, seed_),
      nullptr};
  now.snapshot = std::make_shared<const Ripples::Snapshot>(now.ripples->at(time_s, sun, first_level, threads));
  cached_ripples_ = std::move(now);
  return cached_ripples_->snapshot;
}

}  // namespace uwsim
