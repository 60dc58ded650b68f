#pragma once

#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

/// A faster walk for most rays of a survey, which run mostly along x or y and little along z. The main axis a is x or
/// y, whichever the ray runs along more; the middle axis b is the other of the two; the minor axis is z. A slab is the
/// part of a ray between two faces across a. In one slab, such a ray crosses at most one face across b, and in four
/// slabs, at most one across z.
///
/// The crossings are computed in fixed point, with 2^32 units per voxel and per slab. OctoMap sums t + k d in doubles,
/// with an error of less than k 2^-53 t, which is negligible here. The fixed-point numbers are off by at most one unit
/// per step, so two crossings that are more than tolerance_of(slabs) units apart come in the same order as in OctoMap.
/// Rays with two crossings closer together than that are walked in the same way as OctoMap does it (ray_walk.h).
///
/// This file selects the rays and computes their parameters; slab_walk.h walks them. Compiled into each
/// scan_kernels_slabs_*.cpp, which includes lanes_avx2.h or lanes_avx512.h before it.
namespace uwsim::bricks {
namespace {

constexpr double kUnits = 4294967296.0;
constexpr double kNever = 1e300;  // stride along an axis along which the ray does not move; longer than any ray
constexpr double kMostSlabs = 16384, kFewestSlabs = 8;
/// Maximum number of faces across z per slab, such that at most one is crossed in four slabs.
constexpr double kSteepest = 0.2499;
constexpr std::uint32_t kNoSlab = 0x40000000;

enum SlabFlag : std::uint32_t {
  kMiddleInFirstSlab = 1,  ///< a face across b is crossed in the first slab
  kMiddleInLastSlab = 2,   ///< a face across b is crossed in the last slab
  kMinorInLastSlab = 4,    ///< a face across z is crossed in the last slab
  kMiddleBeforeMinor = 8,  ///< the last face across b is crossed before the last one across z
};

/// The tolerance, in units, for numbers to which up to `slabs` steps have been added.
inline Reals tolerance_of(Reals slabs) { return slabs + slabs + all_reals(64); }
inline Lanes tolerance_of(Lanes slabs) { return plus(shift_up<1>(slabs), all_lanes(64)); }

/// Sets up as many rays as there are Reals. d, t and n are the stride, the first crossing and the number of crossings
/// along an axis.
class SlabSetup {
 public:
  SlabSetup(const SlabInput& in, std::size_t first) : in_(in), first_(first), lanes_(first_reals(in.count - first)) {
    const Reals dx = column(in.rays->stride[0]), dy = column(in.rays->stride[1]);
    const Reals tx = column(in.rays->next[0]), ty = column(in.rays->next[1]);
    const Reals nx = steps(0), ny = steps(1);
    along_y_ = is_less(dy, dx);
    da_ = select(along_y_, dy, dx);
    db_ = select(along_y_, dx, dy);
    ta_ = select(along_y_, ty, tx);
    tb_ = select(along_y_, tx, ty);
    na_ = select(along_y_, ny, nx);
    nb_ = select(along_y_, nx, ny);
    dz_ = column(in.rays->stride[2]);
    tz_ = column(in.rays->next[2]);
    nz_ = steps(2);
    tolerance_ = tolerance_of(na_);
  }

  void set_up() {
    suited_ = lanes_ & is_at_most(all_reals(kFewestSlabs), na_) & is_at_most(na_, all_reals(kMostSlabs)) &
              is_less(da_, dz_ * all_reals(kSteepest));
    if (any(suited_)) {
      check_end();
      set_up_middle();
      set_up_minor();
      put(&SlabRays::slabs, truncated(na_));
      put(&SlabRays::flags, flags_);
    }
    for (std::size_t lane = 0; lane < kReals && first_ + lane < in_.count; ++lane) {
      const unsigned along_y = is_set(along_y_, lane), down = in_.rays->negative[first_ + lane] >> along_y & 1;
      const unsigned heading = is_set(suited_, lane) ? 1 + 2 * along_y + down : 0;
      in_.slab_rays->heading[first_ + lane] = static_cast<std::uint8_t>(heading);
    }
  }

 private:
  static Reals units(Reals x) { return x * all_reals(kUnits); }
  Reals column(const double* of) const { return load(lanes_, of + first_); }
  Reals steps(int axis) const { return distances(lanes_, in_.rays->end_key[axis] + first_, in_.origin_key[axis]); }
  void put(std::uint32_t* SlabRays::*to, Naturals values) const { store(lanes_, in_.slab_rays->*to + first_, values); }

  /// Returns the fractional part of `x` [voxels or slabs], in units. Rays in `asked` for which `x` is within the
  /// tolerance of an integer are marked unsuitable.
  Reals certain_fraction(Reals x, RealMask asked) {
    const Reals fraction = units(x - floor(x)), most = all_reals(kUnits) - (tolerance_ + tolerance_);
    suited_ = suited_ & (inverse(asked) |
                         (is_at_most(all_reals(0), x) & is_less(tolerance_, fraction) & is_less(fraction, most)));
    return fraction;
  }

  /// Checks that each ray reaches the voxel of its end and ends there. In a suitable ray, the last crossings along the
  /// three axes are at or before the ray's length, the next crossings are beyond it, and the order of the last
  /// crossings is certain.
  void check_end() {
    const Reals one = all_reals(1);
    const auto last = [&](Reals t, Reals d, Reals n) {
      return select(is_at_most(one, n), t + d * (n - one), all_reals(-kNever));
    };
    const Reals a = last(ta_, da_, na_), b = last(tb_, db_, nb_), z = last(tz_, dz_, nz_);
    const Reals length = column(in_.rays->length), margin = length * all_reals(1 / kUnits);
    const Reals reached = larger(a, larger(b, z)) + margin;
    const Reals beyond = smaller(ta_ + da_ * na_, smaller(tb_ + db_ * nb_, tz_ + dz_ * nz_));
    const auto apart = [&](Reals crossing, Reals other) { return is_less(margin, magnitude(crossing - other)); };
    const RealMask late_b = is_less(a, b), late_z = is_less(a, z);
    suited_ = suited_ & is_less(reached, beyond) & is_at_most(reached, length) & apart(a, b) & apart(a, z) &
              (inverse(late_b & late_z) | apart(b, z));
    flag(late_b, kMiddleInLastSlab);
    flag(late_z, kMinorInLastSlab);
    flag(is_less(b, z), kMiddleBeforeMinor);
  }

  void flag(RealMask lanes, SlabFlag which) { flags_ = flags_ | select(lanes, all_naturals(which), all_naturals(0)); }

  /// Computes the number of faces across b that each ray crosses up to the end of the first slab and in each further
  /// slab.
  void set_up_middle() {
    const Reals one = all_reals(1), none = all_reals(0);
    const RealMask moves = is_less(db_, all_reals(kNever));
    const Reals slope = select(moves, da_ / db_, none);
    suited_ = suited_ & is_less(slope, all_reals(1 - 1.0 / 65536));
    const Reals crossed = select(moves, (ta_ - tb_) / db_ + one, all_reals(0.5));
    const Reals fraction = certain_fraction(crossed, lanes_);
    suited_ = suited_ & is_less(crossed, all_reals(2));
    flag(is_at_most(one, crossed), kMiddleInFirstSlab);
    put(&SlabRays::slope, truncated(units(slope)));
    put(&SlabRays::fraction, truncated(fraction + tolerance_));
  }

  /// Computes, for faces across z, the slab in which each ray crosses the first face, the number of slabs from one face
  /// to the next, and the ray's position along b at each face.
  void set_up_minor() {
    const Reals one = all_reals(1), two = all_reals(2), none = all_reals(0), many = all_reals(1 << 20);
    const RealMask moves = is_less(db_, all_reals(kNever)), climbs = is_less(dz_, all_reals(kNever));
    const Reals slab = select(climbs, (tz_ - ta_) / da_ + one, all_reals(2 * kMostSlabs));
    const RealMask climbing = is_less(slab, na_ + one);
    const Reals fraction = certain_fraction(slab, climbing);
    const Reals between = smaller(select(climbing, dz_ / da_, none), many), between_down = floor(between);
    const Naturals never = all_naturals(kNoSlab);
    put(&SlabRays::minor_slab, select(climbing, truncated(floor(slab)), never));
    put(&SlabRays::minor_fraction, select(climbing, truncated(fraction + tolerance_), never));
    put(&SlabRays::minor_slabs, truncated(between_down));
    put(&SlabRays::minor_slabs_fraction, truncated(units(between - between_down)));
    const RealMask both = moves & climbing;
    const Reals middle = select(both, (tz_ - tb_) / db_ + one, all_reals(0.5));
    certain_fraction(middle, climbing);
    const auto modulo_two = [&](Reals x, Reals more) {  // in units of 2^-32 of two voxels, so that it wraps around
      const Reals rest = x - two * floor(x / two);
      return truncated(rest * all_reals(kUnits / 2) + more);
    };
    const Reals origin_b = select(along_y_, all_reals(in_.origin_key[0] & 1), all_reals(in_.origin_key[1] & 1));
    const Reals clipped = smaller(larger(middle, none), all_reals(4 * kMostSlabs));
    put(&SlabRays::minor_middle, modulo_two(clipped + origin_b, tolerance_));
    put(&SlabRays::minor_middles, modulo_two(smaller(select(both, dz_ / db_, none), many), none));
  }

  const SlabInput& in_;
  const std::size_t first_;
  const RealMask lanes_;
  RealMask along_y_, suited_;
  Reals ta_, tb_, tz_, da_, db_, dz_, na_, nb_, nz_, tolerance_;
  Naturals flags_ = all_naturals(0);
};

inline void set_up_slabs(const SlabInput& in) {
  for (std::size_t i = 0; i < in.count; i += kReals) SlabSetup(in, i).set_up();
}

}  // namespace
}  // namespace uwsim::bricks
