#pragma once

#include "uwsim/camera/kernels/block.h"
#include "uwsim/core/float_lane_functions.h"

/// Transfer of a block's values between memory and lanes. Included only by the kernels.
namespace uwsim::camera {
namespace {

using uwsim::load, uwsim::store;

UWSIM_LANES Vector load(const BlockVectors& from) { return {load(from.x.at), load(from.y.at), load(from.z.at)}; }
UWSIM_LANES void store(BlockVectors& to, Vector v) {
  store(to.x.at, v.x);
  store(to.y.at, v.y);
  store(to.z.at, v.z);
}
UWSIM_LANES Vector zero() { return {Float{}, Float{}, Float{}}; }
UWSIM_LANES Vector ones() { return {splat(1), splat(1), splat(1)}; }

UWSIM_LANES Double to_double(Float x) { return widened<double>(x); }
UWSIM_LANES Float to_single(Double x) { return narrowed<float>(x); }

UWSIM_LANES Float gather(const float* from, Int index) {
  Float value;
  for (int k = 0; k < kLanes; ++k) value[k] = from[index[k]];
  return value;
}

}  // namespace
}  // namespace uwsim::camera
