#pragma once

#include <Eigen/Core>
#include <complex>

namespace ertbench {

/// Cross product of two vectors in the plane: the area of their parallelogram, positive if `b` lies
/// to the left of `a`.
inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}
inline double cross(std::complex<double> a, std::complex<double> b) {
  return a.real() * b.imag() - a.imag() * b.real();
}

}  // namespace ertbench
