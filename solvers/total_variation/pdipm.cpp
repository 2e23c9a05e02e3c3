#include "solvers/total_variation/pdipm.h"

#include <map>
#include <nlohmann/json.hpp>

#include "core/statistics.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

/// The alpha at which a total variation of |changes| / |J| weighs as much as the data: a scale of
/// alpha for these frames that does not depend on units.
double scale_of_alpha(const TotalVariation& problem, const Frames& changes) {
  std::vector<double> sizes;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    sizes.push_back(problem.project(changes.row(f)).norm());
  }
  return upper_median(sizes) * problem.scale() / problem.edge_length();
}

/// The problem without some electrodes, with its minimiser.
struct MaskedProblem {
  MaskedProblem(const TotalVariation& whole, const Sensor& sensor, ElectrodeSet masked)
      : problem(whole, sensor, masked), method(problem) {}
  MaskedProblem(const MaskedProblem&) = delete;
  MaskedProblem& operator=(const MaskedProblem&) = delete;

  TotalVariation problem;
  InteriorPoint method;
};

}  // namespace

Pdipm::Pdipm(JsonObject parameters) { read(std::move(parameters)); }

void Pdipm::read(JsonObject parameters) {
  alpha_ = read_weight(parameters, "alpha");
  options_.tolerance = parameters.number_or("tolerance", 1e-4, {1e-8, 0.1});
  options_.max_iterations = parameters.integer_or("max_iterations", 50, 1, 1000);
  options_.alpha = alpha_.value.value_or(0);
  read_chosen(parameters, alpha_);
  mask_ = ChannelMask::from_json(parameters);
  parameters.finish();
}

nlohmann::json Pdipm::parameters() const {
  nlohmann::json out = {{"tolerance", options_.tolerance},
                        {"max_iterations", options_.max_iterations}};
  alpha_.add_to(out, "alpha");
  mask_.add_to(out);
  return out;
}

void Pdipm::fit(const FitInput& input) {
  set_sensor(input.sensor);
  if (alpha_.automatic()) choose_alpha(input);
}

void Pdipm::set_sensor(const Sensor& sensor) {
  sensor_ = sensor;
  idle_.clear();
  problem_ = std::make_unique<TotalVariation>(sensor);
  if (mask_.electrodes != 0) {
    problem_ = std::make_unique<TotalVariation>(*problem_, sensor, mask_.electrodes);
  }
}

void Pdipm::choose_alpha(const FitInput& input) {
  const ValidationFrames frames = read_validation_frames(input, alpha_.place);
  const double scale = scale_of_alpha(*problem_, frames.changes);
  alpha_.choose(*this, frames, input.threads, {1e-6 * scale, 1e-2 * scale}, 2,
                [&](double alpha) { options_.alpha = alpha; });
  options_.alpha = *alpha_.value;
}

void Pdipm::reconstruct(FramesView changes, ImagesView images,
                        std::span<FrameReport> reports) const {
  std::unique_ptr<InteriorPoint> method;
  {
    const std::lock_guard lock(idle_mutex_);
    if (!idle_.empty()) {
      method = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!method) method = std::make_unique<InteriorPoint>(*problem_);
  std::map<ElectrodeSet, MaskedProblem> masked;  // by set of dead electrodes
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    FrameReport& report = reports[static_cast<std::size_t>(f)];
    const ElectrodeSet dead = report.dead;
    if (dead == 0) {
      method->minimise(changes.row(f), options_, images.row(f), report);
    } else if (pairs_without(sensor_, dead).empty()) {
      images.row(f).setZero();
    } else {
      const auto found = masked.try_emplace(dead, *problem_, sensor_, dead).first;
      found->second.method.minimise(changes.row(f), options_, images.row(f), report);
    }
  }
  const std::lock_guard lock(idle_mutex_);
  idle_.push_back(std::move(method));
}

void Pdipm::save(const std::filesystem::path& file) const {
  create_solver_file(file, type, sensor_, parameters()).close();
}

void Pdipm::load(const std::filesystem::path& file, const Sensor& sensor) {
  read(JsonObject(parameters_of_fit(open_solver_file(file, type, sensor)), file.string(),
                  "/parameters"));
  alpha_.require_chosen();
  set_sensor(sensor);
}

std::vector<SolverType> total_variation_solvers() {
  SolverInfo info;
  info.summary =
      "total variation by a primal-dual interior point method, min 1/2 |J x - dv|^2 + alpha |A "
      "x|_1";
  info.parameters = {
      {"alpha",
       "weight of the total variation, > 0 or \"auto\"; default \"auto\"; V^2 per (S/m "
       "x domain unit)"},
      {"tolerance", "relative duality gap at which a frame is done, 1e-8 ... 0.1; default 1e-4"},
      {"max_iterations",
       "Newton steps after which a frame is given up as not converged, 1 ... 1000; default 50"},
      ChannelMask::parameter()};
  info.make = make_from_json<Pdipm>;
  info.comparison = ImageComparison::duality_gap;
  return {{Pdipm::type, info}};
}

}  // namespace ertbench
