#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

namespace ertbench {

/// Static condensation of the sheet onto its electrodes by nested dissection, several sheets at a
/// time, one in each SIMD lane.
///
/// The sheet is halved again and again down to 3 x 3 pixels. Going back up, each block eliminates
/// the nodes that no other block and no electrode touches, and hands the Schur complement of the
/// rest to its parent. What is left at the top is the resistor network between the electrodes. The
/// cost is O(grid^3); no right-hand sides and no back substitution are needed.
class Condensation {
 public:
  static constexpr int lanes = 8;

  /// `electrodes`: grid nodes `column + (columns + 1) * row`, all different.
  Condensation(int columns, int rows, const std::vector<int>& electrodes);
  ~Condensation();
  Condensation(Condensation&&) noexcept;

  /// Memory for one thread's calls.
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

  /// Multiply-adds for one sheet, in the elimination alone.
  double operations() const;

 private:
  struct Plan;
  std::unique_ptr<Plan> plan_;
};

}  // namespace ertbench
