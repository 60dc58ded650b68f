#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "uwsim/camera/kernels/block.h"

namespace uwsim::camera {

inline Eigen::Vector3f lane(const BlockVectors& all, std::size_t k) { return {all.x.at[k], all.y.at[k], all.z.at[k]}; }
inline void set_lane(const Eigen::Vector3f& value, std::size_t k, BlockVectors& all) {
  all.x.at[k] = value.x(), all.y.at[k] = value.y(), all.z.at[k] = value.z();
}

}  // namespace uwsim::camera
