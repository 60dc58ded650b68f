#include "uwsim/camera/renderer.h"

#include <algorithm>
#include <cmath>

#include "uwsim/camera/particles.h"
#include "uwsim/camera/parts.h"
#include "uwsim/camera/shafts.h"
#include "uwsim/camera/shot.h"
#include "uwsim/camera/tracer.h"
#include "uwsim/core/check.h"
#include "uwsim/core/random.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::kBlockPixels;
using camera::kBlockSide;
using camera::Mask;

constexpr double kWorldEnd_m = 1e6;
constexpr double kMiddleGrey = 0.18;
// Of the fixed exposure, at which white in full sun (radiance 1 / pi) comes out at 0.8.
constexpr double kSunnyGain = 0.8 * 3.14159265358979;
constexpr double kLeastGain = 0.25 * kSunnyGain, kMostGain = 2e4 * kSunnyGain;
constexpr double kMostShutter =
    30 * kSunnyGain;  // a gain that a longer shutter time gives; more is amplified, with noise

class Rendering {
 public:
  Rendering(const CameraScene& scene, const Camera& camera, const Optics& optics, const Exposure& exposure)
      : scene_(scene),
        camera_(camera),
        optics_(optics),
        exposure_(exposure),
        threads_(std::clamp(exposure.threads, 1, 256)),
        costs_(static_cast<std::size_t>(threads_)),
        begun_(std::chrono::steady_clock::now()),
        prepared_(scene, camera, optics, exposure),
        shot_(prepared_.shot),
        tracer_(scene, prepared_, exposure),
        kernels_(exposure.kernels != nullptr ? *exposure.kernels : camera::kernels()),
        classes_(scene.classes_by_label()) {
    costs_[0].seconds[kPrepare] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
  }

  Picture take(PictureCost* cost) {
    const auto pixels = static_cast<std::size_t>(shot_.width) * static_cast<std::size_t>(shot_.height);
    picture_.width = shot_.width;
    picture_.height = shot_.height;
    picture_.depth_m.resize(pixels);
    picture_.normals_world.resize(3 * pixels);
    picture_.labels.resize(pixels);
    picture_.classes.resize(pixels);
    if (!exposure_.geometry_only) {
      for (Plane<float>& plane : planes_) plane.resize(pixels);
      film_ = {planes_[0].data(), planes_[1].data(), planes_[2].data()};
      if (on(Effect::kShafts) && shot_.camera_wet && shot_.has_backscatter && shot_.beam_level[1] > 0) {
        shafts_ = cast_shafts(shot_, tracer_, kernels_, exposure_, costs_);
        shot_.shafts = shafts_.data();
        shot_.shaft_width = (shot_.width + kBlockSide - 1) / kBlockSide;
      }
    }
    const int rows = (shot_.height + kBlockSide - 1) / kBlockSide;
    brightness_.assign(static_cast<std::size_t>(rows), 0.0);
    for_rows(rows + 1, threads_, [&](int turn, int worker) {
      PictureCost& own = costs_[static_cast<std::size_t>(worker)];
      turn == 0 ? find_specks(own) : render_row(turn - 1, own);
    });
    if (!exposure_.geometry_only) finish();
    if (cost != nullptr) *cost = total_cost();
    return std::move(picture_);
  }

 private:
  bool on(Effect effect) const { return exposure_.effects.has(effect); }

  void find_specks(PictureCost& cost) {
    if (exposure_.geometry_only) return;
    StageClock clock(exposure_.measure, cost);
    drifting_ = specks(scene_, camera_, optics_, exposure_, shot_);
    clock.add(kSpecks);
  }

  void render_row(int row, PictureCost& cost) {
    StageClock clock(exposure_.measure, cost);
    Block block;
    HitPacket hits;
    const camera::GeometryPlanes planes{picture_.depth_m.data(), picture_.normals_world.data(), picture_.labels.data(),
                                        picture_.classes.data(), classes_.data()};
    for (int left = 0; left < shot_.width; left += kBlockSide) {
      const int top = row * kBlockSide;
      kernels_.aim(shot_, left, top, block);
      tracer_.cast(block, hits, RayOrder::kCoherent);
      cost.primary_rays += count(block.active);
      clock.add(kPrimary);
      place(hits, block);
      kernels_.write_geometry(shot_, left, top, block, planes);
      clock.add(kDepth);
      if (exposure_.geometry_only) continue;
      const Mask seen = block.active;
      kernels_.open_eye(shot_, block);
      shade(block, hits, true, cost, clock);
      if (any(block.onward)) follow_onward(block, hits, cost, clock);
      camera::Row root_brightness;
      kernels_.expose(shot_, left, top, block, film_, root_brightness);
      double& sum = brightness_[static_cast<std::size_t>(row)];
      for (int k = 0; k < kBlockPixels; ++k) sum += seen.at[k] ? static_cast<double>(root_brightness.at[k]) : 0.0;
      clock.add(kFilm);
    }
  }

  void place(const HitPacket& hits, Block& block) const {
    const auto beside = [](std::uint32_t label) { return label > kTerrain; };
    if (std::any_of(std::begin(block.label), std::end(block.label), beside)) tracer_.refine(hits, block);
    kernels_.place(shot_, block);
  }

  void follow_onward(Block& block, HitPacket& hits, PictureCost& cost, StageClock& clock) {
    kernels_.go_on(shot_, block);
    clock.add(kWater);
    tracer_.cast(block, hits, RayOrder::kIncoherent);
    cost.onward_rays += count(block.active);
    clock.add(kPrimary);
    place(hits, block);
    clock.add(kDepth);
    shade(block, hits, false, cost, clock);
  }

  /// What the water, the surfaces, daylight and lamps add along one straight piece of each ray.
  void shade(Block& block, const HitPacket& hits, bool first, PictureCost& cost, StageClock& clock) {
    kernels_.pass_water(shot_, block);
    kernels_.sky(shot_, block);
    clock.add(kWater);
    if (any(block.lit)) {
      dress(block, hits);
      kernels_.light_by_day(shot_, block);
      clock.add(kSurfaces);
      test_light(block, cost.sun_rays);
      clock.add(kSun);
      for (int lamp = 0; lamp < shot_.lamp_count; ++lamp) {
        kernels_.light_by_lamp(shot_, lamp, block);
        clock.add(kLampLight);
        if (any(block.wants)) test_light(block, cost.lamp_rays);
        clock.add(kLampShadows);
      }
    }
    if (first && shot_.has_backscatter && shot_.camera_wet) {
      for (int lamp = 0; lamp < shot_.lamp_count; ++lamp) kernels_.lamp_veil(shot_, lamp, block);
      clock.add(kLampLight);
    }
  }

  void test_light(Block& block, std::uint64_t& rays) const {
    Mask blocked{};
    if (on(Effect::kShadows) && any(block.wants)) {
      rays += count(block.wants);
      tracer_.occluded(block, blocked, RayOrder::kCoherent);
    }
    kernels_.add_light(shot_, blocked, block);
  }

  void dress(Block& block, const HitPacket& hits) const {
    for (int k = 0; k < kBlockPixels; ++k) {
      block.material.at[k] = CameraScene::material_of(block.label[k]);
      block.has_given.at[k] = 0;
    }
    if (!scene_.has_textures()) return;
    for (int k = 0; k < kBlockPixels; ++k) {
      const Texture* texture = scene_.texture_of(block.label[k]);
      if (texture == nullptr) continue;
      const auto lane = static_cast<std::size_t>(k);
      const std::array<float, 3> colour = texture->at(block.primitive[k], hits.u[lane], hits.v[lane]);
      block.has_given.at[k] = -1;
      block.given.x.at[k] = colour[0], block.given.y.at[k] = colour[1], block.given.z.at[k] = colour[2];
    }
  }

  void finish();
  void keep_radiance(int row);
  double gain() const;
  PictureCost total_cost() const;

  const CameraScene& scene_;
  const Camera& camera_;
  const Optics& optics_;
  const Exposure& exposure_;
  int threads_;
  std::vector<PictureCost> costs_;
  std::chrono::steady_clock::time_point begun_;
  PreparedShot prepared_;
  camera::Shot& shot_;
  Tracer tracer_;
  const camera::Kernels& kernels_;
  std::vector<std::uint8_t> classes_;
  Picture picture_;
  std::array<Plane<float>, 3> planes_;
  camera::Film film_{};
  std::vector<float> shafts_;
  std::vector<Speck> drifting_;
  std::vector<double> brightness_;  // of each row of blocks, so that their sum does not depend on who did which
};

/// Exposure, automatic so that the picture's mean comes out as middle grey: the mean of roots, squared, in which
/// neither darkness nor the glare of a lamp has the last word.
double Rendering::gain() const {
  const double correction = camera_.sensor().exposure;
  if (!on(Effect::kExposure)) return kSunnyGain * correction;
  double sum = 0;
  for (const double row : brightness_) sum += row;
  const double root = sum / static_cast<double>(picture_.depth_m.size());
  return std::clamp(correction * kMiddleGrey / std::max(root * root, 1e-12), kLeastGain, kMostGain);
}

void Rendering::finish() {
  const ImageSensor& sensor = camera_.sensor();
  picture_.gain = gain();
  picture_.rgb.resize(3 * picture_.depth_m.size());
  if (exposure_.keep_radiance) picture_.radiance.resize(picture_.rgb.size());
  const RandomStream random(scene_.seed(), camera_.name() + "/noise");
  camera::Developing developing{};
  developing.gain = static_cast<float>(picture_.gain);
  developing.iso = static_cast<float>(std::max(1.0, picture_.gain / kMostShutter));
  developing.vignetting = on(Effect::kVignetting) ? static_cast<float>(sensor.vignetting) : 0;
  developing.full_well = static_cast<float>(sensor.full_well);
  developing.read_noise = static_cast<float>(sensor.read_noise);
  developing.has_noise = on(Effect::kNoise);
  developing.key = random.key();
  developing.stream = random.stream();
  developing.tick = exposure_.tick;
  constexpr int kRows = 16;
  for_rows((shot_.height + kRows - 1) / kRows, threads_, [&](int band, int worker) {
    StageClock own(exposure_.measure, costs_[static_cast<std::size_t>(worker)]);
    const int first = band * kRows, last = std::min(shot_.height, first + kRows);
    add_specks(drifting_, picture_.depth_m, shot_, first, last, film_);
    own.add(kSpecks);
    for (int row = first; row < last; ++row) {
      kernels_.develop(shot_, developing, film_, row, picture_.rgb.data());
      if (exposure_.keep_radiance) keep_radiance(row);
    }
    own.add(kFilm);
  });
}

void Rendering::keep_radiance(int row) {
  const auto first = static_cast<std::size_t>(row) * static_cast<std::size_t>(shot_.width);
  for (std::size_t at = first; at < first + static_cast<std::size_t>(shot_.width); ++at) {
    for (std::size_t band = 0; band < 3; ++band) picture_.radiance[3 * at + band] = planes_[band][at];
  }
}

PictureCost Rendering::total_cost() const {
  PictureCost total;
  for (const PictureCost& cost : costs_) total.add(cost);
  return total;
}

}  // namespace

void Optics::check() const {
  water.check();
  require(particles_per_m3 >= 0 && particles_per_m3 <= 64, "optics.particles_per_m3", particles_per_m3,
          "must be in [0, 64] 1/m3");
}

Picture render(const CameraScene& scene, const Camera& camera, const Optics& optics, const Exposure& exposure,
               PictureCost* cost) {
  optics.check();
  const Pose& pose = exposure.world_from_camera;
  const Eigen::Vector3d& eye = pose.position_m;
  const std::string path = "camera '" + camera.name() + "' position_m";
  require(eye.allFinite() && pose.orientation.coeffs().allFinite(), path, eye.transpose(), "must be finite");
  require(eye.cwiseAbs().maxCoeff() <= kWorldEnd_m, path, eye.transpose(), "must be within 1000 km of the origin");
  if (const auto& terrain = scene.world().terrain()) {
    require(!(eye.z() < terrain->height_at(eye.x(), eye.y())), path, eye.transpose(), "must be above the ground");
  }
  require(exposure.record == nullptr || exposure.threads == 1, "threads", exposure.threads,
          "must be 1 where rays are recorded");
  return Rendering(scene, camera, optics, exposure).take(cost);
}

}  // namespace uwsim
