#include "bench/score/contact_rule_choice.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "bench/score/assignment.h"
#include "bench/score/image_contacts.h"
#include "core/statistics.h"
#include "forward/data/dataset_file.h"
#include "solvers/solver.h"

namespace ertbench {
namespace {

/// Least relative improvement of the mean, so that rounding does not decide.
constexpr double kBetter = 1e-9;

/// Images of validation frames, with the true contact positions.
struct ImagesWithTruth {
  Images images;  ///< [frames, pixels] S/m
  std::vector<Eigen::Index> usable;
  std::vector<std::vector<Eigen::Vector2d>> places_mm;  ///< [frames]
};

ImagesWithTruth images_of(const Sensor& sensor, const Solver& solver,
                          const DatasetFile& validation) {
  const auto count = std::min<std::uint64_t>(frames_of_choice, validation.size());
  const Frames changes =
      validation.voltages(0, count).rowwise() - validation.reference_voltages().transpose();
  ImagesWithTruth out;
  out.images.resize(changes.rows(), sensor.pixels());
  std::vector<FrameReport> reports(count);
  solver.reconstruct(changes, out.images, reports);
  for (std::size_t f = 0; f < count; ++f) {
    const auto row = static_cast<Eigen::Index>(f);
    if (reports[f].status == FrameStatus::undefined || !out.images.row(row).allFinite()) continue;
    out.usable.push_back(row);
  }
  for (const Scene& scene : validation.scenes(0, count)) {
    out.places_mm.push_back(true_places_mm(sensor, scene));
  }
  return out;
}

double mean_ospa(const Sensor& sensor, const ContactRule& rule, double cutoff_mm,
                 const ImagesWithTruth& frames, ContactReader& reader) {
  double sum = 0;
  std::vector<FoundContact> found;
  for (const Eigen::Index f : frames.usable) {
    reader.read(rule, frames.images.row(f), found);
    sum += ospa(places_mm(sensor, found), frames.places_mm[static_cast<std::size_t>(f)], cutoff_mm);
  }
  return sum / static_cast<double>(frames.usable.size());
}

/// Floors to try, over the background.
std::vector<double> floors_for(const Sensor& sensor, const ImagesWithTruth& frames) {
  std::vector<double> peaks;
  for (const Eigen::Index f : frames.usable) {
    peaks.push_back(frames.images.row(f).cwiseAbs().maxCoeff() / sensor.background);
  }
  const double high = nearest_rank_quantile(SortedValues(std::move(peaks)), 0.9);
  std::vector<double> floors;
  for (const double part : floors_to_try) floors.push_back(part * high);
  return floors;
}

}  // namespace

ContactRuleChoice choose_contact_rule(const ContactSettings& settings, const Sensor& sensor,
                                      const Solver& solver, const DatasetFile* validation) {
  ContactRuleChoice out{settings.rule(), 0};
  if (!validation || (settings.threshold && settings.floor)) return out;
  const ImagesWithTruth frames = images_of(sensor, solver, *validation);
  if (frames.usable.empty()) return out;
  out.frames = static_cast<int>(frames.usable.size());
  std::vector<double> thresholds(thresholds_to_try.begin(), thresholds_to_try.end());
  if (settings.threshold) thresholds = {*settings.threshold};
  const std::vector<double> floors =
      settings.floor ? std::vector{*settings.floor} : floors_for(sensor, frames);
  const double cutoff = settings.distances(sensor).ospa;
  ContactReader reader(sensor);
  double least = mean_ospa(sensor, out.rule, cutoff, frames, reader);
  ContactRule rule = out.rule;
  for (const double threshold : thresholds) {
    for (const double floor : floors) {
      rule.threshold = threshold;
      rule.floor = floor;
      const double mean = mean_ospa(sensor, rule, cutoff, frames, reader);
      if (mean >= (1 - kBetter) * least) continue;
      least = mean;
      out.rule = rule;
    }
  }
  return out;
}

nlohmann::json to_json(const ContactRuleChoice& choice) {
  return {{"threshold", choice.rule.threshold},
          {"floor", choice.rule.floor},
          {"saddle", choice.rule.saddle},
          {"chosen_on", choice.frames}};
}

}  // namespace ertbench
