#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace ertbench {

/// Finite elements for the tank of KTC2023: a disc of radius 115 mm with 32 electrodes on half of
/// its border, counterclockwise, the first centre on top, which fits the truths of the training
/// targets. Complete electrode model, linear triangles between rings of nodes that lie closer
/// towards the ends of the electrodes.
class TankModel {
 public:
  static constexpr int electrodes = 32;
  static constexpr double radius = 0.115;  ///< m

  /// `refinement` times as many nodes along and across; the default is meant for reconstruction.
  explicit TankModel(int refinement = 1);

  const Eigen::Matrix2Xd& nodes() const { return nodes_; }  ///< m
  /// Nodes of each triangle, counterclockwise.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

  /// A third of the area of each node's triangles.
  Eigen::VectorXd node_areas() const;

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
  /// d packed / d conductivity of a triangle, [528], in single precision.
  Eigen::VectorXf sensitivity(const Solution& solution, std::size_t triangle) const;
  /// d packed / d log contact_impedance, [528, 32].
  Eigen::MatrixXd impedance_sensitivity(const Solution& solution,
                                        const Eigen::VectorXd& contact_impedance) const;

  /// Values at the nodes on an image of the square around the tank [size, size], row 0 on top;
  /// 0 off the tank.
  Eigen::MatrixXd image(const Eigen::VectorXd& nodal, int size) const;

 private:
  struct Ring {
    double radius;  ///< of the tank's
    std::vector<double> angles;
    int first = 0;  ///< node
  };
  static std::vector<Ring> rings(int refinement);
  void add_triangles(const Ring& inner, const Ring& outer);
  /// Renumbers the nodes so that the stiffness matrix's factor stays sparse.
  void order_nodes();

  Eigen::Matrix2Xd nodes_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<Eigen::Matrix<double, 2, 3>> gradients_;  ///< of the triangle's three hat functions
  Eigen::VectorXd areas_;
  struct Segment {
    int electrode;
    std::array<int, 2> ends;  ///< nodes
    double length;
  };
  std::vector<Segment> segments_;  ///< of the border, below electrodes
};

}  // namespace ertbench
