#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/camera/kernels/kernels.h"
#include "uwsim/camera/material.h"
#include "uwsim/camera/ripples.h"
#include "uwsim/camera/smooth_mesh.h"
#include "uwsim/camera/texture.h"
#include "uwsim/camera/thin_solids.h"
#include "uwsim/core/fork_safe_mutex.h"
#include "uwsim/core/pose.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// The kind of object that a label denotes: the classes of labelled pictures, which the classes of cover follow.
enum class SurfaceClass : std::uint8_t { kNothing, kTerrain, kStructure, kPipeline, kGate, kStation, kVehicle };
inline constexpr std::array<std::string_view, 7> kSurfaceClassNames = {"nothing", "terrain", "structure", "pipeline",
                                                                       "gate",    "station", "vehicle"};

struct SurfaceAppearance {
  camera::Material material;
  SurfaceClass kind = SurfaceClass::kStructure;
  std::optional<TextureImage> texture;
};

/// The scene that cameras view: the world, as used for physics and rays, with materials and textures, and the vehicles'
/// hulls. Labels: World::label_names, followed by the vehicles.
class CameraScene {
 public:
  CameraScene(const World& world, std::shared_ptr<const RayScene> rays, std::uint64_t seed);

  /// A scene with the surfaces and appearances of `like`, in different water and with a different seed. Both scenes
  /// share the textures and the hulls' search structures.
  CameraScene(const CameraScene& like, const Water& water, std::uint64_t seed);

  /// Sets the material, class and texture of a solid; the defaults are steel, structure and no texture. Throws
  /// InvalidValue for an unknown label.
  void set_appearance(Label label, const SurfaceAppearance& appearance);
  /// Sets the material and the class of a layer of cover; a new name adds a class. Throws InvalidValue for an unknown
  /// label, or a texture where the layer has more than one mesh.
  void set_cover_appearance(Label label, const camera::Material& material, const std::string& surface_class,
                            const std::optional<TextureImage>& texture = std::nullopt);
  /// Sets the material of the terrain: under water, where it is steep, and above water.
  void set_ground(const camera::Material& bed, const camera::Material& steep, const camera::Material& land);
  /// Shows relief and patterns of fixed surfaces down to the footprint of a pixel.
  void show_detail() { has_detail_ = true; }
  bool has_detail() const { return has_detail_; }
  /// Sets the direction across ripples of sand, from x to y; by default see PreparedView::set_detail.
  void set_ripples(double across_rad) { ripples_rad_ = across_rad; }
  const std::optional<double>& ripples_rad() const { return ripples_rad_; }
  /// The number of materials of fixed surfaces, which come first in `materials`.
  int materials_of_fixed() const { return material_of(world_.labels_end()); }
  /// Adds a vehicle, or another moving body, and returns its index. Those added after all schools have labels after
  /// theirs. `hull_body_m`: as for Craft. Throws InvalidValue for a texture made for a
  /// different mesh.
  std::size_t add_vehicle(std::string name, const TriangleMesh& hull_body_m, const SurfaceAppearance& appearance);

  /// Adds the appearance of the world's next school of fish, after all vehicles; a new class is added. Throws
  /// InvalidValue.
  void add_school(const camera::Material& material, const std::string& surface_class);

  const World& world() const { return world_; }
  std::uint64_t seed() const { return seed_; }
  std::size_t vehicles() const { return vehicle_names_.size(); }
  /// Returns the world's rays, plus the vehicles at these poses except the `hidden` one, and the schools at this time.
  /// Without poses, there are neither vehicles nor schools.
  RayScene rays_among(std::span<const Pose> world_from_vehicles, std::optional<std::size_t> hidden,
                      double time_s) const;
  std::vector<std::string> label_names() const;
  std::vector<std::uint8_t> classes_by_label() const;
  /// kSurfaceClassNames, then the classes of cover.
  const std::vector<std::string>& class_names() const { return class_names_; }
  /// The bed, steep ground and dry ground, followed by one material for each label from 2 on.
  const std::vector<camera::Material>& materials() const { return materials_; }
  static int material_of(std::uint32_t label) { return label <= kTerrain ? 0 : static_cast<int>(label) + 1; }
  const Texture* texture_of(std::uint32_t label) const { return textures_[label].get(); }
  bool has_textures() const { return has_textures_; }
  /// The mesh of a solid or a vehicle, null for others.
  const SmoothMesh* smooth_mesh(std::uint32_t label) const { return smooth_meshes_[label].get(); }
  bool has_gloss() const { return has_gloss_; }
  /// The world's solids that cover parts of pixels.
  const std::vector<ThinSolid>& thin_solids() const { return thin_solids_; }

  /// The ripples caused by a wind over a fetch, at one time, with the caustics from `first_level` on. The last result
  /// is cached, because several cameras may render pictures of the same time.
  std::shared_ptr<const Ripples::Snapshot> ripples(double wind_m_s, double wind_towards_rad, double fetch_m,
                                                   double time_s, const FocusedSun& sun, int first_level,
                                                   int threads) const;

 private:
  void set_texture(std::size_t label, std::shared_ptr<const Texture> texture);
  std::uint8_t class_of(const std::string& surface_class);
  struct CachedRipples {
    double wind_m_s, towards_rad, fetch_m, time_s;
    FocusedSun sun;
    std::shared_ptr<const Ripples> ripples;
    std::shared_ptr<const Ripples::Snapshot> snapshot;
  };
  World world_;
  std::shared_ptr<const RayScene> rays_;
  std::uint64_t seed_;
  std::vector<camera::Material> materials_;
  std::vector<std::uint8_t> classes_;
  std::vector<std::string> class_names_;
  std::vector<std::shared_ptr<const Texture>> textures_;
  std::vector<std::shared_ptr<const SmoothMesh>> smooth_meshes_;
  std::vector<ThinSolid> thin_solids_;
  bool has_textures_ = false, has_gloss_ = false, has_detail_ = false;
  std::optional<double> ripples_rad_;
  std::vector<std::string> vehicle_names_;
  std::size_t before_schools_ = 0;  // of the vehicles
  MovingBodies hulls_;
  mutable ForkSafeMutex<std::mutex> mutex_;
  mutable std::optional<CachedRipples> cached_ripples_;
};

}  // namespace uwsim
