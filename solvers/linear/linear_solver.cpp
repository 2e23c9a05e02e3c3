#include "solvers/linear/linear_solver.h"

#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "forward/data/sheet_model.h"
#include "solvers/solver_file.h"

namespace ertbench {

std::vector<ParameterInfo> LinearInference::registered() {
  return {{"inference_precision",
           "of the product for a frame, \"float64\" (the default) or \"float32\"",
           ParameterRole::inference},
          {"inference_averaging",
           "add the two channels of a reciprocal pair first, which halves the matrix and is exact; "
           "default true",
           ParameterRole::inference}};
}

LinearInference LinearInference::from_json(JsonObject& object) {
  LinearInference out;
  out.single_precision =
      object.choice_or("inference_precision", "float64", {"float64", "float32"}) == "float32";
  out.averaging = object.boolean_or("inference_averaging", out.averaging);
  return out;
}

void LinearInference::add_to(nlohmann::json& parameters) const {
  parameters["inference_precision"] = single_precision ? "float32" : "float64";
  parameters["inference_averaging"] = averaging;
}

namespace {

// Largest buffers of one frame on the stack.
constexpr Eigen::Index stack_inputs = 256;
constexpr Eigen::Index stack_pixels = 1024;

template <typename Scalar, Eigen::Index most>
using StackVector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1, 0, most, 1>;
template <typename Scalar>
using Rows = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Applies the map to one frame; double precision writes straight into the image.
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

/// Copies the column of each pair to the columns of both its channels.
Eigen::MatrixXd for_all_channels(const Eigen::MatrixXd& columns, const Reciprocity& reciprocity) {
  Eigen::MatrixXd out(columns.rows(), reciprocity.channels());
  for (Eigen::Index p = 0; p < columns.cols(); ++p) {
    const double over_sum = std::numbers::sqrt2 / reciprocity.of_mean(p);
    for (const int channel : reciprocity.pair(p)) out.col(channel) = over_sum * columns.col(p);
  }
  return out;
}

}  // namespace

void LinearSolver::set_sensor(const Sensor& sensor) {
  sensor_ = sensor;
  reciprocity_ = Reciprocity(sensor);
  by_frame_.reset();
}

Eigen::MatrixXd LinearSolver::whole_jacobian() const {
  return reciprocity_.reduce_rows(uniform_jacobian(sensor_));
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

void LinearSolver::finish() {
  by_frame_ = mask_.detect || follows_noise() ? frame_inverse() : nullptr;
  // Without reciprocal pairs the map has all channels already.
  if (!inference_.averaging && !reciprocity_.single()) {
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
  Rows<Scalar> in(changes.rows(), inputs);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    gather(changes.row(f).data(), inputs, in.row(f).data());
  }
  if (map.factored()) in = (in * map.right.transpose()).eval();
  if constexpr (std::is_same_v<Scalar, double>) {
    images.noalias() = in * map.left.transpose();
  } else {
    images = Rows<Scalar>(in * map.left.transpose()).template cast<double>();
  }
}

void LinearSolver::apply_matrix(FramesView changes, ImagesView images) const {
  if (single_) {
    apply(*single_, changes, images);
  } else {
    apply(full_ ? *full_ : map_, changes, images);
  }
}

void LinearSolver::reconstruct(FramesView changes, ImagesView images,
                               std::span<FrameReport> reports) const {
  const bool each = by_frame_ && follows_noise();
  if (!each) apply_matrix(changes, images);
  for (Eigen::Index f = 0; by_frame_ && f < changes.rows(); ++f) {
    const ElectrodeSet dead = reports[static_cast<std::size_t>(f)].dead;
    if (!each && dead == 0) continue;
    const std::vector<Eigen::Index> lost = pairs_with(sensor_, dead | mask_.electrodes);
    images.row(f) = by_frame_
                        ->image(reciprocity_.reduce(changes.row(f)), lost,
                                reciprocity_.noise(changes.row(f), lost))
                        .transpose();
  }
}

LayerList pair_layers(const Reciprocity& reciprocity, const ChannelMask& mask) {
  if (mask.detect) {
    throw InputError(
        "\"channel_mask\": \"detect\" chooses a matrix for each frame and has no layers; use "
        "\"none\" or a list of electrodes");
  }
  LayerList out;
  std::vector<int> pairs;
  for (Eigen::Index p = 0; p < reciprocity.pairs(); ++p) {
    pairs.insert(pairs.end(), reciprocity.pair(p).begin(), reciprocity.pair(p).end());
  }
  out.layers.push_back({.width = static_cast<int>(reciprocity.channels())});
  out.layers.push_back({.kind = Layer::Kind::means_of_pairs,
                        .inputs = {0},
                        .value = 1,
                        .width = static_cast<int>(reciprocity.pairs()),
                        .indices = std::move(pairs)});
  return out;
}

Eigen::MatrixXd on_means(Eigen::MatrixXd matrix, const Reciprocity& reciprocity) {
  for (Eigen::Index p = 0; p < matrix.cols(); ++p) {
    matrix.col(p) *= std::numbers::sqrt2 * reciprocity.of_mean(p);
  }
  return matrix;
}

void add_dense(LayerList& list, const Eigen::MatrixXf& matrix, const Eigen::VectorXf& bias) {
  const int value = static_cast<int>(list.layers.size());
  const Rows<float> rows = matrix;
  list.layers.push_back({.kind = Layer::Kind::dense,
                         .inputs = {value - 1},
                         .value = value,
                         .width = static_cast<int>(rows.rows()),
                         .weights = {rows.data(), rows.data() + rows.size()},
                         .bias = {bias.begin(), bias.end()}});
}

std::optional<LayerList> LinearSolver::layers() const {
  if (follows_noise()) {
    throw InputError(
        "an image that follows the noise of its frame has no layers; leave it \"fit\"");
  }
  LayerList out = pair_layers(reciprocity_, mask_);
  const auto multiply = [&](const Eigen::MatrixXd& matrix) {
    add_dense(out, matrix.cast<float>(), Eigen::VectorXf::Zero(matrix.rows()));
  };
  multiply(on_means(map_.factored() ? map_.right : map_.left, reciprocity_));
  if (map_.factored()) multiply(map_.left);
  return out;
}

nlohmann::json LinearSolver::parameters() const {
  nlohmann::json out = fit_parameters();
  inference_.add_to(out);
  return out;
}

void LinearSolver::save(const std::filesystem::path& file) const {
  Hdf5File out = create_solver_file(file, type_, sensor_, fit_parameters());
  save_fit(out);
  out.close();
}

void LinearSolver::load(const std::filesystem::path& file, const Sensor& sensor) {
  const Hdf5File opened = open_solver_file(file, type_, sensor);
  read(JsonObject(parameters_of_fit(opened), file.string(), "/parameters"));
  load_fit(opened, sensor);
}

void LinearSolver::save_matrix(Hdf5File& file) const {
  file.write_matrix("/matrix", map_.left);
  if (map_.factored()) file.write_matrix("/right_factor", map_.right);
}

void LinearSolver::load_matrix(const Hdf5File& file, const Sensor& sensor) {
  const auto pixels = static_cast<std::uint64_t>(sensor.pixels());
  const auto pairs = static_cast<std::uint64_t>(Reciprocity(sensor).pairs());
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
  finish();
}

}  // namespace ertbench
