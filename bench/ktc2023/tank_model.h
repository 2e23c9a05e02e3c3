#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace ertbench {

/// Finite elements for the tank of KTC2023: a disc of radius 115 mm with 32 electrodes on half of
/// its border, counterclockwise, the first centre at 84.375 degrees. Complete electrode model,
/// linear triangles between rings of nodes, solved ring by ring from the centre outwards.
class TankModel {
 public:
  static constexpr int electrodes = 32;
  static constexpr double radius = 0.115;  ///< m

  TankModel();

  const Eigen::Matrix2Xd& nodes() const { return nodes_; }  ///< m
  /// Nodes of each triangle, counterclockwise.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

  /// Potentials for a unit current into each electrode that leaves evenly through all.
  struct Solution {
    Eigen::MatrixXd resistance;  ///< of the electrodes, [32, 32], symmetric, ohm
    Eigen::MatrixXd potentials;  ///< [nodes, 32]
  };
  /// `conductivity` [triangles] S, `contact_impedance` [32] ohm m, both > 0.
  Solution solve(const Eigen::VectorXd& conductivity,
                 const Eigen::VectorXd& contact_impedance) const;

  /// Resistances are kept as the upper triangle, row by row: [528].
  static constexpr int pairs = electrodes * (electrodes + 1) / 2;
  static Eigen::VectorXd packed(const Eigen::MatrixXd& resistance);
  /// d packed / d conductivity, [528, triangles].
  Eigen::MatrixXd sensitivity(const Solution& solution) const;
  /// d packed / d log contact_impedance, [528, 32].
  Eigen::MatrixXd impedance_sensitivity(const Solution& solution,
                                        const Eigen::VectorXd& contact_impedance) const;

  /// Values at the nodes on an image of the square around the tank [size, size], row 0 on top;
  /// 0 off the tank.
  Eigen::MatrixXd image(const Eigen::VectorXd& nodal, int size) const;

 private:
  struct Ring {
    double radius;  ///< of the tank's
    int first;      ///< node
    int count;
  };
  static std::vector<Ring> rings();
  void add_triangles(const Ring& inner, const Ring& outer);

  std::vector<Ring> rings_;
  Eigen::Matrix2Xd nodes_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<Eigen::Matrix<double, 2, 3>> gradients_;  ///< of the triangle's three hat functions
  Eigen::VectorXd areas_;
  std::vector<std::array<int, 3>> segments_;  ///< electrode and two nodes of each border segment
  double segment_length_ = 0;
};

}  // namespace ertbench
