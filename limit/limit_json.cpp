#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "bench/record/limit_file.h"
#include "core/build_stamp.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "limit/limit_run.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Frames with fewer effective samples on the sphere are left out of its summary.
constexpr double least_on_sphere = 30;

template <typename Value>
auto column(std::span<const FrameLimit> frames, const Value& value) {
  std::vector<std::decay_t<std::invoke_result_t<Value, const FrameLimit&>>> out;
  for (const FrameLimit& frame : frames) out.push_back(std::invoke(value, frame));
  return out;
}

auto value_of(const std::string& metric, std::optional<double> FrameLimit::Value::*which) {
  return [=](const FrameLimit& frame) -> std::optional<double> {
    const auto found = frame.metrics.find(metric);
    return found == frame.metrics.end() ? std::nullopt : found->second.*which;
  };
}

auto error_of(const std::string& metric) { return value_of(metric, &FrameLimit::Value::error); }

json short_summary(const MetricSummary& summary) {
  json out = {{"mean", or_null(summary.mean)},
              {"ci95", nullptr},
              {"median", or_null(summary.median)},
              {"count", summary.count}};
  if (summary.ci95) out["ci95"] = {summary.ci95->low, summary.ci95->high};
  return out;
}

template <typename Value>
json summary_of(std::span<const FrameLimit> frames, const Value& value, const char* name) {
  return short_summary(summarise(column(frames, value), name));
}

/// The upper tail of the chi square distribution: Q(a, x/2) with a = degrees / 2, by the series of
/// the lower incomplete gamma function.
double chi_square_tail(double x, int degrees) {
  const double a = degrees / 2.0;
  const double z = x / 2;
  if (z <= 0) return 1;
  double term = 1 / a;
  double sum = term;
  for (int n = 1; n < 1000 && term > 1e-15 * sum; ++n) {
    term *= z / (a + n);
    sum += term;
  }
  return std::clamp(1 - sum * std::exp(-z + a * std::log(z) - std::lgamma(a)), 0.0, 1.0);
}

json json_of(const LimitCalibration& calibration) {
  return {{"squared_error_over_variance", calibration.squared_error_over_variance},
          {"ci95", {calibration.ci95.low, calibration.ci95.high}}};
}

json set_json(const SetLimit& limit) {
  std::vector<FrameLimit> resolved;
  json unresolved = json::array();
  json per_frame = json::array();
  std::vector<FrameLimit> on_sphere;
  for (const FrameLimit& frame : limit.frames) {
    if (frame.resolved) resolved.push_back(frame);
    if (!frame.resolved) unresolved.push_back(frame.frame);
    if (frame.sphere_relative_error && frame.sphere_effective >= least_on_sphere) {
      on_sphere.push_back(frame);
    }
    per_frame.push_back(to_json(frame));
  }
  json out = {
      {"dataset", limit.dataset},      {"prior", limit.prior},
      {"model", limit.model},          {"sampler", distinct(limit.frames, &FrameLimit::sampler)},
      {"frames", limit.frames.size()}, {"unresolved", unresolved}};
  for (const char* metric : limit_metrics) {
    out["all_frames"][metric] = summary_of(limit.frames, error_of(metric), metric);
    out["resolved"][metric] = summary_of(resolved, error_of(metric), metric);
    out["expected"][metric] =
        summary_of(limit.frames, value_of(metric, &FrameLimit::Value::expected), metric);
  }
  out["relative_error_of_mean"] = summary_of(
      limit.frames,
      [](const FrameLimit& f) -> std::optional<double> {
        if (f.metrics.count("relative_error") == 0) return std::nullopt;
        return f.relative_error_of_mean;
      },
      "relative_error_of_mean");
  out["sphere"] = {
      {"width", sphere_width},
      {"relative_error", summary_of(on_sphere, &FrameLimit::sphere_relative_error, "sphere")},
      {"without", summary_of(on_sphere, error_of("relative_error"), "relative_error")}};
  const LimitCalibration calibration = calibration_of(limit.frames);
  json& shown = out["calibration"];
  shown = json_of(calibration);
  for (std::size_t r = 0; r < limit_ranks.size(); ++r) {
    shown["rank_p_values"][limit_ranks[r]] = or_null(calibration.p_values[r]);
  }
  out["per_frame"] = per_frame;
  return out;
}

}  // namespace

ResultRow row_of(const SetLimit& limit) {
  ResultRow row;
  row.label = row.type = row.family = "limit-" + limit.prior;
  row.dataset = limit.dataset;
  row.frames = static_cast<int>(limit.frames.size());
  for (const char* name : limit_metrics) {
    row.metrics[metric_from_name(name)] = summarise(column(limit.frames, error_of(name)), name);
  }
  json unresolved = json::array();
  for (const FrameLimit& frame : limit.frames) {
    if (!frame.resolved) unresolved.push_back(frame.frame);
  }
  row.frames_not_converged = static_cast<int>(unresolved.size());
  json parameters = {{"set", limit.key},
                     {"prior", limit.prior},
                     {"model", limit.model},
                     {"unresolved", unresolved}};
  if (row.type == limit_lower) {
    const auto part = ratio_of_sums(column(limit.frames, &FrameLimit::variance),
                                    column(limit.frames, &FrameLimit::energy), "squared error");
    parameters["squared_error"] = {{"over_empty", part->ratio},
                                   {"ci95", {part->ci95.low, part->ci95.high}}};
  } else {
    parameters["calibration"] = json_of(calibration_of(limit.frames));
  }
  row.parameters = parameters;
  row.build.scored = distinct(limit.frames, &FrameLimit::build);
  return row;
}

bool is_ranked(std::span<const FrameLimit> frames, std::size_t rank) {
  for (std::size_t other = 0; other < limit_ranks.size(); ++other) {
    const bool same = std::ranges::all_of(frames, [&](const FrameLimit& frame) {
      return std::abs(frame.ranks[rank] - frame.ranks[other]) < 1e-12;
    });
    if (other != rank && same) return false;
  }
  return true;
}

std::array<double, rank_bins> rank_counts(std::span<const FrameLimit> frames, std::size_t rank) {
  std::array<double, rank_bins> counts{};
  for (const FrameLimit& frame : frames) {
    const double bin = std::clamp(frame.ranks[rank] * rank_bins, 0.0, rank_bins - 1e-9);
    counts[static_cast<std::size_t>(bin)] += 1;
  }
  return counts;
}

LimitCalibration calibration_of(std::span<const FrameLimit> frames) {
  LimitCalibration out;
  // If every frame determines its scene there is neither error nor variance.
  const auto found = ratio_of_sums(column(frames, &FrameLimit::squared_error),
                                   column(frames, &FrameLimit::variance), "calibration");
  out.squared_error_over_variance = found ? found->ratio : 1;
  out.ci95 = found ? found->ci95 : Interval{1, 1};
  for (std::size_t r = 0; r < limit_ranks.size(); ++r) {
    const double wanted = static_cast<double>(frames.size()) / rank_bins;
    if (wanted < 2 || !is_ranked(frames, r)) continue;
    double chi_square = 0;
    for (const double count : rank_counts(frames, r))
      chi_square += (count - wanted) * (count - wanted) / wanted;
    out.p_values[r] = chi_square_tail(chi_square, rank_bins - 1);
  }
  return out;
}

json with_others(json now, const json& before) {
  const auto add = [&](const char* list, const char* first, const char* second) {
    for (const json& old : before.at(list)) {
      const json& all = now[list];
      const bool replaced = std::ranges::any_of(all, [&](const json& one) {
        return one.at(first) == old.at(first) && one.at(second) == old.at(second);
      });
      if (!replaced) now[list].push_back(old);
    }
  };
  add("rows", "dataset", "type");
  add("sets", "dataset", "prior");
  return now;
}

std::vector<ResultRow> finished_limits(const std::filesystem::path& folder,
                                       const Experiment& experiment, const LimitOptions& options) {
  if (options.sampler != SamplerKind::automatic) return {};
  const LimitSets sets{experiment.tests, experiment.training ? &*experiment.training : nullptr};
  std::vector<ResultRow> usable;
  add_limit_rows(folder, sets, Reuse::same_code, usable);
  std::vector<ResultRow> out;
  for (const DatasetSpec& test : experiment.tests) {
    const auto& wanted = options.datasets;
    if (!wanted.empty() && !contains(wanted, test.name)) continue;
    if (!why_no_limit(test).empty()) continue;
    const auto frames = static_cast<int>(
        std::min<std::uint64_t>(test.count, static_cast<std::uint64_t>(options.frames)));
    std::vector<std::string> types = {options.lower ? limit_lower : limit_oracle};
    if (!options.lower && options.fair && sets.training) types.emplace_back(limit_fair);
    for (const std::string& type : types) {
      const auto found = std::ranges::find_if(usable, [&](const ResultRow& row) {
        return row.dataset == test.name && row.type == type && row.frames == frames;
      });
      if (found == usable.end()) return {};
      out.push_back(*found);
    }
  }
  return out;
}

json limit_json(const std::string& experiment, std::span<const SetLimit> limits) {
  json out = {{"schema", 1}, {"experiment", experiment}, {"build", to_json(stamp_of_this_build())}};
  for (const SetLimit& limit : limits) {
    out["rows"].push_back(to_json(row_of(limit)));
    out["sets"].push_back(set_json(limit));
  }
  return out;
}

}  // namespace ertbench
