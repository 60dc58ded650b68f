#include "uwsim/rays/surface_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "uwsim/core/check.h"
#include "uwsim/core/parallel.h"

namespace uwsim {
namespace {

constexpr int kKeyBits = 21;
constexpr std::int64_t kKeyOffset = 1 << (kKeyBits - 1);
constexpr std::size_t kFirstSlots = 1 << 12;
constexpr std::size_t kVoxelsTogether = 4096;

}  // namespace

SurfaceVoxels::SurfaceVoxels(RayScene scene, double resolution_m)
    : scene_(std::move(scene)), resolution_m_(resolution_m), table_(kFirstSlots) {}

std::size_t SurfaceVoxels::known() const {
  const std::scoped_lock lock(mutex_);
  return count_;
}

void SurfaceVoxels::look_at(std::span<const float> points_world_m) {
  const std::scoped_lock lock(mutex_);
  std::vector<PackedKey> fresh;
  for (std::size_t k = 0; k + 2 < points_world_m.size(); k += 3) {
    PackedKey voxel = 0;
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cell = std::floor(double{points_world_m[k + axis]} / resolution_m_) + double{kKeyOffset};
      inside = inside && cell >= 0 && cell < 2.0 * kKeyOffset;  // false for NaN as well
      voxel = voxel << kKeyBits | (inside ? static_cast<PackedKey>(cell) : 0);
    }
    if (inside && add(voxel)) fresh.push_back(voxel);
  }
  look_at(fresh, 1);
}

void SurfaceVoxels::distances(std::span<const PackedKey> voxels, std::span<double> distances_m, int threads) {
  const std::scoped_lock lock(mutex_);
  std::vector<PackedKey> fresh;
  for (const PackedKey voxel : voxels) {
    require(voxel >= 0, "voxels", voxel, "must be packed keys");
    if (add(voxel)) fresh.push_back(voxel);
  }
  look_at(fresh, threads);
  for (std::size_t k = 0; k < voxels.size(); ++k) distances_m[k] = table_[slot_of(voxels[k])].distance_m;
}

/// Examines newly added voxels.
void SurfaceVoxels::look_at(std::span<const PackedKey> fresh, int threads) {
  parallel_batches(fresh.size(), kVoxelsTogether, threads, [&](std::size_t first, std::size_t last, std::size_t) {
    std::vector<Eigen::Vector3d> centres_m(last - first);
    std::vector<double> distances_m(last - first);
    for (std::size_t k = first; k < last; ++k) centres_m[k - first] = centre_m(fresh[k]);
    scene_.distance(centres_m, distances_m);
    for (std::size_t k = first; k < last; ++k) table_[slot_of(fresh[k])].distance_m = distances_m[k - first];
  });
}

void SurfaceVoxels::hold_surface(std::span<const PackedKey> voxels, std::span<const double> distances_m,
                                 std::span<std::uint8_t> hold, int threads) const {
  parallel_batches(voxels.size(), 64, threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t k = first; k < last; ++k) {
      hold[k] = holds_surface(centre_m(voxels[k]), resolution_m_ / 2, distances_m[k], 0);
    }
  });
}

bool SurfaceVoxels::holds_surface(const Eigen::Vector3d& centre_m, double half_m, double distance_m,
                                  int halvings) const {
  if (distance_m <= half_m + kTouch_m) return true;
  if (halvings == kHalvings || distance_m > std::sqrt(3.0) * half_m + kTouch_m) return false;
  std::array<Eigen::Vector3d, 8> parts_m;
  std::array<double, 8> distances_m;
  std::array<unsigned, 8> nearest_first;
  for (unsigned k = 0; k < 8; ++k) {
    const Eigen::Vector3d corner(k & 4 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 1 ? 0.5 : -0.5);
    parts_m[k] = centre_m + half_m * corner;
    nearest_first[k] = k;
  }
  scene_.distance(parts_m, distances_m);
  std::ranges::sort(nearest_first, {}, [&](unsigned k) { return distances_m[k]; });
  return std::ranges::any_of(
      nearest_first, [&](unsigned k) { return holds_surface(parts_m[k], half_m / 2, distances_m[k], halvings + 1); });
}

Eigen::Vector3d SurfaceVoxels::centre_m(PackedKey voxel) const {
  const auto along = [&](int axis) {
    const std::int64_t key = (voxel >> (kKeyBits * (2 - axis)) & (2 * kKeyOffset - 1)) - kKeyOffset;
    return (static_cast<double>(key) + 0.5) * resolution_m_;
  };
  return {along(0), along(1), along(2)};
}

/// The slot in the table that contains a voxel, or where it can be inserted.
std::size_t SurfaceVoxels::slot_of(PackedKey voxel) const {
  const std::size_t mask = table_.size() - 1;
  std::uint64_t mixed = static_cast<std::uint64_t>(voxel) * 0x9e3779b97f4a7c15u;  // Fibonacci hashing
  mixed ^= mixed >> 32;
  std::size_t slot = mixed & mask;
  while (table_[slot].voxel != voxel && table_[slot].voxel != kFree) slot = (slot + 1) & mask;
  return slot;
}

/// Inserts a voxel; returns whether it was new.
bool SurfaceVoxels::add(PackedKey voxel) {
  Seen& seen = table_[slot_of(voxel)];
  if (seen.voxel == voxel) return false;
  seen.voxel = voxel;
  if (2 * ++count_ > table_.size()) grow();
  return true;
}

void SurfaceVoxels::grow() {
  std::vector<Seen> old(2 * table_.size());
  old.swap(table_);
  for (const Seen& seen : old) {
    if (seen.voxel != kFree) table_[slot_of(seen.voxel)] = seen;
  }
}

}  // namespace uwsim
