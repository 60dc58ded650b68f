#pragma once

#include <cstddef>
#include <cstdint>

namespace uwsim {

inline constexpr std::size_t kPressureLanes = 8;

/// Eight vertices of a hull, one array per value: their positions in the body frame, and the force and moment due to a
/// pressure of 1 Pa at each. Unused slots repeat a vertex, with zero force and moment.
struct alignas(64) VertexBlock {
  double arm_m[3][kPressureLanes];
  double per_pascal[6][kPressureLanes];
};

/// The loops over a hull's vertices, compiled for each instruction set. All versions produce the same bits.
struct PressureKernels {
  /// Computes the vertices' world positions, x y z for each. `rotation` is in row-major order.
  void (*place)(const VertexBlock* blocks, std::size_t count, const double* position_m, const double* rotation,
                double* points_m);
  /// Computes pressures in water of uniform density; 0 where the head is negative.
  void (*pressures)(const double* heads_m, std::size_t block_count, double pascal_per_m, double* pressures_pa);
  /// Writes 1 where the head is positive, else 0.
  void (*find_wet)(const double* heads_m, std::size_t block_count, std::uint8_t* wet);
  /// Computes force and moment due to the pressures: six values.
  void (*load)(const VertexBlock* blocks, std::size_t count, const double* pressures_pa, double* load);
};

const PressureKernels& baseline_pressure_kernels();
const PressureKernels& avx2_pressure_kernels();
const PressureKernels& avx512_pressure_kernels();
/// The kernels for the widest instruction set that this processor supports.
const PressureKernels& pressure_kernels();

}  // namespace uwsim
