#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "core/arrays.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Static condensation of the sheet onto its electrodes by nested dissection, one sheet in each
/// SIMD lane.
///
/// The sheet is bisected recursively down to 3 x 3 pixels. On the way back each block eliminates
/// the nodes that touch no other block and no electrode, and passes the Schur complement of the
/// others to its parent. The result is the resistor network between the electrodes. The cost is
/// O(grid^3); no right-hand sides and no back substitution are needed.
class Condensation {
 public:
  static constexpr int lanes = 8;

  /// `electrodes`: grid nodes `column + (columns + 1) * row`, all different.
  Condensation(int columns, int rows, const std::vector<int>& electrodes);
  ~Condensation();
  Condensation(Condensation&&) noexcept;

  /// Working memory of one thread.
  class Workspace {
   public:
    explicit Workspace(const Condensation& condensation);
    ~Workspace();

   private:
    friend class Condensation;
    struct Buffers;
    std::unique_ptr<Buffers> buffers_;
  };

  /// `ratio[lane]`: conductivity / background [pixels] of up to `lanes` sheets; null repeats the
  /// first. `impedance[lane]` [L, L]: potential at electrode i of the sheet of conductivity 1 for a
  /// unit current into electrode j and out of the last, relative to the last.
  void solve(const std::array<const double*, lanes>& ratio,
             std::array<Eigen::MatrixXd, lanes>& impedance, Workspace& workspace) const;

 private:
  struct Plan;
  std::unique_ptr<Plan> plan_;
};

/// Voltage changes from the changed pixels of a scene only.
///
/// With the stiffness K0 of the uniform sheet and its Green's function G, u = u0 + G q solves
/// K u = P for currents q at *active* nodes only: those whose neighbouring pixels differ. Inside a
/// region of one conductivity the rows of K are multiples of those of K0 and need no current; q
/// lives on the borders of the contacts, a discrete form of the border integral equation. The rows
/// of K u = P at the active nodes B are
///
///     (K_B G_B) q = P_B - K_B u0,
///
/// and the change of the voltages is dV = -I/c0 * u0_B^T q, without subtracting large numbers.
/// The cost is that of one dense LU of |B| unknowns, whatever the grid.
class ContactUpdate {
 public:
  /// `electrodes`: grid nodes `column + (columns + 1) * row` under the electrodes; `pairs`: drive
  /// and measuring pairs.
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
  /// Conductances of the edges at a node (left, right, down, up), 0 without such an edge.
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
