#include "solvers/linear/linear_mmse.h"

#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "solvers/linear/training_scenes.h"
#include "solvers/solver_file.h"

namespace ertbench {

Eigen::MatrixXd mmse_matrix(const Eigen::MatrixXd& changes, const Eigen::MatrixXd& cross,
                            double ridge) {
  Eigen::MatrixXd matrix = changes;
  matrix.diagonal().array() += ridge * changes.diagonal().mean();
  const Eigen::MatrixXd solved = matrix.ldlt().solve(cross.transpose());
  return solved.transpose();
}

LinearMmse::LinearMmse(JsonObject parameters)
    : LinearSolver(LinearInference::from_json(parameters)) {
  read(std::move(parameters));
}

void LinearMmse::read(JsonObject parameters) {
  parameters.integer_or("components", 1, 1, 1);
  ridge_ = read_weight(parameters, "ridge");
  symmetries_ = parameters.boolean_or("symmetries", true);
  choice_ = read_chosen(parameters, ridge_.value);
  set_mask(ChannelMask::from_json(parameters));
  parameters.finish();
}

nlohmann::json LinearMmse::parameters() const {
  nlohmann::json out = fit_parameters();
  inference().add_to(out);
  return out;
}

nlohmann::json LinearMmse::fit_parameters() const {
  nlohmann::json out = {{"components", 1}, {"ridge", "auto"}, {"symmetries", symmetries_}};
  if (ridge_.value) out["ridge"] = *ridge_.value;
  mask().add_to(out);
  if (choice_) out["chosen"] = to_json(*choice_);
  return out;
}

void LinearMmse::fit(const FitInput& input) {
  set_sensor(input.sensor);
  JointMoments moments = moments_of(TrainingScenes(input, type, symmetries_), {}, true);
  changes_ = std::move(moments.changes);
  cross_ = std::move(moments.cross);
  const std::vector<Eigen::Index> kept = kept_pairs();
  const Eigen::MatrixXd changes = changes_(kept, kept);
  const Eigen::MatrixXd cross = cross_(Eigen::all, kept);
  if (ridge_.automatic()) {
    const ValidationFrames frames = read_validation_frames(input, ridge_.place);
    const auto error_of = [&](double ridge) {
      set_inverse(mmse_matrix(changes, cross, ridge));
      return mean_relative_error(*this, frames, input.threads);
    };
    choice_ = choose_number(ridge_.place, 1e-7, 1e-2, 2, static_cast<int>(frames.changes.rows()),
                            error_of);
    ridge_.value = choice_->value;
  }
  set_inverse(mmse_matrix(changes, cross, *ridge_.value));
  finish();
}

std::unique_ptr<const MaskedInverse> LinearMmse::masked_inverse() const {
  return std::make_unique<MaskedMmse>(changes_, cross_, *ridge_.value);
}

void LinearMmse::save(const std::filesystem::path& file) const {
  Hdf5File out = create_solver_file(file, type, sensor(), fit_parameters());
  save_matrix(out);
  out.write_matrix("/changes", changes_);
  out.write_matrix("/cross", cross_);
  out.close();
}

void LinearMmse::load(const std::filesystem::path& file, const Sensor& sensor) {
  const Hdf5File opened = open_solver_file(file, type, sensor);
  const nlohmann::json parameters = parameters_of_fit(opened);
  read(JsonObject(parameters, file.string(), "/parameters"));
  if (ridge_.automatic()) throw InputError(file.string() + ": has no ridge; fit the solver again");
  const auto pairs = static_cast<std::uint64_t>(Reciprocity(sensor).pairs());
  const auto pixels = static_cast<std::uint64_t>(sensor.pixels());
  opened.require_shape("/changes", {pairs, pairs});
  opened.require_shape("/cross", {pixels, pairs});
  changes_ = opened.read_rows("/changes", 0, pairs);
  cross_ = opened.read_rows("/cross", 0, pixels);
  load_matrix(opened, sensor);
}

}  // namespace ertbench
