#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace uwsim {

/// Groups of bodies that are linked by pairs, directly or through others. A group is identified by its lowest index.
class BodyGroups {
 public:
  void reserve(std::size_t bodies) { parents_.reserve(bodies); }
  /// Puts each body in a group of its own.
  void separate(std::size_t bodies) {
    parents_.resize(bodies);
    std::iota(parents_.begin(), parents_.end(), 0);
  }
  void join(std::size_t a, std::size_t b) {
    std::size_t low = of(a), high = of(b);
    if (low > high) std::swap(low, high);
    parents_[high] = static_cast<std::uint32_t>(low);
  }
  std::size_t of(std::size_t body) const {
    while (parents_[body] != body) body = parents_[body];
    return body;
  }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace uwsim
