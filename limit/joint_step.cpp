#include <algorithm>
#include <cmath>
#include <numbers>

#include "forward/ellipses/ellipse_model.h"
#include "limit/annealed_sampler.h"
#include "limit/scene_likelihood.h"

namespace ertbench {
namespace {

constexpr double widest = 0.5;  ///< step of a quantity in domain units, rad, or of its own range
/// Largest drift in units of these widths: far from the posterior the slopes are unreliable.
constexpr double widest_drift = 0.5;
constexpr int most_quantities = 6;

bool has_aspect(DrawnShape shape) {
  return shape == DrawnShape::ellipse || shape == DrawnShape::rectangle;
}
bool has_angle(DrawnShape shape) {
  return shape != DrawnShape::disc && shape != DrawnShape::ring && shape != DrawnShape::cross;
}

/// The quantities of a contact that move beside its centre: the logarithm of its size, its
/// conductivity ratio, aspect and angle, each if it is free and its shape has it.
struct Freedom {
  bool size, ratio, aspect, angle;

  Freedom(const ContactDraw& contact, const ScenePrior& prior)
      : size(prior.size_is_free()),
        ratio(prior.ratio_is_free()),
        aspect(has_aspect(contact.shape) &&
               prior.distribution().aspect.first < prior.distribution().aspect.second),
        angle(has_angle(contact.shape)) {}
};

/// Largest steps of the quantities, in the order of Freedom.
Eigen::VectorXd widths_of(const SceneDraw& scene, const ScenePrior& prior) {
  const auto range = [](const std::pair<double, double>& interval) {
    return interval.second - interval.first;
  };
  const SceneDistribution& d = prior.distribution();
  Eigen::VectorXd widths(most_quantities * static_cast<Eigen::Index>(scene.size()));
  Eigen::Index at = 0;
  for (const ContactDraw& contact : scene) {
    const Freedom free(contact, prior);
    widths[at++] = widest;
    widths[at++] = widest;
    if (free.size) widths[at++] = widest;
    if (free.ratio) widths[at++] = widest * range(d.conductivity_ratio);
    if (free.aspect) widths[at++] = widest * range(d.aspect);
    if (free.angle) widths[at++] = widest;
  }
  widths.conservativeResize(at);
  return widths;
}

Eigen::Vector2d at_twice(double angle) { return {std::cos(2 * angle), std::sin(2 * angle)}; }

}  // namespace

JointStep::JointStep(const ScenePrior& prior, const EllipseModel& model)
    : prior_(prior), model_(model), pairs_(reciprocal_pairs(model.sensor())) {}

Eigen::VectorXd JointStep::Local::draw(RandomStream& random) const {
  Eigen::VectorXd step(mean.size());
  for (double& value : step) value = random.normal();
  return mean + precision.matrixU().solve(step);
}

double JointStep::Local::log_density(const Eigen::VectorXd& step) const {
  const Eigen::VectorXd white = precision.matrixU() * (step - mean);
  return sum_of_logs(precision.matrixLLT().diagonal().array()) - white.squaredNorm() / 2;
}

bool JointStep::slopes_of(std::span<const EllipticContact> ellipses,
                          Eigen::Ref<Eigen::MatrixXd> out) {
  if (!model_.place(ellipses, workspace_)) return false;
  Eigen::VectorXd change(model_.pairs());
  model_.evaluate(workspace_, change);
  model_.derivatives(workspace_, out);
  return true;
}

std::optional<Eigen::MatrixXd> JointStep::slopes_of(const SceneDraw& scene,
                                                    std::span<const EllipticContact> ellipses) {
  const auto contacts = static_cast<Eigen::Index>(scene.size());
  Eigen::MatrixXd own(model_.pairs(), EllipticContact::parameters * contacts);
  if (!slopes_of(ellipses, own)) {
    // Ellipses that cross each other are linearised one by one.
    for (Eigen::Index c = 0; c < contacts; ++c) {
      auto columns = own.middleCols(EllipticContact::parameters * c, EllipticContact::parameters);
      if (!slopes_of(ellipses.subspan(static_cast<std::size_t>(c), 1), columns)) {
        return std::nullopt;
      }
    }
  }
  Eigen::MatrixXd out(model_.pairs(), most_quantities * contacts);
  Eigen::Index at = 0;
  for (Eigen::Index c = 0; c < contacts; ++c) {
    const ContactDraw& contact = scene[static_cast<std::size_t>(c)];
    const Freedom free(contact, prior_);
    const EllipticContact& ellipse = ellipses[static_cast<std::size_t>(c)];
    // Columns: derivatives by centre x, y, log size, stretch x, y, log ratio.
    const auto by = own.middleCols(EllipticContact::parameters * c, EllipticContact::parameters);
    const Eigen::Vector2d arm = ellipse.centre - contact.centre;
    out.col(at++) = by.col(0);
    out.col(at++) = by.col(1);
    if (free.size) out.col(at++) = by.col(2) + by.leftCols<2>() * arm;
    if (free.ratio) out.col(at++) = by.col(5) / contact.conductivity_ratio;
    if (free.aspect) {
      const double aspect = contact.aspect;
      double growth = 1 / (2 * aspect);
      // The corners of a rectangle stay on the circle.
      if (contact.shape == DrawnShape::rectangle) growth -= aspect / (1 + aspect * aspect);
      out.col(at++) =
          growth * by.col(2) - by.middleCols<2>(3) * (at_twice(contact.angle) / (2 * aspect));
    }
    if (free.angle) {
      const Eigen::Vector2d turned(-ellipse.stretch.y(), ellipse.stretch.x());
      out.col(at++) = by.middleCols<2>(3) * (2 * turned) +
                      by.leftCols<2>() * Eigen::Vector2d(-arm.y(), arm.x());
    }
  }
  out.conservativeResize(Eigen::NoChange, at);
  return out;
}

std::optional<JointStep::Local> JointStep::around(const SceneDraw& scene, const SceneFit& fit,
                                                  double heat, double scale) {
  if (scene.empty() || fit.rest.size() == 0) return std::nullopt;
  std::vector<EllipticContact> ellipses;
  for (const ContactDraw& contact : scene) {
    if (std::abs(1 - contact.conductivity_ratio) < 1e-6) return std::nullopt;
    ellipses.push_back(nearest_ellipse(contact_of(contact)));
  }
  const std::optional<Eigen::MatrixXd> by_quantity = slopes_of(scene, ellipses);
  if (!by_quantity) return std::nullopt;
  const Eigen::MatrixXd slopes = *by_quantity / fit.noise;
  Eigen::VectorXd rest(model_.pairs());
  // The mean of two channels has half the variance of one.
  const double weight = pairs_[0][0] == pairs_[0][1] ? 1 : 2;
  for (Eigen::Index p = 0; p < rest.size(); ++p) {
    const auto [a, b] = pairs_[static_cast<std::size_t>(p)];
    rest[p] = (fit.rest[a] + fit.rest[b]) / 2;
  }
  const Eigen::VectorXd widths = widths_of(scene, prior_);
  Eigen::MatrixXd precision = heat * weight * slopes.transpose() * slopes;
  precision.diagonal().array() += 1 / widths.array().square();
  Local out;
  out.mean = precision.llt().solve(heat * weight * slopes.transpose() * rest) * (scale * scale / 2);
  const double farthest = (out.mean.array().abs() / widths.array()).maxCoeff();
  if (!std::isfinite(farthest)) return std::nullopt;
  out.mean *= std::min(1.0, widest_drift / std::max(farthest, 1e-300));
  out.precision.compute(precision / (scale * scale));
  return out;
}

std::pair<SceneDraw, double> JointStep::after(const SceneDraw& scene,
                                              const Eigen::VectorXd& step) const {
  SceneDraw out = scene;
  double log_sizes = 0;
  Eigen::Index at = 0;
  for (ContactDraw& contact : out) {
    const Freedom free(contact, prior_);
    contact.centre.x() += step[at++];
    contact.centre.y() += step[at++];
    if (free.size) {
      log_sizes += step[at];
      contact.size *= std::exp(step[at++]);
    }
    if (free.ratio) contact.conductivity_ratio += step[at++];
    if (free.aspect) contact.aspect += step[at++];
    if (free.angle) {
      // Angles are in 0 ... pi. Half a turn leaves an ellipse and a rectangle unchanged. It changes
      // a polygon, but the reverse step still leads back.
      contact.angle = std::fmod(contact.angle + step[at++], std::numbers::pi);
      if (contact.angle < 0) contact.angle += std::numbers::pi;
    }
  }
  return {out, log_sizes};
}

}  // namespace ertbench
