#pragma once

#include <string>

#include "core/hdf5_file.h"

namespace ertbench::testing {

/// EIDORS's numbers for its model `d2s`.
inline Hdf5File eidors() { return Hdf5File::open(ERTBENCH_TEST_DATA "/eidors_d2s.h5"); }
/// The continuous sheet, from the border integral equation.
inline Hdf5File border_integral() {
  return Hdf5File::open(ERTBENCH_TEST_DATA "/border_integral.h5");
}

inline double relative_difference(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                  const Eigen::Ref<const Eigen::MatrixXd>& b) {
  return (a - b).norm() / b.norm();
}

}  // namespace ertbench::testing
