#include "solvers/linear/linear_solver.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <stdexcept>

#include "core/hdf5_file.h"
#include "forward/fem/forward_model.h"
#include "solvers/check/frame_check_file.h"
#include "solvers/check_shapes.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

// What one frame keeps on the stack.
constexpr Eigen::Index stack_inputs = 256;
constexpr Eigen::Index stack_pixels = 1024;
/// Frames multiplied at a time: their images stay in the second-level cache.
constexpr Eigen::Index block_frames = 256;

template <typename Scalar, Eigen::Index most>
using StackVector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1, 0, most, 1>;
template <typename Scalar>
using Rows = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One frame; in double precision straight into the image.
template <typename Scalar>
void multiply(const ImageMap<Scalar>& map, const StackVector<Scalar, stack_inputs>& in,
              Eigen::Ref<Eigen::RowVectorXd> image) {
  StackVector<Scalar, stack_inputs> inner;
  if (map.factored()) inner.noalias() = map.right * in;
  const StackVector<Scalar, stack_inputs>& last = map.factored() ? inner : in;
  if constexpr (std::is_same_v<Scalar, double>) {
    image.transpose().noalias() = map.left * last;
  } else {
    StackVector<Scalar, stack_pixels> out;
    out.noalias() = map.left * last;
    image = out.transpose().template cast<double>();
  }
}

/// Columns of pairs -> columns of both their channels.
Eigen::MatrixXd for_all_channels(const Eigen::MatrixXd& columns, const Reciprocity& reciprocity) {
  Eigen::MatrixXd out(columns.rows(), 2 * columns.cols());
  for (Eigen::Index p = 0; p < columns.cols(); ++p) {
    for (const int channel : reciprocity.pair(p)) out.col(channel) = columns.col(p);
  }
  return out;
}

}  // namespace

void LinearSolver::set_sensor(const Sensor& sensor) {
  sensor_ = sensor;
  reciprocity_ = Reciprocity(sensor);
  check_ = {};
  masked_.reset();
}

Eigen::MatrixXd LinearSolver::whole_jacobian() const {
  return reciprocity_.reduce_rows(ForwardModel(sensor_, sensor_.image_grid).jacobian());
}

void LinearSolver::set_inverse(const Eigen::MatrixXd& inverse) {
  map_ = {columns_for_all_pairs(inverse, kept_pairs(), reciprocity_.pairs()) / std::numbers::sqrt2,
          {}};
  full_.reset();
  single_.reset();
}

void LinearSolver::set_inverse(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
  map_ = smaller_map(
      left, columns_for_all_pairs(right, kept_pairs(), reciprocity_.pairs()) / std::numbers::sqrt2);
  full_.reset();
  single_.reset();
}

void LinearSolver::finish(const FitInput& input) {
  check_ = FrameCheck(input, mask_.electrodes);
  prepare();
}

void LinearSolver::prepare() {
  masked_ = mask_.detect ? masked_inverse() : nullptr;
  if (!inference_.averaging) {
    full_ = map_.factored()
                ? ImageMap<double>{map_.left, for_all_channels(map_.right, reciprocity_)}
                : ImageMap<double>{for_all_channels(map_.left, reciprocity_), {}};
  }
  if (inference_.single_precision) single_ = (full_ ? *full_ : map_).cast<float>();
}

template <typename Scalar>
void LinearSolver::gather(const double* frame, Eigen::Index inputs, Scalar* out) const {
  if (inputs == reciprocity_.pairs()) {
    reciprocity_.sum(frame, out);
  } else {
    for (Eigen::Index i = 0; i < inputs; ++i) out[i] = static_cast<Scalar>(frame[i]);
  }
}

template <typename Scalar>
void LinearSolver::apply(const ImageMap<Scalar>& map, FramesView changes, ImagesView images) const {
  const Eigen::Index inputs = map.inputs();
  if (changes.rows() == 1 && inputs <= stack_inputs && map.pixels() <= stack_pixels) {
    StackVector<Scalar, stack_inputs> in(inputs);
    gather(changes.row(0).data(), inputs, in.data());
    multiply<Scalar>(map, in, images.row(0));
    return;
  }
  for (Eigen::Index first = 0; first < changes.rows(); first += block_frames) {
    const Eigen::Index count = std::min(block_frames, changes.rows() - first);
    Rows<Scalar> in(count, inputs);
    for (Eigen::Index f = 0; f < count; ++f) {
      gather(changes.row(first + f).data(), inputs, in.row(f).data());
    }
    if (map.factored()) in = (in * map.right.transpose()).eval();
    if constexpr (std::is_same_v<Scalar, double>) {
      images.middleRows(first, count).noalias() = in * map.left.transpose();
    } else {
      images.middleRows(first, count) =
          Rows<Scalar>(in * map.left.transpose()).template cast<double>();
    }
  }
}

void LinearSolver::reconstruct(FramesView changes, ImagesView images,
                               std::span<FrameReport> reports) const {
  check_shapes(sensor_, map_.left.size() > 0, changes, images, reports);
  if (single_) {
    apply(*single_, changes, images);
  } else {
    apply(full_ ? *full_ : map_, changes, images);
  }
  for (Eigen::Index f = 0; f < images.rows(); ++f) {
    if (!images.row(f).allFinite()) {
      reports[static_cast<std::size_t>(f)].status = FrameStatus::undefined;
    }
  }
  if (inference_.check || masked_) judge(changes, images, reports);
}

void LinearSolver::judge(FramesView changes, ImagesView images,
                         std::span<FrameReport> reports) const {
  std::map<ElectrodeSet, Eigen::MatrixXd> weights;  // of each set of dead electrodes met
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    FrameReport& report = reports[static_cast<std::size_t>(f)];
    if (report.status == FrameStatus::undefined) continue;
    const FrameCheck::Verdict verdict = check_.judge(changes.row(f).data());
    const bool masked = masked_ && verdict.dead != 0;
    if (masked) {
      const auto [found, is_new] = weights.try_emplace(verdict.dead);
      if (is_new) found->second = masked_->weights(pairs_without(sensor_, verdict.dead));
      const Eigen::VectorXd weighted = found->second * reciprocity_.reduce(changes.row(f));
      images.row(f).transpose().noalias() = masked_->basis() * weighted;
    }
    if (inference_.check) FrameCheck::report(verdict, masked, report);
  }
}

void LinearSolver::save_matrix(Hdf5File& file) const {
  if (map_.left.size() == 0) throw std::logic_error("a solver was saved before it was fitted");
  file.write_matrix("/matrix", map_.left);
  if (map_.factored()) file.write_matrix("/right_factor", map_.right);
  file.write_vector("/frame_check", check_.packed());
}

void LinearSolver::load_matrix(const Hdf5File& file, const Sensor& sensor) {
  const auto pixels = static_cast<std::uint64_t>(sensor.pixels());
  const auto pairs = static_cast<std::uint64_t>(sensor.channels()) / 2;
  std::uint64_t columns = pairs;
  Eigen::MatrixXd right;
  if (file.has("/right_factor")) {
    columns = file.shape("/right_factor").front();
    file.require_shape("/right_factor", {columns, pairs});
    right = file.read_rows("/right_factor", 0, columns);
  }
  file.require_shape("/matrix", {pixels, columns});
  set_sensor(sensor);
  map_ = {file.read_rows("/matrix", 0, pixels), std::move(right)};
  full_.reset();
  single_.reset();
  check_ = load_frame_check(file, sensor, mask_.electrodes);
  prepare();
}

}  // namespace ertbench
