#include "bench/report/differences.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"

namespace ertbench {
namespace {

/// Frames that have the metric in every trial of every label.
std::vector<std::size_t> shared_frames(const std::vector<const FramesOfSeeds*>& labels,
                                       Metric metric) {
  std::vector<std::size_t> out;
  for (std::size_t f = 0; f < labels.front()->front().size(); ++f) {
    const bool all = std::ranges::all_of(labels, [&](const FramesOfSeeds* trials) {
      return std::ranges::all_of(*trials,
                                 [&](const auto& frames) { return frames[f][metric].has_value(); });
    });
    if (all) out.push_back(f);
  }
  return out;
}

Eigen::MatrixXd values_of(const FramesOfSeeds& trials, const std::vector<std::size_t>& frames,
                          Metric metric) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(trials.size()),
                      static_cast<Eigen::Index>(frames.size()));
  for (Eigen::Index s = 0; s < out.rows(); ++s) {
    for (Eigen::Index f = 0; f < out.cols(); ++f) {
      out(s, f) = *trials[static_cast<std::size_t>(s)][frames[static_cast<std::size_t>(f)]][metric];
    }
  }
  return out;
}

/// How far a mean is from the metric's ideal; the less the better.
double badness(const MetricEntry& entry, double mean) {
  if (entry.better == Better::nearer) return std::abs(mean - entry.ideal.value);
  return entry.better == Better::smaller ? mean : -mean;
}

/// Of all frames and seeds that have the metric; nothing where none has.
std::optional<double> mean_of(const FramesOfSeeds& trials, Metric metric) {
  double sum = 0;
  int count = 0;
  for (const auto& frames : trials) {
    for (const FrameMetrics& frame : frames) {
      if (!frame[metric]) continue;
      sum += *frame[metric];
      ++count;
    }
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

/// Of the labels with the metric those that are compared, in their order: the best ones, where
/// there are very many, as the pairs of all would be their square.
std::vector<std::size_t> compared(const ScoredLabels& scored, Metric metric) {
  std::vector<std::size_t> labels;
  std::vector<double> badnesses(scored.labels.size());
  for (std::size_t i = 0; i < scored.labels.size(); ++i) {
    const std::optional<double> mean = mean_of(scored.frames[i], metric);
    if (!mean) continue;
    labels.push_back(i);
    badnesses[i] = badness(entry_of(metric), *mean);
  }
  if (labels.size() <= most_compared_labels) return labels;
  std::ranges::stable_sort(labels, {}, [&](std::size_t i) { return badnesses[i]; });
  labels.resize(most_compared_labels);
  std::ranges::sort(labels);
  return labels;
}

void add_differences(const ScoredLabels& scored, Metric metric, std::vector<MeanDifference>& out) {
  std::vector<const FramesOfSeeds*> trials;
  std::vector<std::string> labels;
  for (const std::size_t i : compared(scored, metric)) {
    trials.push_back(&scored.frames[i]);
    labels.push_back(scored.labels[i]);
  }
  if (trials.size() < 2) return;
  const std::vector<std::size_t> frames = shared_frames(trials, metric);
  if (frames.empty()) return;
  std::vector<Eigen::MatrixXd> samples;
  for (const FramesOfSeeds* one : trials) samples.push_back(values_of(*one, frames, metric));
  const PairedBootstrap bootstrap(samples, scored.dataset + " " + first_name_of(metric));
  for (std::size_t a = 0; a < labels.size(); ++a) {
    for (std::size_t b = a + 1; b < labels.size(); ++b) {
      out.push_back({scored.dataset, metric, labels[a], labels[b], bootstrap.mean(a),
                     bootstrap.mean(b), bootstrap.interval(a, b), static_cast<int>(frames.size())});
    }
  }
}

/// One label among the differences of one metric.
struct Ranked {
  std::string label;
  double mean = 0;
};

std::vector<Ranked> ranked(const std::vector<const MeanDifference*>& pairs) {
  std::vector<Ranked> out;
  const auto add = [&](const std::string& label, double mean) {
    const bool there =
        std::ranges::any_of(out, [&](const Ranked& one) { return one.label == label; });
    if (!there) out.push_back({label, mean});
  };
  for (const MeanDifference* pair : pairs) {
    add(pair->a, pair->mean_a);
    add(pair->b, pair->mean_b);
  }
  const MetricEntry& entry = entry_of(pairs.front()->metric);
  std::ranges::stable_sort(out, [&](const Ranked& x, const Ranked& y) {
    return badness(entry, x.mean) < badness(entry, y.mean);
  });
  return out;
}

/// The difference `label` less `other`, whichever of them the pair names first.
MeanDifference between(const std::vector<const MeanDifference*>& pairs, const std::string& label,
                       const std::string& other) {
  for (const MeanDifference* pair : pairs) {
    if (pair->a == label && pair->b == other) return *pair;
    if (pair->b != label || pair->a != other) continue;
    MeanDifference turned = *pair;
    std::swap(turned.a, turned.b);
    std::swap(turned.mean_a, turned.mean_b);
    turned.ci95 = {-pair->ci95.high, -pair->ci95.low};
    return turned;
  }
  return {};
}

std::string signed_text(double value, int decimals) {
  return (value > 0 ? "+" : "") + fixed(value, decimals);
}

TableSection section_of(const std::vector<const MeanDifference*>& pairs) {
  const MetricEntry& entry = entry_of(pairs.front()->metric);
  const int decimals = entry.decimals + 1;
  TableSection section;
  section.caption = std::string(entry.heading) + ", test set " + pairs.front()->dataset;
  section.columns = {{"from the best", Align::left},
                     {"mean"},
                     {"less the next [95 %]"},
                     {"not resolved from", Align::left}};
  const std::vector<Ranked> labels = ranked(pairs);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::string unresolved;
    for (const Ranked& other : labels) {
      if (other.label == labels[i].label) continue;
      if (between(pairs, labels[i].label, other.label).resolved()) continue;
      unresolved += (unresolved.empty() ? "" : ", ") + other.label;
    }
    Cell next;
    if (i + 1 < labels.size()) {
      const MeanDifference step = between(pairs, labels[i].label, labels[i + 1].label);
      next = signed_text(step.mean_a - step.mean_b, decimals);
      next.interval = interval_text(signed_text(step.ci95.low, decimals),
                                    signed_text(step.ci95.high, decimals));
    }
    section.rows.push_back(
        {labels[i].label, number_cell(labels[i].mean, decimals), next, unresolved});
  }
  section.text = std::to_string(pairs.front()->frames) + " frames that have it in every row.";
  return section;
}

}  // namespace

std::vector<MeanDifference> mean_differences(const ScoredLabels& scored) {
  std::vector<MeanDifference> out;
  for (const MetricEntry& entry : kMetricTable) {
    if (entry.headline) add_differences(scored, entry.distance, out);
  }
  return out;
}

Table difference_table(const std::vector<MeanDifference>& differences) {
  Table table;
  table.title = "Which differences are resolved";
  table.text =
      "Differences between the means of two rows, paired: both are taken on the same frames, so "
      "that what is difficult for all drops out. Intervals are of 95 %, by a bootstrap of two "
      "levels, frames and training seeds. Where an interval holds 0 the order of the two is not "
      "resolved. All pairs are in differences.csv.";
  for (std::size_t i = 0; i < differences.size();) {
    std::vector<const MeanDifference*> pairs;
    const std::size_t first = i;
    for (; i < differences.size() && differences[i].metric == differences[first].metric &&
           differences[i].dataset == differences[first].dataset;
         ++i) {
      pairs.push_back(&differences[i]);
    }
    table.sections.push_back(section_of(pairs));
  }
  return table;
}

TableSection difference_data(const std::vector<MeanDifference>& differences) {
  TableSection section;
  section.columns = {"dataset", "metric", "a",    "b",        "mean_a",
                     "mean_b",  "low",    "high", "resolved", "frames"};
  for (const MeanDifference& one : differences) {
    section.rows.push_back({one.dataset, name_of(one.metric), one.a, one.b, exact_cell(one.mean_a),
                            exact_cell(one.mean_b), exact_cell(one.ci95.low),
                            exact_cell(one.ci95.high), one.resolved() ? "yes" : "no",
                            std::to_string(one.frames)});
  }
  return section;
}

}  // namespace ertbench
