#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "core/temporary_folder.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Whose fitted solver a file holds.
struct SolverOwner {
  std::string type;
  Sensor sensor;
};

/// Adds the numbers of the check of frames to what a solver has just saved in `file`, and whose it
/// is (write_owner) where the solver has not said so.
///
/// - Into an HDF5 file as the dataset `/frame_check`, beside the solver's own.
/// - Any other file, or one whose `/frame_check` is its own, becomes a container: an HDF5 file with
///   the attribute `contains_solver_file`, the solver's file byte for byte in `/solver_file`, and
///   `/frame_check`. Where the solver saved nothing there is no `/solver_file`.
void add_frame_check(const std::filesystem::path& file, const SolverOwner& owner,
                     const Eigen::VectorXd& numbers);

/// A file of a fitted solver, opened to be loaded.
class CheckedFile {
 public:
  /// Throws InputError where there is no file, or it says that it is another's.
  CheckedFile(const std::filesystem::path& file, const SolverOwner& owner);

  /// What the solver itself saved, for Solver::load: the file, or a copy of what it contains.
  const std::filesystem::path& of_solver() const { return of_solver_; }
  /// None in a file from before there were any.
  const std::optional<Eigen::VectorXd>& frame_check() const { return frame_check_; }

 private:
  std::optional<TemporaryFolder> unpacked_;
  std::filesystem::path of_solver_;
  std::optional<Eigen::VectorXd> frame_check_;
};

}  // namespace ertbench
