#pragma once

#include <Eigen/Core>
#include <string>

#include "solvers/reciprocity.h"
#include "solvers/solver.h"

namespace ertbench {

class Hdf5File;

/// A solver whose image is a fixed matrix times the frame. By reciprocity the matrix has equal
/// columns for the two channels of a pair, so it is kept once a pair, [pixels, channels / 2], and
/// multiplies the pairs' sums: half the memory to stream, with nothing lost.
///
/// One frame is one matrix-vector product and allocates nothing; a batch is one matrix-matrix
/// product. The two round differently (relative 1e-14). A frame whose image overflows or is not
/// finite is reported as undefined.
class LinearSolver : public Solver {
 public:
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const final;

 protected:
  void set_sensor(const Sensor& sensor);
  /// `inverse` [pixels, pairs] maps d' (see Reciprocity) to the image.
  void set_inverse(const Eigen::MatrixXd& inverse);

  const Sensor& sensor() const { return sensor_; }
  const Reciprocity& reciprocity() const { return reciprocity_; }

  void save_matrix(Hdf5File& file) const;
  void load_matrix(const Hdf5File& file, const Sensor& sensor);

 private:
  Sensor sensor_;
  Reciprocity reciprocity_;
  Eigen::MatrixXd matrix_;  ///< [pixels, pairs], acts on d_a + d_b
};

}  // namespace ertbench
