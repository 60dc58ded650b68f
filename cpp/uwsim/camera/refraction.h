#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

namespace uwsim {

/// The refractive index of sea and fresh water for visible light, within 1 % (Quan and Fry 1995, Appl. Opt. 34:3477).
inline constexpr double kWaterIndex = 1.333;

/// Snell's law: the direction of a ray along unit `direction` after crossing a surface with unit `normal` (towards the
/// side that the ray comes from), from refractive index n_from into n_to. Returns nullopt for total reflection.
inline std::optional<Eigen::Vector3d> refracted(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                                                double n_from, double n_to) {
  const double ratio = n_from / n_to, cosine = -direction.dot(normal);
  const double sine2 = ratio * ratio * (1 - cosine * cosine);
  if (sine2 >= 1) return std::nullopt;
  return ratio * direction + (ratio * cosine - std::sqrt(1 - sine2)) * normal;
}

/// Fresnel reflectance of unpolarised light, by the cosine of the angle of incidence; 1 beyond the critical angle
/// (Hecht, "Optics", ch. 4).
inline double fresnel_reflectance(double cosine, double n_from, double n_to) {
  const double sine2 = (n_from / n_to) * (n_from / n_to) * (1 - cosine * cosine);
  if (sine2 >= 1) return 1;
  const double beyond = std::sqrt(1 - sine2);
  const double s = (n_from * cosine - n_to * beyond) / (n_from * cosine + n_to * beyond);
  const double p = (n_from * beyond - n_to * cosine) / (n_from * beyond + n_to * cosine);
  return 0.5 * (s * s + p * p);
}

}  // namespace uwsim
