#include "solvers/linear/mmse.h"

#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "solvers/solver_file.h"

namespace ertbench {

Eigen::MatrixXd mmse_matrix(const Eigen::MatrixXd& changes, const Eigen::MatrixXd& cross,
                            double added) {
  Eigen::MatrixXd matrix = changes;
  matrix.diagonal().array() += added;
  const Eigen::MatrixXd solved = matrix.ldlt().solve(cross.transpose());
  return solved.transpose();
}

namespace {

/// N N^T [pairs, pairs] V^2.
Eigen::MatrixXd covariance_of(const Nuisances& nuisances, const Sensor& sensor) {
  const Eigen::Index pairs = Reciprocity(sensor).pairs();
  if (!nuisances.any()) return Eigen::MatrixXd::Zero(pairs, pairs);
  const Eigen::MatrixXd columns = nuisances.columns(sensor);
  return columns * columns.transpose();
}

constexpr std::size_t most_masked = 16;  ///< sets of dead electrodes that are kept

/// Stacks two matrices.
template <typename Part>
RowMajorMatrix stacked(const GaussianMixture& mixture, Part&& part) {
  const auto& first = part(mixture.components.front());
  RowMajorMatrix out(first.rows() * static_cast<Eigen::Index>(mixture.components.size()),
                     first.cols());
  Eigen::Index row = 0;
  for (const GaussianMixture::Component& c : mixture.components) {
    out.middleRows(row, first.rows()) = part(c);
    row += first.rows();
  }
  return out;
}

}  // namespace

void MmseParameters::read(JsonObject& parameters) {
  ridge = read_weight(parameters, "ridge");
  symmetries = parameters.boolean_or("symmetries", true);
  read_chosen(parameters, ridge);
  nuisances = Nuisances::from_json(parameters);
}

void MmseParameters::add_to(nlohmann::json& parameters) const {
  parameters["symmetries"] = symmetries;
  ridge.add_to(parameters, "ridge");
  nuisances.add_to(parameters);
}

void MmseParameters::settle(const Solver& solver, const FitInput& input,
                            const std::function<void(double)>& set) {
  if (!ridge.automatic()) return;
  const ValidationFrames frames = read_validation_frames(input, ridge.place);
  ridge.choose(solver, frames, input.threads, {1e-7, 1e-2}, 2, set);
}

LinearMmse::LinearMmse(JsonObject parameters)
    : LinearSolver(type, LinearInference::from_json(parameters)),
      follows_noise_(parameters.choice_or("inference_noise", "fit", {"fit", "frame"}) == "frame") {
  read(std::move(parameters));
}

void LinearMmse::read(JsonObject parameters) {
  parameters.integer_or("components", 1, 1, 1);
  settings_.read(parameters);
  set_mask(ChannelMask::from_json(parameters));
  parameters.finish();
}

nlohmann::json LinearMmse::parameters() const {
  nlohmann::json out = LinearSolver::parameters();
  if (follows_noise_) out["inference_noise"] = "frame";
  return out;
}

nlohmann::json LinearMmse::fit_parameters() const {
  nlohmann::json out = {{"components", 1}};
  settings_.add_to(out);
  mask().add_to(out);
  return out;
}

void LinearMmse::fit(const FitInput& input) {
  set_sensor(input.sensor);
  JointMoments moments = moments_of(TrainingScenes(input, type, settings_.symmetries), {}, true);
  changes_ = std::move(moments.changes) + covariance_of(settings_.nuisances, sensor());
  cross_ = std::move(moments.cross);
  const std::vector<Eigen::Index> kept = kept_pairs();
  const Eigen::MatrixXd changes = changes_(kept, kept);
  const Eigen::MatrixXd cross = cross_(Eigen::all, kept);
  const auto set_ridge = [&](double ridge) {
    set_inverse(mmse_matrix(changes, cross, added(ridge)));
  };
  settings_.settle(*this, input, set_ridge);
  set_ridge(*settings_.ridge.value);
  finish();
}

std::unique_ptr<const FrameInverse> LinearMmse::frame_inverse() const {
  auto out = std::make_unique<SpectralInverse>(changes_, cross_, added(*settings_.ridge.value));
  if (follows_noise_) out->follow_noise();
  return out;
}

void LinearMmse::save_fit(Hdf5File& file) const {
  save_matrix(file);
  file.write_matrix("/changes", changes_);
  file.write_matrix("/cross", cross_);
}

void LinearMmse::load_fit(const Hdf5File& file, const Sensor& sensor) {
  settings_.ridge.require_chosen();
  const auto pairs = static_cast<std::uint64_t>(Reciprocity(sensor).pairs());
  const auto pixels = static_cast<std::uint64_t>(sensor.pixels());
  file.require_shape("/changes", {pairs, pairs});
  file.require_shape("/cross", {pixels, pairs});
  changes_ = file.read_rows("/changes", 0, pairs);
  cross_ = file.read_rows("/cross", 0, pixels);
  load_matrix(file, sensor);
}

MixtureMmse::MixtureMmse(JsonObject parameters) { read(std::move(parameters)); }

void MixtureMmse::read(JsonObject parameters) {
  components_ = parameters.integer("components", 2, 1024);
  settings_.read(parameters);
  mask_ = ChannelMask::from_json(parameters);
  parameters.finish();
}

nlohmann::json MixtureMmse::parameters() const {
  nlohmann::json out = {{"components", components_}};
  settings_.add_to(out);
  mask_.add_to(out);
  return out;
}

void MixtureMmse::set_sensor(const Sensor& sensor) {
  sensor_ = sensor;
  reciprocity_ = Reciprocity(sensor);
}

void MixtureMmse::set_mean() {
  mean_ = std::make_shared<const MixtureMean>(mixture_, pairs_without(sensor_, mask_.electrodes),
                                              *settings_.ridge.value);
  masked_.clear();
}

void MixtureMmse::fit(const FitInput& input) {
  set_sensor(input.sensor);
  mixture_ = fit_mixture(TrainingScenes(input, type, settings_.symmetries), components_);
  const Eigen::MatrixXd nuisances = covariance_of(settings_.nuisances, sensor_);
  for (GaussianMixture::Component& c : mixture_.components) c.changes += nuisances;
  settings_.settle(*this, input, [&](double ridge) {
    settings_.ridge.value = ridge;
    set_mean();
  });
  set_mean();
}

std::shared_ptr<const MixtureMean> MixtureMmse::mean_without(ElectrodeSet dead) const {
  const std::lock_guard lock(masked_mutex_);
  const auto found = masked_.find(dead);
  if (found != masked_.end()) return found->second;
  const std::vector<Eigen::Index> kept = pairs_without(sensor_, mask_.electrodes | dead);
  if (masked_.size() == most_masked) masked_.clear();
  return masked_[dead] = kept.empty() ? nullptr
                                      : std::make_shared<const MixtureMean>(mixture_, kept,
                                                                            *settings_.ridge.value);
}

void MixtureMmse::reconstruct(FramesView changes, ImagesView images,
                              std::span<FrameReport> reports) const {
  thread_local Eigen::VectorXd sums;
  sums.resize(reciprocity_.pairs());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const ElectrodeSet dead = reports[static_cast<std::size_t>(f)].dead;
    const std::shared_ptr<const MixtureMean> masked = dead ? mean_without(dead) : nullptr;
    if (dead && !masked) {
      images.row(f).setZero();
      continue;
    }
    reciprocity_.sum(changes.row(f).data(), sums.data());
    (masked ? *masked : *mean_).estimate(sums, images.row(f));
  }
}

std::optional<LayerList> MixtureMmse::layers() const {
  LayerList out = pair_layers(reciprocity_, mask_);
  mean_->add_layers(out, reciprocity_);
  return out;
}

void MixtureMmse::save(const std::filesystem::path& file) const {
  using Component = GaussianMixture::Component;
  Hdf5File out = create_solver_file(file, type, sensor_, parameters());
  Eigen::VectorXd weights(static_cast<Eigen::Index>(mixture_.components.size()));
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    weights[k] = mixture_.components[static_cast<std::size_t>(k)].weight;
  }
  out.write_vector("/weights", weights);
  out.write_matrix("/directions", mixture_.directions);
  out.write_matrix("/change_means", stacked(mixture_, [](const Component& c) {
                     return Eigen::RowVectorXd(c.change_mean.transpose());
                   }));
  out.write_matrix("/image_means", stacked(mixture_, [](const Component& c) {
                     return Eigen::RowVectorXd(c.image_mean.transpose());
                   }));
  out.write_matrix("/changes",
                   stacked(
                       mixture_, [](const Component& c) -> const auto& { return c.changes; }));
  out.write_matrix("/cross",
                   stacked(
                       mixture_, [](const Component& c) -> const auto& { return c.cross; }));
  out.close();
}

void MixtureMmse::load(const std::filesystem::path& file, const Sensor& sensor) {
  const Hdf5File opened = open_solver_file(file, type, sensor);
  read(JsonObject(parameters_of_fit(opened), file.string(), "/parameters"));
  settings_.ridge.require_chosen();
  const auto pairs = static_cast<std::uint64_t>(Reciprocity(sensor).pairs());
  const auto pixels = static_cast<std::uint64_t>(sensor.pixels());
  const std::uint64_t count = opened.require_shape("/weights", {0}).front();
  const std::uint64_t directions = opened.require_shape("/directions", {pairs, 0})[1];
  opened.require_shape("/change_means", {count, pairs});
  opened.require_shape("/image_means", {count, pixels});
  opened.require_shape("/changes", {count * pairs, pairs});
  opened.require_shape("/cross", {count * pixels, directions});
  if (directions > pairs) throw InputError(file.string() + ": /directions: are more than pairs");

  set_sensor(sensor);
  mixture_ = {opened.read_rows("/directions", 0, pairs), {}};
  const Eigen::VectorXd weights = opened.read_vector("/weights");
  for (std::uint64_t k = 0; k < count; ++k) {
    mixture_.components.push_back({weights[static_cast<Eigen::Index>(k)],
                                   opened.read_rows("/change_means", k, 1).transpose(),
                                   opened.read_rows("/image_means", k, 1).transpose(),
                                   opened.read_rows("/changes", k * pairs, pairs),
                                   opened.read_rows("/cross", k * pixels, pixels)});
  }
  set_mean();
}

}  // namespace ertbench
