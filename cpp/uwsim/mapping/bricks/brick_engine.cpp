#include "uwsim/mapping/bricks/brick_engine.h"

#include "uwsim/mapping/bricks/brick_octree.h"
#include "uwsim/mapping/bricks/cube_adder.h"
#include "uwsim/mapping/bricks/scan_inserter.h"
#include "uwsim/mapping/morton.h"
#include "uwsim/mapping/octomap_engine.h"

namespace uwsim {
namespace {

/// The largest map that is written by OctoMap, whose tree takes about 90 bytes per node while it is being written.
constexpr std::uint64_t kMostOctomapNodes = 30'000'000;

class BrickEngine : public MapEngine {
 public:
  BrickEngine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m, const OccupancyModel& model,
              InstructionSet instruction_set)
      : resolution_m_(resolution_m),
        tree_origin_world_m_(tree_origin_world_m),
        model_(model),
        store_(model.in_log_odds()),
        inserter_(store_, kernels_for(instruction_set)) {}

  void insert(std::span<const Scan> scans, double max_range_m, int threads) override {
    const auto scan = [&](std::size_t i) {
      bricks::ScanInput input{
          scans[i].points_world_m.data(), scans[i].points_world_m.size() / 3, {}, {}, max_range_m, resolution_m_};
      for (int axis = 0; axis < 3; ++axis) {
        input.tree_origin_world_m[axis] = tree_origin_world_m_[axis];
        input.origin_m[axis] = scans[i].origin_m[axis];
      }
      return input;
    };
    inserter_.insert(scans.size(), scan, threads);
  }

  void add(const VoxelKey& corner, int levels, float log_odds) override {
    if (!adder_) adder_.emplace(store_);
    store_.changed().add(corner, levels);
    adder_->add(morton::code(corner), levels, log_odds);
  }
  void finish_adding() override { adder_.reset(); }

  void set_model(const OccupancyModel& model) override {
    model_ = model;
    store_.set_model(model.in_log_odds());
  }

  ChangedChunks take_changed() override { return store_.take_changed(); }

  ChangedChunks occupied_chunks() const override {
    ChangedChunks chunks;
    for (const auto& leaf : store_.large_leaves()) {
      if (is_occupied(leaf.log_odds)) chunks.add(morton::key(std::uint64_t{leaf.code} << 18), leaf.levels);
    }
    for (const auto& [code, chunk] : store_.sorted_chunks()) chunks.codes.insert(code);
    return chunks;
  }
  void occupied_in(std::uint32_t chunk, OccupiedWords& words) const override {
    bricks::occupied_in(store_, chunk, words);
  }

  void load(MapFormat format, std::string_view body) override { load_tree(store_, format, body); }

  std::optional<float> log_odds_at(const VoxelKey& key) const override {
    const std::uint64_t code = morton::code(key);
    const bricks::BrickStore::Chunk* chunk = store_.find_chunk(static_cast<std::uint32_t>(code >> 18));
    if (!chunk) {
      const auto* leaf = store_.large_leaf_over(static_cast<std::uint32_t>(code >> 18));
      return leaf ? std::optional(leaf->log_odds) : std::nullopt;
    }
    const std::uint32_t slot = chunk->bricks[code >> 9 & 511];
    if (slot == bricks::kNone) return std::nullopt;
    if (slot >= bricks::BrickStore::kUniform) return store_.uniform(slot);
    const bricks::Brick& brick = store_.brick(slot);
    const bool known = brick.known[code >> 6 & 7] >> (code & 63) & 1;
    return known ? std::optional(log_odds_of(store_, brick, static_cast<int>(code & 511))) : std::nullopt;
  }

  VoxelCounts count() const override {
    const std::optional<VoxelCounts> counted = bricks::count_voxels(store_);
    return counted ? *counted : MapEngine::count();
  }
  void for_each_leaf(const LeafVisitor& leaf) const override { bricks::for_each_leaf(store_, leaf); }
  void for_each_leaf_in(const KeyBox& box, const LeafVisitor& leaf) const override {
    bricks::for_each_leaf_in(store_, box, leaf);
  }
  TreeBytes full_tree() const override { return bricks::full_tree(store_); }
  TreeBytes binary_tree() const override {
    TreeBytes tree = bricks::binary_tree(store_);
    return tree.nodes <= kMostOctomapNodes ? written_by_octomap(tree, resolution_m_, model_) : std::move(tree);
  }
  std::uint64_t nodes() const override { return count_nodes(store_); }
  std::size_t memory_bytes() const override { return store_.memory_bytes(); }

 private:
  const double resolution_m_;
  const Eigen::Vector3d tree_origin_world_m_;
  OccupancyModel model_;
  bricks::BrickStore store_;
  bricks::ScanInserter inserter_;
  std::optional<bricks::CubeAdder> adder_;  ///< from the first add() to finish_adding()
};

}  // namespace

std::unique_ptr<MapEngine> make_brick_engine(double resolution_m, const Eigen::Vector3d& tree_origin_world_m,
                                             const OccupancyModel& model, InstructionSet instruction_set) {
  return std::make_unique<BrickEngine>(resolution_m, tree_origin_world_m, model, instruction_set);
}

}  // namespace uwsim
