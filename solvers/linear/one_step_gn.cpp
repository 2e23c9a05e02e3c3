#include "solvers/linear/one_step_gn.h"

#include <nlohmann/json.hpp>

#include "solvers/dense_svd.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

/// (J^T J + lambda^2 R^T R)^-1 J^T for any lambda, from one singular value decomposition.
///
/// A constant image c 1 that the prior does not see is split off: q = J 1 / |J 1| are the data it
/// explains, the rest is fitted by E y alone, and c takes up what is left along q.
class RegularisedInverse {
 public:
  RegularisedInverse(const Eigen::MatrixXd& jacobian, const PriorFactors& prior) {
    Eigen::MatrixXd shaped = jacobian * prior.shaping;
    if (prior.free_constant) {
      const Eigen::VectorXd constant = jacobian.rowwise().sum();
      const Eigen::VectorXd q = constant.normalized();
      shaped -= q * (q.transpose() * shaped);
      constant_data_ = q.transpose() / constant.norm();
      constant_jacobian_ = constant_data_ * jacobian;
    }
    const DenseSvd svd = dense_svd(shaped);
    values_ = svd.values;
    left_ = svd.left;
    right_ = prior.shaping * svd.right;
  }

  double largest() const { return values_[0]; }

  Eigen::MatrixXd inverse(double lambda) const {
    // s / (s^2 + lambda^2) without squaring, which could underflow.
    const Eigen::VectorXd filter = values_.unaryExpr([lambda](double s) {
      const double length = std::hypot(s, lambda);
      return s / length / length;
    });
    Eigen::MatrixXd inverse = right_ * filter.asDiagonal() * left_.transpose();
    if (constant_data_.size()) {
      const Eigen::RowVectorXd constant = constant_data_ - constant_jacobian_ * inverse;
      inverse.rowwise() += constant;
    }
    return inverse;
  }

 private:
  Eigen::VectorXd values_;
  Eigen::MatrixXd left_;   ///< [pairs, rank]
  Eigen::MatrixXd right_;  ///< E times the right singular vectors [pixels, rank]
  Eigen::RowVectorXd constant_data_;
  Eigen::RowVectorXd constant_jacobian_;
};

}  // namespace

OneStepGaussNewton::OneStepGaussNewton(JsonObject parameters)
    : LinearSolver(LinearInference::from_json(parameters)) {
  read(std::move(parameters));
}

void OneStepGaussNewton::read(JsonObject parameters) {
  prior_ = prior_from_name(
      parameters.choice_or("prior", name_of(Prior::noser), {"tikhonov", "noser", "laplace"}));
  lambda_ = read_weight(parameters, "lambda");
  choice_ = read_chosen(parameters, lambda_.value);
  set_mask(ChannelMask::from_json(parameters));
  parameters.finish();
}

nlohmann::json OneStepGaussNewton::parameters() const {
  nlohmann::json out = fit_parameters();
  inference().add_to(out);
  return out;
}

nlohmann::json OneStepGaussNewton::fit_parameters() const {
  nlohmann::json out = {{"prior", name_of(prior_)}, {"lambda", "auto"}};
  if (lambda_.value) out["lambda"] = *lambda_.value;
  mask().add_to(out);
  if (choice_) out["chosen"] = to_json(*choice_);
  return out;
}

void OneStepGaussNewton::fit(const FitInput& input) {
  set_sensor(input.sensor);
  const Eigen::MatrixXd jacobian = whole_jacobian();
  const RegularisedInverse inverse(jacobian(kept_pairs(), Eigen::all),
                                   prior_factors(prior_, jacobian, sensor().image_columns()));
  if (lambda_.automatic()) {
    const ValidationFrames frames = read_validation_frames(input, lambda_.place);
    const auto error_of = [&](double lambda) {
      set_inverse(inverse.inverse(lambda));
      return mean_relative_error(*this, frames, input.threads);
    };
    choice_ = choose_number(lambda_.place, 1e-4 * inverse.largest(), inverse.largest(), 4,
                            static_cast<int>(frames.changes.rows()), error_of);
    lambda_.value = choice_->value;
  }
  set_inverse(inverse.inverse(*lambda_.value));
  finish();
}

std::unique_ptr<const MaskedInverse> OneStepGaussNewton::masked_inverse() const {
  const Eigen::MatrixXd jacobian = whole_jacobian();
  return std::make_unique<MaskedGaussNewton>(
      jacobian, prior_factors(prior_, jacobian, sensor().image_columns()), *lambda_.value);
}

void OneStepGaussNewton::save(const std::filesystem::path& file) const {
  Hdf5File out = create_solver_file(file, type, sensor(), fit_parameters());
  save_matrix(out);
  out.close();
}

void OneStepGaussNewton::load(const std::filesystem::path& file, const Sensor& sensor) {
  const Hdf5File opened = open_solver_file(file, type, sensor);
  const nlohmann::json parameters = parameters_of_fit(opened);
  read(JsonObject(parameters, file.string(), "/parameters"));
  load_matrix(opened, sensor);
}

}  // namespace ertbench
