#pragma once

#include <Eigen/Core>

namespace ertbench {

/// An optional part of a solver whose fitted file is in a format of its own and has a place for the
/// numbers of the check of frames. All others leave them to CheckedFile.
class KeepsFrameCheck {
 public:
  virtual ~KeepsFrameCheck() = default;

  /// Called after `fit`: `save` is to write these numbers, too.
  virtual void keep_frame_check(const Eigen::VectorXd& numbers) = 0;
  /// What `load` found in the file; empty where that has none.
  virtual const Eigen::VectorXd& kept_frame_check() const = 0;
};

}  // namespace ertbench
