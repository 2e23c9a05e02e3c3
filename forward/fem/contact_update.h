#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/arrays.h"
#include "forward/fem/lattice_green.h"
#include "forward/sheet/electrode_pairs.h"

namespace ertbench {

/// Voltage changes from what a scene changes, and nothing else.
///
/// With K0 the stiffness of the uniform sheet and G its Green's function, u = u0 + G q solves
/// K u = P for currents q that sit only on *active* nodes: those whose neighbouring pixels differ.
/// Inside a region of one conductivity the rows of K are multiples of those of K0, so no current
/// is needed there; q lives on the borders of the contacts, the discrete form of the border
/// integral equation. The rows of K u = P at the active nodes B are
///
///     (K_B G_B) q = P_B - K_B u0,
///
/// and the change of the voltages is dV = -I/c0 * u0_B^T q, without subtracting large numbers.
/// The cost is that of one dense LU of |B| unknowns, whatever the grid.
class ContactUpdate {
 public:
  /// `electrodes`: grid nodes `column + (columns + 1) * row` under the electrodes; `pairs` those by
  /// which they are driven and measured.
  ContactUpdate(int columns, int rows, std::vector<int> electrodes,
                std::vector<ElectrodePair> pairs);

  /// Potentials [nodes, pairs] of the uniform sheet of conductivity 1 under unit currents, out at
  /// a pair's first electrode and in at its second.
  const RowMajorMatrix& background_fields() const { return fields_; }

  /// The active nodes of a sheet of `ratio` [pixels], conductivity / background.
  std::vector<int> active_nodes(const double* ratio) const;

  /// P^T (K^+ - K0^+) P, [pairs, pairs], for conductivity `ratio` with its active nodes.
  /// Every node being active makes the system singular; callers keep |active| below the node count.
  Eigen::MatrixXd impedance_change(const double* ratio, const std::vector<int>& active) const;

 private:
  /// The conductances of the four edges at a node, 0 where there is none: left, right, down, up.
  Eigen::Array4d edges(const double* ratio, int node) const;

  int columns_;
  int rows_;
  std::vector<int> electrodes_;
  std::vector<ElectrodePair> pairs_;
  std::vector<char> is_electrode_;  ///< by node
  LatticeGreen green_;
  RowMajorMatrix fields_;
};

}  // namespace ertbench
