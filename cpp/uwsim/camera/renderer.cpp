#include "uwsim/camera/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "uwsim/camera/block_lane.h"
#include "uwsim/camera/block_mask.h"
#include "uwsim/camera/development.h"
#include "uwsim/camera/lamp_glow.h"
#include "uwsim/camera/parallel_rows.h"
#include "uwsim/camera/particles.h"
#include "uwsim/camera/prepared_view.h"
#include "uwsim/camera/shafts.h"
#include "uwsim/camera/smoothing.h"
#include "uwsim/camera/texturing.h"
#include "uwsim/camera/tracer.h"
#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

using camera::Block;
using camera::BlockMask;
using camera::kBlockPixels;
using camera::kBlockSide;

constexpr double kWorldEnd_m = 1e6;
constexpr float kCoarsePixel_rad = 6e-3f;
// The largest number of pictures whose mean is a blurred picture. It is odd, so that one of them belongs to the middle
// of the exposure.
constexpr int kMostExposureParts = 15;
constexpr int kBlurLattice = 4;  // one pixel in so many along each axis is looked at for the length of blur
// Where a thin solid is at most so many pixels thick, a pixel is the mean of its centre and of four other places, which
// lie in five different rows and columns of a fifth of a pixel.
constexpr float kThinPixels = 8;
constexpr std::array<std::array<float, 2>, 4> kPixelParts = {{{.2f, .4f}, {.4f, -.2f}, {-.2f, -.4f}, {-.4f, .2f}}};
// A row of blocks is rendered in this many parts, so that the threads finish at about the same time.
constexpr int kRowParts = 4;

/// The rendering of one picture. Parts of rows of blocks are rendered in parallel, then rows of pixels are developed.
class Rendering {
 public:
  Rendering(const CameraScene& scene, const Camera& camera, const Optics& optics, const PictureRequest& request)
      : scene_(scene),
        camera_(camera),
        optics_(optics),
        request_(request),
        threads_(std::clamp(request.threads, 1, 256)),
        prepared_(scene, camera, optics, request),
        view_(prepared_.view),
        tracer_(scene, prepared_.anchor_world_m, request),
        kernels_(request.kernels != nullptr ? *request.kernels : camera::kernels()),
        classes_(scene.classes_by_label()),
        thin_from_m_(classes_.size(), std::numeric_limits<float>::infinity()),
        keeps_geometry_(!request.colours_only || on(Effect::kParticles)) {
    find_thin_solids();
  }

  Picture render() {
    allocate();
    if (!request_.geometry_only && on(Effect::kShafts) && view_.camera_in_water && view_.has_backscatter &&
        view_.beam_level[1] > 0) {
      shafts_ = cast_shafts(view_, tracer_, kernels_, request_, threads_);
      view_.shafts = shafts_.light.data();
      view_.shaft_reach = shafts_.reach_m.data();
      view_.shaft_width = (view_.width + kBlockSide - 1) / kBlockSide;
    }
    // Parts of an exposure see the lamps from different places, and coarse pictures have no smooth blocks.
    if (!request_.geometry_only && view_.lamp_count > 0 && view_.has_backscatter && view_.camera_in_water &&
        !view_.moves && view_.pixel_rad < kCoarsePixel_rad) {
      glow_.emplace(view_, kernels_, threads_).show_in(view_);
    }
    const int row_parts = kRowParts * ((view_.height + kBlockSide - 1) / kBlockSide);
    root_luminance_.assign(static_cast<std::size_t>(row_parts), 0.0);
    const double shutter_s = camera_.sensor().shutter_s;
    if (view_.moves && shutter_s > 0 && !request_.geometry_only) {
      const double halves = std::min(0.5 * longest_blur(shutter_s), double{kMostExposureParts / 2});
      parts_ = 2 * static_cast<int>(std::ceil(halves)) + 1;  // less than a pixel apart
    }
    for (int part = 0; part < parts_; ++part) {
      view_.part_s = static_cast<float>(shutter_s * ((part + 0.5) / parts_ - 0.5));
      is_middle_ = part == parts_ / 2;
      if (!scene_.thin_solids().empty()) shift_views();
      for_rows(row_parts + 1, threads_, [&](int turn, int) {
        if (turn > 0) return render_row_part(turn - 1);
        if (part == 0) find_particles();
      });
      if (parts_ > 1) add_exposure();
    }
    if (parts_ > 1) bands_.swap(exposed_);
    if (!request_.geometry_only) develop();
    return std::move(picture_);
  }

 private:
  bool on(Effect effect) const { return request_.effects.has(effect); }

  /// Rays of a block and through other places in its pixels are at most its side away from one at its middle.
  void find_thin_solids() {
    const std::vector<ThinSolid>& solids = scene_.thin_solids();
    if (solids.empty()) return;
    std::vector<float> from_m;
    for (const ThinSolid& solid : solids) {
      from_m.push_back(solid.thickness_m / (kThinPixels * view_.pixel_rad));
      thin_from_m_[solid.label] = from_m.back();
    }
    thin_around_.emplace(solids, from_m, prepared_.anchor_world_m, kBlockSide * view_.pixel_rad);
  }

  void allocate() {
    const auto pixels = static_cast<std::size_t>(view_.width) * static_cast<std::size_t>(view_.height);
    if (keeps_geometry_) {
      picture_.width = view_.width;
      picture_.height = view_.height;
      picture_.depth_m.resize(pixels);
      picture_.normals_world.resize(3 * pixels);
      picture_.labels.resize(pixels);
      picture_.classes.resize(pixels);
      const World& world = scene_.world();
      if (!world.cover().empty() || !world.schools().empty()) picture_.pieces.resize(pixels);
    }
    if (request_.geometry_only) return;
    for (ImageBuffer<float>& band : bands_) band.resize(pixels);
    radiance_ = {bands_[0].data(), bands_[1].data(), bands_[2].data()};
  }

  /// How far points move in the picture during the exposure, in pixels: the farthest of a lattice of pixels.
  double longest_blur(double shutter_s) {
    const Eigen::Vector3f velocity = Eigen::Map<const Eigen::Vector3f>(view_.velocity);
    const Eigen::Vector3f spin =
        2 * std::numbers::pi_v<float> * view_.spin_turns_per_s * Eigen::Map<const Eigen::Vector3f>(view_.spin_axis);
    Block block;
    HitPacket hits;
    float most_rad_s = 0;
    for (int top = 0; top < view_.height; top += kBlurLattice * kBlockSide) {
      for (int left = 0; left < view_.width; left += kBlurLattice * kBlockSide) {
        kernels_.shaft_rays(view_, left, top, kBlurLattice, block);
        tracer_.cast(block, Tracer::everywhere(), hits, RayOrder::kCoherent);
        for (std::size_t k = 0; k < kBlockPixels; ++k) {
          if (!block.active.at[k]) continue;
          const Eigen::Vector3f way = camera::lane(block.direction, k), turning = spin.cross(way);
          const float away_m = block.distance.at[k];
          const Eigen::Vector3f across = (velocity - velocity.dot(way) * way) / away_m;
          most_rad_s = std::max(most_rad_s, std::isfinite(away_m) ? (across + turning).norm() : turning.norm());
        }
      }
    }
    return shutter_s * static_cast<double>(most_rad_s / view_.pixel_rad);
  }

  /// Adds the picture of a part of the exposure to their mean.
  void add_exposure() {
    const float share = 1.0f / static_cast<float>(parts_);
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      if (exposed_[band].empty()) exposed_[band].assign(bands_[band].size(), 0.0f);
      std::transform(bands_[band].begin(), bands_[band].end(), exposed_[band].begin(), exposed_[band].begin(),
                     [share](float part, float sum) { return sum + share * part; });
    }
  }

  void find_particles() {
    if (request_.geometry_only) return;
    particles_ = visible_particles(scene_, camera_, optics_, request_, view_);
  }

  void render_row_part(int row_part) {
    const int row = row_part / kRowParts, share = row_part % kRowParts;
    const int columns = (view_.width + kBlockSide - 1) / kBlockSide;
    const int first = share * columns / kRowParts, last = (share + 1) * columns / kRowParts;
    if (glow_) glow_->find_smooth(row, first, last);
    Block block;
    HitPacket hits;
    PixelParts others;
    camera::BlockFloats sight = Tracer::everywhere();
    const camera::GeometryPlanes geometry{picture_.depth_m.data(), picture_.normals_world.data(),
                                          picture_.labels.data(), picture_.classes.data(), classes_.data()};
    for (int column = first; column < last; ++column) {
      const int left = column * kBlockSide, top = row * kBlockSide;
      kernels_.primary_rays(view_, left, top, block);
      if (!request_.geometry_only) kernels_.start_paths(view_, block);
      if (!keeps_geometry_) kernels_.limit_to_sight(view_, block, sight);
      tracer_.cast(block, sight, hits, RayOrder::kCoherent);
      tracer_.locate_hits(view_, kernels_, hits, block);
      if (keeps_geometry_ && is_middle_) kernels_.write_geometry(view_, left, top, block, geometry);
      if (!picture_.pieces.empty() && is_middle_) picture_.keep_pieces(left, top, hits);
      if (request_.geometry_only) continue;
      const BlockMask pixels = block.active;
      const bool has_parts = may_see_thin(block) && cast_parts(left, top, sight, block, others);
      shade(block, hits, left, top);
      if (has_parts) add_parts(left, top, others, block);
      camera::BlockFloats root_luminance;
      kernels_.write_radiance(view_, left, top, block, radiance_, root_luminance);
      // Four sums, so that an addition need not wait for the previous one
      std::array<double, kBlockSide> sums{};
      for (std::size_t k = 0; k < kBlockPixels; ++k) {
        sums[k % kBlockSide] += pixels.at[k] ? static_cast<double>(root_luminance.at[k]) : 0.0;
      }
      root_luminance_[static_cast<std::size_t>(row_part)] += (sums[0] + sums[1]) + (sums[2] + sums[3]);
    }
  }

  /// The rays through other places in the pixels of a block.
  struct PixelParts {
    std::array<Block, kPixelParts.size()> blocks;
    std::array<HitPacket, kPixelParts.size()> hits;
  };

  /// Sets the views whose rays pass through the other places in each pixel.
  void shift_views() {
    using Axis = Eigen::Map<Eigen::Vector3f>;
    for (std::size_t k = 0; k < shifted_.size(); ++k) {
      shifted_[k] = view_;
      const auto [x, y] = kPixelParts[k];
      Axis(shifted_[k].ahead) += view_.pixel_rad * (x * Axis(view_.right) + y * Axis(view_.down));
    }
  }

  bool may_see_thin(const Block& block) const {
    constexpr std::size_t kMiddle = kBlockPixels / 2 + 1;  // in the third row and the second column of four
    return thin_around_ && thin_around_->may_be_met(kernels_, camera::lane(block.origin, kMiddle),
                                                    camera::lane(block.direction, kMiddle));
  }

  bool sees_thin(const Block& block) const {
    for (std::size_t k = 0; k < kBlockPixels; ++k) {
      if (block.active.at[k] && block.distance.at[k] > thin_from_m_[block.label[k]]) return true;
    }
    return false;
  }

  /// Casts the other rays of a block; returns whether any of its rays meets a thin solid where that is a few pixels
  /// thick.
  bool cast_parts(int left, int top, const camera::BlockFloats& sight, const Block& block, PixelParts& parts) {
    bool found = sees_thin(block);
    for (std::size_t k = 0; k < shifted_.size(); ++k) {
      Block& other = parts.blocks[k];
      kernels_.primary_rays(shifted_[k], left, top, other);
      kernels_.start_paths(view_, other);
      tracer_.cast(other, sight, parts.hits[k], RayOrder::kCoherent);
      tracer_.locate_hits(view_, kernels_, parts.hits[k], other);
      found = found || sees_thin(other);
    }
    return found;
  }

  /// Makes the light of a block the mean over the places in each pixel.
  void add_parts(int left, int top, PixelParts& parts, Block& block) {
    for (std::size_t k = 0; k < parts.blocks.size(); ++k) {
      shade(parts.blocks[k], parts.hits[k], left, top);
    }
    constexpr float kShare = 1.0f / (1 + kPixelParts.size());
    const auto take_mean = [&](camera::BlockVectors Block::*light) {
      for (camera::BlockFloats camera::BlockVectors::*band :
           {&camera::BlockVectors::x, &camera::BlockVectors::y, &camera::BlockVectors::z}) {
        for (std::size_t k = 0; k < kBlockPixels; ++k) {
          float& mean = (block.*light.*band).at[k];
          for (const Block& other : parts.blocks) mean += (other.*light.*band).at[k];
          mean *= kShare;
        }
      }
    };
    take_mean(&Block::radiance), take_mean(&Block::sun_backscatter);
  }

  void shade(Block& block, HitPacket& hits, int left, int top) {
    shade_segment(block, hits, true, left, top);
    if (any(block.onward)) continue_paths(block, hits, left, top);
  }

  void continue_paths(Block& block, HitPacket& hits, int left, int top) {
    kernels_.refract_or_reflect(view_, block);
    tracer_.cast(block, Tracer::everywhere(), hits, RayOrder::kIncoherent);
    tracer_.locate_hits(view_, kernels_, hits, block);
    shade_segment(block, hits, false, left, top);
  }

  /// Adds the light from water, sky, daylight and lamps along one segment of each path and at its end.
  void shade_segment(Block& block, const HitPacket& hits, bool first, int left, int top) {
    kernels_.apply_water(view_, block);
    if (first && view_.has_backscatter && view_.camera_in_water && view_.lamp_count > 0) {
      kernels_.add_glow(view_, left, top, block);
    }
    if (first) block.first_reach = block.reach;
    kernels_.add_sky(view_, block);
    if (any(block.lit)) {
      set_materials(block, hits);
      kernels_.shade_daylight(view_, block);
      if (any(block.needs_shadow_ray)) add_unless_shadowed(block);
      for (int lamp = 0; lamp < view_.lamp_count; ++lamp) {
        kernels_.shade_lamp(view_, lamp, block);
        if (any(block.needs_shadow_ray)) add_unless_shadowed(block);
      }
    }
  }

  /// Adds the light being tested where the shadow ray is not blocked.
  void add_unless_shadowed(Block& block) const {
    BlockMask blocked{};
    if (on(Effect::kShadows)) {
      tracer_.occluded(block, blocked, RayOrder::kCoherent);
    }
    kernels_.add_unblocked_light(view_, blocked, block);
  }

  void set_materials(Block& block, const HitPacket& hits) const {
    for (int k = 0; k < kBlockPixels; ++k) block.material.at[k] = CameraScene::material_of(block.label[k]);
    set_smooth_normals(scene_, tracer_, hits, block);
    set_textures(scene_, tracer_, view_, hits, block);
  }

  /// Converts radiance to bytes. Particles come last because they need the depth of the whole picture.
  void develop() {
    radiance_ = {bands_[0].data(), bands_[1].data(), bands_[2].data()};
    picture_.gain = exposure_gain(camera_.sensor(), request_.effects, root_luminance_,
                                  bands_[0].size() * static_cast<std::size_t>(parts_));
    if (request_.rgb == nullptr) picture_.rgb.resize(3 * bands_[0].size());
    std::uint8_t* const rgb = request_.rgb == nullptr ? picture_.rgb.data() : request_.rgb;
    if (request_.keep_radiance) picture_.radiance.resize(3 * bands_[0].size());
    const camera::Development development = development_of(camera_, request_, scene_.seed(), picture_.gain);
    constexpr int kRows = 16;
    for_rows((view_.height + kRows - 1) / kRows, threads_, [&](int band, int) {
      const int first = band * kRows, last = std::min(view_.height, first + kRows);
      draw_particles(particles_, picture_.depth_m, view_, first, last, radiance_);
      for (int row = first; row < last; ++row) {
        kernels_.develop_row(view_, development, radiance_, row, rgb);
        if (request_.keep_radiance) keep_radiance(row);
      }
    });
  }

  void keep_radiance(int row) {
    const auto first = static_cast<std::size_t>(row) * static_cast<std::size_t>(view_.width);
    for (std::size_t at = first; at < first + static_cast<std::size_t>(view_.width); ++at) {
      for (std::size_t band = 0; band < 3; ++band) picture_.radiance[3 * at + band] = bands_[band][at];
    }
  }

  const CameraScene& scene_;
  const Camera& camera_;
  const Optics& optics_;
  const PictureRequest& request_;
  int threads_;
  int parts_ = 1;          // of the exposure
  bool is_middle_ = true;  // of these
  PreparedView prepared_;
  camera::View& view_;
  Tracer tracer_;
  const camera::Kernels& kernels_;
  std::vector<std::uint8_t> classes_;
  std::vector<float> thin_from_m_;                        // by label: where it is seen in parts of pixels
  std::optional<ThinSolidsAround> thin_around_;           // seen from the camera
  std::array<camera::View, kPixelParts.size()> shifted_;  // through these parts
  const bool keeps_geometry_;                             // without it, no particles can be drawn
  Picture picture_;
  std::array<ImageBuffer<float>, 3> bands_, exposed_;
  camera::RadiancePlanes radiance_{};
  ShaftImage shafts_;
  std::optional<LampGlow> glow_;
  std::vector<Particle> particles_;
  // One per part of a row of blocks, so that their sum does not depend on the number of threads
  std::vector<double> root_luminance_;
};

}  // namespace

Picture render(const CameraScene& scene, const Camera& camera, const Optics& optics, const PictureRequest& request) {
  optics.check();
  const Pose& pose = request.world_from_camera;
  const Eigen::Vector3d& eye = pose.position_m;
  const std::string path = "camera '" + camera.name() + "' position_m";
  require(eye.allFinite() && pose.orientation.coeffs().allFinite(), path, eye.transpose(), "must be finite");
  require(eye.cwiseAbs().maxCoeff() <= kWorldEnd_m, path, eye.transpose(), "must be within 1000 km of the origin");
  if (const auto& terrain = scene.world().terrain()) {
    require(!(eye.z() < terrain->height_at(eye.x(), eye.y())), path, eye.transpose(), "must be above the ground");
  }
  require(request.record == nullptr || request.threads == 1, "threads", request.threads, "must be 1 to record rays");
  return Rendering(scene, camera, optics, request).render();
}

void render_colours(std::span<PictureJob> jobs, int threads, std::span<std::uint8_t> rgb) {
  if (jobs.empty()) return;
  const std::size_t bytes = rgb.size() / jobs.size();
  std::vector<std::exception_ptr> errors(jobs.size());
  parallel_batches(jobs.size(), 1, threads, [&](std::size_t k, std::size_t, std::size_t) {
    PictureJob& job = jobs[k];
    const std::span<std::uint8_t> own = rgb.subspan(k * bytes, bytes);
    if (job.scene == nullptr) return std::fill(own.begin(), own.end(), std::uint8_t{0});
    const std::string name = "batch[" + std::to_string(k) + "]";
    try {
      const Lens& lens = job.camera->lens();
      const std::size_t pixels = static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height);
      require(3 * pixels == bytes, "camera '" + job.camera->name() + "'", "of another size",
              "must be as large as the first");
      job.request.colours_only = true;
      job.request.rgb = own.data();
      render(*job.scene, *job.camera, *job.optics, job.request);
    } catch (const InvalidValue& error) {
      errors[k] = std::make_exception_ptr(InvalidValue(name + ": " + error.what()));
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace uwsim
