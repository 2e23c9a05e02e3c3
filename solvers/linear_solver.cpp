#include "solvers/linear_solver.h"

#include <numbers>
#include <stdexcept>

#include "forward/hdf5_file.h"
#include "solvers/check_shapes.h"

namespace ertbench {
namespace {

constexpr Eigen::Index stack_pairs = 128;  ///< pair sums that one frame keeps on the stack

}  // namespace

void LinearSolver::set_sensor(const Sensor& sensor) {
  sensor_ = sensor;
  reciprocity_ = Reciprocity(sensor);
}

void LinearSolver::set_inverse(const Eigen::MatrixXd& inverse) {
  matrix_ = inverse / std::numbers::sqrt2;
}

void LinearSolver::reconstruct(FramesView changes, ImagesView images,
                               std::span<FrameReport> reports) const {
  check_shapes(sensor_, matrix_.size() > 0, changes, images, reports);
  const Eigen::Index pairs = reciprocity_.pairs();
  if (changes.rows() == 1 && pairs <= stack_pairs) {
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, stack_pairs, 1> sums(pairs);
    reciprocity_.sum(changes.row(0).data(), sums.data());
    images.row(0).transpose().noalias() = matrix_ * sums;
  } else {
    RowMajorMatrix sums(changes.rows(), pairs);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      reciprocity_.sum(changes.row(f).data(), sums.row(f).data());
    }
    images.noalias() = sums * matrix_.transpose();
  }
  for (Eigen::Index f = 0; f < images.rows(); ++f) {
    if (!images.row(f).allFinite()) {
      reports[static_cast<std::size_t>(f)].status = FrameStatus::undefined;
    }
  }
}

void LinearSolver::save_matrix(Hdf5File& file) const {
  if (matrix_.size() == 0) throw std::logic_error("a solver was saved before it was fitted");
  file.write_matrix("/matrix", matrix_);
}

void LinearSolver::load_matrix(const Hdf5File& file, const Sensor& sensor) {
  const auto pixels = static_cast<std::uint64_t>(sensor.pixels());
  const auto pairs = static_cast<std::uint64_t>(sensor.channels()) / 2;
  file.require_shape("/matrix", {pixels, pairs});
  set_sensor(sensor);
  matrix_ = file.read_rows("/matrix", 0, pixels);
}

}  // namespace ertbench
