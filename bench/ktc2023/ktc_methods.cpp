#include "bench/ktc2023/ktc_methods.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/ktc2023/simulated_tanks.h"
#include "core/fields.h"

namespace ertbench {
namespace {

constexpr int image_size = 256;

struct Options {
  double length_mm = 30;
  double noise = 0.003;
  double model_error = 0.05;
  double contrast = 2.6;
  double sharpness = 0.2;
  double likely = 1;
  int iterations = 6;
  int rank = 50;
  int scenes = 1000;
};

/// d packed resistances of `pairs` / d coefficients of the `functions`, of which a triangle has the
/// mean at its nodes, [pairs, functions]. `by_triangle`: d conductivity by such a mean. Single
/// precision is as good for a step and twice as fast.
Eigen::MatrixXf sensitivity_of(const TankModel& tank, const TankModel::Solution& solution,
                               const Eigen::VectorXd& by_triangle, const Eigen::MatrixXf& functions,
                               const std::vector<Eigen::Index>& pairs) {
  Eigen::MatrixXf nodal = Eigen::MatrixXf::Zero(TankModel::pairs, tank.nodes().cols());
  for (std::size_t t = 0; t < tank.triangles().size(); ++t) {
    const double share = by_triangle[static_cast<Eigen::Index>(t)] / 3;
    const Eigen::VectorXf column = static_cast<float>(share) * tank.sensitivity(solution, t);
    for (const int node : tank.triangles()[t]) nodal.col(node) += column;
  }
  return nodal(pairs, Eigen::all) * functions;
}

Eigen::VectorXd uniform(const KtcSetting& setting) {
  return Eigen::VectorXd::Constant(std::ssize(setting.tank->triangles()),
                                   setting.calibration.conductivity);
}

/// Columns that make a smooth random function of variance 1 (Matérn 3/2) at the nodes out of
/// independent coefficients, from a lattice of points a third of its length apart.
Eigen::MatrixXd smooth_functions(const TankModel& tank, double length) {
  const double step = std::clamp(length / 3, 0.008, 0.02);
  std::vector<Eigen::Vector2d> points;
  const int reach = static_cast<int>(TankModel::radius / step) + 1;
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      const Eigen::Vector2d point(i * step, j * step);
      if (point.norm() < TankModel::radius + step / 4) points.push_back(point);
    }
  }
  const auto covariance = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const double distance = std::sqrt(3.0) * (a - b).norm() / length;
    return (1 + distance) * std::exp(-distance);
  };
  const Eigen::VectorXd weights = tank.node_areas();
  const auto count = std::ssize(points);
  Eigen::MatrixXd own(count, count);
  Eigen::MatrixXd cross(count, tank.nodes().cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d& point = points[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < count; ++j) {
      own(i, j) = covariance(point, points[static_cast<std::size_t>(j)]) + (i == j ? 1e-6 : 0);
    }
    for (Eigen::Index j = 0; j < cross.cols(); ++j) {
      cross(i, j) = covariance(point, tank.nodes().col(j));
    }
  }
  own.llt().matrixL().solveInPlace(cross);
  // Of these the principal ones, which have all but a small part of the variance.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> principal(cross * weights.asDiagonal() *
                                                                 cross.transpose());
  constexpr double left_out = 0.005;
  const Eigen::VectorXd variances = principal.eigenvalues();
  Eigen::Index first = 0;
  for (double sum = variances[0]; sum < left_out * variances.sum(); sum += variances[++first]) {
  }
  return cross.transpose() * principal.eigenvectors().rightCols(count - first);
}

/// Gauss–Newton's change of `coefficients`, which are independent of variance 1 a priori, where the
/// model has changed its resistances by `resistance_change`.
Eigen::VectorXd regularised(const KtcMisfit& misfit, const Eigen::MatrixXf& jacobian,
                            const Eigen::VectorXd& resistance_change,
                            const Eigen::VectorXd& coefficients) {
  const Eigen::MatrixXf weighted = misfit.normal.cast<float>() * jacobian;
  Eigen::MatrixXd normal = (jacobian.transpose() * weighted).cast<double>();
  normal.diagonal().array() += 1;
  const Eigen::VectorXd left = misfit.side - misfit.normal * resistance_change;
  return normal.llt().solve(jacobian.transpose().cast<double>() * left - coefficients);
}

/// A method whose unknowns are coefficients of smooth functions, independent and of variance 1.
class InSmoothFunctions : public KtcMethod {
 public:
  InSmoothFunctions(const TankModel& tank, const Options& options)
      : options_(options),
        functions_(options.likely * smooth_functions(tank, options.length_mm / 1000)),
        single_(functions_.cast<float>()) {}

 protected:
  Options options_;
  Eigen::MatrixXd functions_;  ///< [nodes, coefficients]
  Eigen::MatrixXf single_;     ///< the same
};

class OneStep final : public InSmoothFunctions {
 public:
  using InSmoothFunctions::InSmoothFunctions;

  KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const override {
    const KtcMisfit misfit(setting, frame, options_.noise, options_.model_error);
    const Eigen::MatrixXf jacobian = sensitivity_of(*setting.tank, setting.calibration.empty,
                                                    uniform(setting), single_, misfit.pairs);
    const Eigen::VectorXd change =
        regularised(misfit, jacobian, Eigen::VectorXd::Zero(jacobian.rows()),
                    Eigen::VectorXd::Zero(functions_.cols()));
    return {setting.tank->image(functions_ * change, image_size), std::nullopt};
  }
};

class TruncatedSvd final : public InSmoothFunctions {
 public:
  using InSmoothFunctions::InSmoothFunctions;

  KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const override {
    // The misfit's square root stands for the weighted channels; then A A^T has the left vectors.
    const KtcMisfit misfit(setting, frame, options_.noise, options_.model_error);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> root(misfit.normal);
    const Eigen::VectorXd scale = root.eigenvalues().cwiseMax(0).cwiseSqrt();
    const Eigen::MatrixXd jacobian = scale.asDiagonal() * root.eigenvectors().transpose() *
                                     sensitivity_of(*setting.tank, setting.calibration.empty,
                                                    uniform(setting), single_, misfit.pairs)
                                         .cast<double>();
    const Eigen::VectorXd side =
        (root.eigenvectors().transpose() * misfit.side).binaryExpr(scale, [&](double x, double s) {
          return s > 1e-9 * scale.maxCoeff() ? x / s : 0;
        });
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> left(jacobian * jacobian.transpose());
    const auto vectors = left.eigenvectors().rightCols(options_.rank);
    const Eigen::VectorXd inverse = left.eigenvalues().tail(options_.rank).cwiseInverse();
    const Eigen::VectorXd coefficients =
        jacobian.transpose() * (vectors * (inverse.asDiagonal() * (vectors.transpose() * side)));
    return {setting.tank->image(functions_ * coefficients, image_size), std::nullopt};
  }
};

/// Log conductivity by a level set, and its derivative: `contrast` above 1, -`contrast` below -1,
/// with transitions of the logistic function of that `width`. Without a contrast the level is the
/// log conductivity itself.
struct Contrast {
  double contrast;
  double width;

  double step(double at) const { return 1 / (1 + std::exp(-(at - 1) / width)); }
  double value(double at) const { return contrast > 0 ? contrast * (step(at) - step(-at)) : at; }
  double slope(double at) const {
    if (!(contrast > 0)) return 1;
    const double up = step(at);
    const double down = step(-at);
    return contrast * (up * (1 - up) + down * (1 - down)) / width;
  }
};

/// Gauss–Newton on the finite elements, of a level set or of the log conductivity.
class Iterated final : public InSmoothFunctions {
 public:
  using InSmoothFunctions::InSmoothFunctions;

  KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const override {
    const KtcMisfit misfit(setting, frame, options_.noise, options_.model_error);
    Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(functions_.cols());
    State now;
    double width = 0;
    for (int i = 0; i < options_.iterations; ++i) {
      const Contrast contrast{options_.contrast, std::max(options_.sharpness, std::pow(0.6, i))};
      if (contrast.width != width) now = state(setting, misfit, contrast, coefficients);
      width = contrast.width;
      Eigen::VectorXd change = regularised(
          misfit, sensitivity_of(*setting.tank, now.solution, now.slopes, single_, misfit.pairs),
          now.resistance_change, coefficients);
      constexpr double most = 1.5;  // of the level set, where the model is linear no more
      change *= std::min(1.0, most / (functions_ * change).cwiseAbs().maxCoeff());
      constexpr int halvings = 2;
      State next = state(setting, misfit, contrast, coefficients + change);
      for (int k = 0; k < halvings && next.cost >= now.cost; ++k) {
        change /= 2;
        next = state(setting, misfit, contrast, coefficients + change);
      }
      now = std::move(next);
      coefficients += change;
    }
    const Eigen::VectorXd levels = functions_ * coefficients;
    KtcImage out{setting.tank->image(levels, image_size), std::nullopt};
    if (options_.contrast > 0) {
      out.classes = out.change.unaryExpr([](double x) { return x > 1 ? 2 : x < -1 ? 1 : 0; });
    }
    return out;
  }

 private:
  /// The model at a level set.
  struct State {
    Eigen::VectorXd slopes;  ///< of the conductivity by the level, [triangles]
    TankModel::Solution solution;
    Eigen::VectorXd resistance_change;  ///< of the misfit's pairs
    double cost;  ///< twice the negative logarithm of the posterior, but for a constant
  };

  State state(const KtcSetting& setting, const KtcMisfit& misfit, const Contrast& contrast,
              const Eigen::VectorXd& coefficients) const {
    const TankModel& tank = *setting.tank;
    const Eigen::VectorXd levels = functions_ * coefficients;
    Eigen::VectorXd conductivity = uniform(setting);
    State out;
    out.slopes.resize(conductivity.size());
    for (std::size_t t = 0; t < tank.triangles().size(); ++t) {
      const auto at = static_cast<Eigen::Index>(t);
      const double level = levels(tank.triangles()[t]).mean();
      conductivity[at] *= std::exp(contrast.value(level));
      out.slopes[at] = conductivity[at] * contrast.slope(level);
    }
    out.solution = tank.solve(conductivity, setting.calibration.contact_impedance);
    out.resistance_change = TankModel::packed(out.solution.resistance -
                                              setting.calibration.empty.resistance)(misfit.pairs);
    out.cost = coefficients.squaredNorm() +
               out.resistance_change.dot(misfit.normal * out.resistance_change) -
               2 * out.resistance_change.dot(misfit.side);
    return out;
  }
};

/// Linear in the frame, by second moments of simulated frames and classes.
class LinearEstimate final : public KtcMethod {
 public:
  explicit LinearEstimate(const Options& options) : options_(options) {}

  void prepare(const KtcSetting& setting, const KtcFrame&) override {
    if (std::exchange(setting_, &setting) == &setting) return;
    const TankModel& tank = *setting.tank;
    Eigen::MatrixXd changes(TankModel::pairs, options_.scenes);
    Eigen::MatrixXd classes(tank.nodes().cols(), options_.scenes);
    for (int i = 0; i < options_.scenes; ++i) {
      RandomStream random(0, key_of("ktc2023 training"), static_cast<std::uint64_t>(i),
                          Purpose::scene);
      const SimulatedCylinders cylinders(random, static_cast<std::size_t>(1 + i % 5));
      const Eigen::MatrixXd resistance =
          tank.solve(cylinders.conductivity(tank, setting.calibration.conductivity),
                     setting.calibration.contact_impedance)
              .resistance;
      changes.col(i) = TankModel::packed(resistance - setting.calibration.empty.resistance);
      for (Eigen::Index n = 0; n < classes.rows(); ++n) {
        const int kind = cylinders.kind_at(tank.nodes().col(n));
        classes(n, i) = kind == 2 ? 1 : -kind;
      }
    }
    moments_ = changes * changes.transpose() / options_.scenes;
    cross_ = classes * changes.transpose() / options_.scenes;
  }

  KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const override {
    // E[x r'] P' (P E[r r'] P' + noise)^-1 change, in resistances instead of channels.
    const KtcMisfit misfit(setting, frame, options_.noise, options_.model_error);
    Eigen::MatrixXd system = misfit.normal * moments_(misfit.pairs, misfit.pairs);
    system.diagonal().array() += 1;
    const Eigen::VectorXd weights = system.partialPivLu().solve(misfit.side);
    return {setting.tank->image(cross_(Eigen::all, misfit.pairs) * weights, image_size),
            std::nullopt};
  }

 private:
  Options options_;
  const KtcSetting* setting_ = nullptr;  ///< for which the moments are
  Eigen::MatrixXd moments_;              ///< [528, 528]
  Eigen::MatrixXd cross_;                ///< [nodes, 528]
};

}  // namespace

KtcMisfit::KtcMisfit(const KtcSetting& setting, const KtcFrame& frame, double noise,
                     double model_error) {
  const Eigen::ArrayXd weight =
      frame.present.array() /
      (std::pow(noise, 2) + (model_error * frame.change.array()).square()).sqrt();
  const Eigen::SparseMatrix<double> weighted = weight.matrix().asDiagonal() * setting.channels;
  normal = Eigen::SparseMatrix<double>(weighted.transpose() * weighted);
  side = weighted.transpose() * (weight * frame.change.array()).matrix();
  for (Eigen::Index i = 0; i < side.size(); ++i) {
    if (normal(i, i) > 0) pairs.push_back(i);
  }
  normal = normal(pairs, pairs).eval();
  side = side(pairs).eval();
}

std::unique_ptr<KtcMethod> ktc_method_from_json(JsonObject& object, const TankModel& tank) {
  Options options;
  const std::string type = object.choice(
      "type", {"one-step-gn", "gauss-newton", "tsvd", "lmmse", "level-set", "registry"});
  RegistryOptions registry;
  if (type == "gauss-newton") options.contrast = 0;
  Fields::read_some(object, [&](Fields& fields) {
    fields.number("noise", options.noise, {1e-6, 1, false, "ohm"});
    fields.number("model_error", options.model_error, {0, 1});
    if (type == "registry") {
      fields.integer("image_grid", registry.image_grid, 8, 128);
      return fields.integer("scenes", registry.scenes, 32, 1000000);
    }
    if (type == "lmmse") return fields.integer("scenes", options.scenes, 2, 100000);
    fields.number("length_mm", options.length_mm, {10, 200, false, "mm"});
    if (type == "tsvd") return fields.integer("rank", options.rank, 1, TankModel::pairs / 2);
    if (type == "one-step-gn") return;
    if (type == "level-set") {
      fields.number("contrast", options.contrast, {0.1, 10});
      fields.number("sharpness", options.sharpness, {0.05, 1});
    }
    fields.number("spread", options.likely, {0.1, 10});
    fields.integer("iterations", options.iterations, 1, 100);
  });
  if (type == "registry") {
    registry.solver = object.raw("solver");
    registry.source = object.source();
    registry.path = object.path_of("solver");
    registry.noise = options.noise;
    registry.model_error = options.model_error;
    return registry_method(std::move(registry));
  }
  if (type == "one-step-gn") return std::make_unique<OneStep>(tank, options);
  if (type == "tsvd") return std::make_unique<TruncatedSvd>(tank, options);
  if (type == "lmmse") return std::make_unique<LinearEstimate>(options);
  return std::make_unique<Iterated>(tank, options);
}

}  // namespace ertbench
