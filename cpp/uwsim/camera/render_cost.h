#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace uwsim {

/// The parts of rendering that are timed separately.
enum RenderTask {
  kPrepare,
  kPrimaryRays,
  kSunShadows,
  kLampShadows,
  kShaftRays,
  kGeometry,
  kWater,
  kSurfaces,
  kLampLight,
  kParticles,
  kDevelopment
};

inline constexpr std::array<const char*, 11> kRenderTaskNames = {"ripples and waves",
                                                                 "primary and onward rays",
                                                                 "sun's shadow rays",
                                                                 "lamps' shadow rays",
                                                                 "shafts' rays",
                                                                 "exact depth, output",
                                                                 "water",
                                                                 "surfaces",
                                                                 "light of lamps",
                                                                 "particles",
                                                                 "development"};

/// The number of rays cast for a picture and, if measured, the seconds spent on each task, summed over threads.
struct RenderCost {
  std::uint64_t primary_rays = 0, onward_rays = 0, sun_rays = 0, lamp_rays = 0, shaft_rays = 0;
  std::array<double, kRenderTaskNames.size()> seconds{};  ///< by RenderTask

  void add(const RenderCost& other);
};

/// Adds the time since the last call to a task. Does nothing unless measuring is on.
class TaskTimer {
 public:
  TaskTimer(bool measures, RenderCost& cost) : measures_(measures), cost_(cost) {
    if (measures_) last_ = Clock::now();
  }
  void add(RenderTask task) {
    if (!measures_) return;
    const Clock::time_point now = Clock::now();
    cost_.seconds[task] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  bool measures_;
  RenderCost& cost_;
  Clock::time_point last_;
};

}  // namespace uwsim
