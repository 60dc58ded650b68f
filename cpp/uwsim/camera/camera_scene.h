#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/camera/kernel.h"
#include "uwsim/camera/material.h"
#include "uwsim/camera/ripples.h"
#include "uwsim/camera/texture.h"
#include "uwsim/core/pose.h"
#include "uwsim/world/ray_scene.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// What a label is, for pictures and for those who learn from them.
enum class SurfaceClass : std::uint8_t { kNothing, kTerrain, kStructure, kPipeline, kGate, kStation, kVehicle };
inline constexpr std::array<std::string_view, 7> kSurfaceClassNames = {"nothing", "terrain", "structure", "pipeline",
                                                                       "gate",    "station", "vehicle"};

struct SurfaceLook {
  camera::MaterialRow material;
  SurfaceClass kind = SurfaceClass::kStructure;
  std::shared_ptr<const Texture> texture;
};

/// A vehicle as cameras see it: its hull, which moves. Body frame.
struct Body {
  std::string name;
  std::shared_ptr<const RayScene> hull;
  Eigen::Vector3d middle_body_m;
  double radius_m;
  SurfaceLook look;
};

/// The world that feeds physics and rays, with what light needs to know of it; and the vehicles, which rays of the
/// world pass. Labels as World::label_names, then the bodies'.
class CameraScene {
 public:
  CameraScene(const World& world, std::shared_ptr<const RayScene> rays, std::uint64_t seed);

  /// Material and class of a solid; steel and structure until said. Throws InvalidValue for an unknown label.
  void set_look(Label label, const SurfaceLook& look);
  /// Of the terrain under water, where it is steep, and above water.
  void set_ground(const camera::MaterialRow& bed, const camera::MaterialRow& steep, const camera::MaterialRow& land);
  /// Returns the body's index. `hull_body_m`: as of Craft.
  std::size_t add_body(std::string name, const TriangleMesh& hull_body_m, const SurfaceLook& look);

  const World& world() const { return world_; }
  const RayScene& rays() const { return *rays_; }
  std::uint64_t seed() const { return seed_; }
  const std::vector<Body>& bodies() const { return bodies_; }
  std::vector<std::string> label_names() const;
  std::vector<std::uint8_t> classes_by_label() const;
  /// Rows for the kernels: bed, steep and dry ground, then labels from 2 on.
  const std::vector<camera::MaterialRow>& materials() const { return materials_; }
  static int material_of(std::uint32_t label) { return label <= kTerrain ? 0 : static_cast<int>(label) + 1; }
  const Texture* texture_of(std::uint32_t label) const { return textures_[label].get(); }
  bool has_textures() const { return has_textures_; }

  /// The ripples of a wind at one time; the last is kept, since several cameras look at one moment.
  std::shared_ptr<const Ripples::Moment> ripples(double wind_m_s, double wind_towards_rad, double time_s, double index,
                                                 int threads) const;

 private:
  struct Kept {
    double wind_m_s, towards_rad, time_s, index;
    std::shared_ptr<const Ripples> ripples;
    std::shared_ptr<const Ripples::Moment> moment;
  };
  World world_;
  std::shared_ptr<const RayScene> rays_;
  std::uint64_t seed_;
  std::vector<camera::MaterialRow> materials_;
  std::vector<std::uint8_t> classes_;
  std::vector<std::shared_ptr<const Texture>> textures_;
  bool has_textures_ = false;
  std::vector<Body> bodies_;
  mutable std::mutex mutex_;
  mutable std::optional<Kept> kept_;
};

}  // namespace uwsim
