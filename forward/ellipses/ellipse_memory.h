#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/arrays.h"
#include "forward/ellipses/ellipse_model.h"
#include "forward/ellipses/row_lu.h"

namespace ertbench {

/// What EllipseModel's steps hand on to each other, for the files of this model alone.
struct EllipseModel::Workspace::Memory {
  struct Border {
    Eigen::Matrix2d to_unit;  ///< of the ellipse onto the unit disc
    double shorter = 0;       ///< half axis
    int first = 0;
    int count = 0;
    double ratio = 1;
  };
  std::vector<Border> borders;
  int points = 0;
  std::vector<EllipticContact> contacts;  ///< whose points stand here
  // Of each point: place, normal and weight on the unit disc; the tangent on the sheet times the
  // parameter's step, and where it is from the contact's centre.
  std::vector<double> x, y, normal_x, normal_y, curvature, weight, depth;
  std::vector<std::complex<double>> tangent, from_centre;
  RowLu matrix;
  std::vector<double> density;    ///< [points, stride] by drives
  std::vector<double> potential;  ///< [points, stride] of the points' charges, by measuring pairs
  RowMajorMatrix slopes;          ///< [points, nodes] of unit charges at the electrodes' nodes
  RowMajorMatrix charges;         ///< [points, nodes] potentials there of the points' charges
  RowMajorMatrix by_electrode;
  std::vector<double> solution;  ///< [points, stride] of the transposed equation
  std::vector<double> along;     ///< [points, stride] slope of the potential along the border
  std::vector<double> gains;     ///< [strains, points] of a border, see EllipseModel::derivatives
  std::vector<double> products;  ///< [strains, stride, stride]
  Eigen::MatrixXd impedance;

  void resize(int count, int stride) {
    points = count;
    matrix.resize(count);
    const auto n = static_cast<std::size_t>(count);
    if (x.size() < n) {
      for (auto* array : {&x, &y, &normal_x, &normal_y, &curvature, &weight, &depth}) {
        array->resize(n);
      }
      tangent.resize(n);
      from_centre.resize(n);
      const std::size_t wide = n * static_cast<std::size_t>(stride);
      for (auto* array : {&density, &potential, &solution, &along}) array->resize(wide);
    }
  }
};

}  // namespace ertbench
