#include "frames/frame_bounds.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/kept.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/border/border_model.h"
#include "forward/sheet/sensor_json.h"
#include "solvers/channel_mask.h"

namespace ertbench {
namespace {

constexpr int places_across = 9;
constexpr double insulating_radii[] = {0.2, 0.4, 0.6};  ///< of the sheet's inner radius
constexpr double conducting_radii[] = {0.2, 0.4, 0.6, 0.8};
constexpr double insulator = 1e-4;  ///< conductivity ratios
constexpr double conductor = 1e3;
constexpr double bound_resolution = 0.7;
constexpr double margin = 1.5;            ///< of the levels over the discs' extremes
constexpr double change_margin = 3;       // several contacts, closer to electrodes
constexpr double surely_possible = 0.25;  ///< a relative change that needs no closer look
constexpr double least_counted = 0.1;     ///< share of the channels without dead electrodes
constexpr double least_even = 0.05;       ///< change of the level that must have a cause
/// Median distance of the channels' ratios from the level, over the level's own distance from 1: of
/// contacts 0.2 and more, of a cup in a tank that changes the level as well.
constexpr double even_spread = 0.15;
constexpr double same_value = 1e-6;           ///< relative
constexpr double least_explained = 0.75;      ///< share of a change that contacts must explain
constexpr double one_channels_rest = 0.4;     ///< share of what they do not explain
constexpr double one_channels_change = 2e-3;  ///< of the reference's norm
constexpr double one_channels_share = 0.15;   ///< of the change's norm
constexpr double reads_zero = 0.02;           ///< of the reference; next to a conductor it is more
constexpr double coarse = 2e-3;  ///< rounding errors' norm relative to the reference's, 54 dB
constexpr double same_step = 0.01;
constexpr Eigen::Index few_channels = 32;  ///< that tell most unrounded frames
constexpr double above_rounding = 3;       ///< a change's norm over that of the rounding errors

/// The value that half of the weight does not exceed; `values` are pairs of value and weight.
double weighted_median(std::vector<std::pair<double, double>>& values) {
  std::ranges::sort(values);
  double total = 0;
  for (const auto& [value, weight] : values) total += weight;
  double sum = 0;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= total / 2) return value;
  }
  return 0;
}

/// The step of which all values are multiples, if that is `least` or more, otherwise 0.
double step_of(const Eigen::Ref<const Eigen::RowVectorXd>& values, double least) {
  std::vector<double> sorted{0};
  for (const double v : values) sorted.push_back(std::abs(v));
  std::ranges::sort(sorted);
  double step = sorted.back();
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i] - sorted[i - 1];
    if (gap > same_value * sorted.back()) step = std::min(step, gap);
    if (step < least) return 0;
  }
  const auto is_multiple = [&](double v) {
    return std::abs(v / step - std::round(v / step)) < same_step;
  };
  return std::ranges::all_of(sorted, is_multiple) ? step : 0;
}

}  // namespace

std::string FrameVerdict::text() const {
  std::string out;
  const auto add = [&](const std::string& part) { out += (out.empty() ? "" : "; ") + part; };
  if (electrode >= 0) {
    add("its electrode " + std::to_string(electrode) + " (from 0) reads zero");
  } else if ((faults & dead_electrode) != 0) {
    add("an electrode reads zero in the reference");
  }
  if ((faults & wrong_reference) != 0) add("its own reference is unlike those of other frames");
  if ((faults & turned_sign) != 0) add("its voltages have the opposite sign of the reference's");
  if (even) {
    add("all its voltages are " + number_text(level) +
        " times the reference's: another gain or current, or the whole sheet has changed");
  } else if ((faults & wrong_level) != 0) {
    const double size = std::abs(level);
    const bool thousands = std::abs(std::abs(std::log10(size)) - 3) < 0.5;
    add("its level is " + number_text(level) + " times the reference's" +
        (thousands ? size > 1 ? " (millivolts for volts?)" : " (volts for millivolts?)" : ""));
  }
  if ((faults & impossible_change) != 0) {
    add("its change is " + number_text(change) +
        " times the reference, more than any contact on this sheet causes");
  }
  if ((faults & unexplained) != 0) {
    add(step > 0 ? "its voltages are rounded to " + number_text(step) +
                       " V, about as much as they change"
        : channel < 0 ? "contacts on this sheet do not explain its change"
                      : "its channel " + std::to_string(channel) + " does not fit the others");
  }
  return out;
}

FrameBounds::FrameBounds(const Sensor& sensor)
    : electrodes_(electrode_sets_of_channels(sensor)), span_(sensor) {
  const Eigen::MatrixXd extremes = kept_matrix("frame-bounds", to_json(sensor).dump(), [&] {
    find_extremes(sensor);
    return Eigen::MatrixXd(Eigen::RowVector3d(least_level_, most_level_, most_change_));
  });
  least_level_ = std::max(0.0, extremes(0, 0)) / margin;
  most_level_ = margin * extremes(0, 1);
  most_change_ = change_margin * extremes(0, 2);
}

void FrameBounds::find_extremes(const Sensor& sensor) {
  const BorderModel model(sensor);
  const Eigen::RowVectorXd reference = model.reference_voltages().transpose();
  const double inner = sensor.sheet->inner_radius();
  const auto take = [&](const Eigen::Vector2d& centre, double radius, double ratio) {
    if (sensor.sheet->depth(centre) < 1.02 * radius) return;
    Contact disc;
    disc.centre = centre;
    disc.half_size.setConstant(radius);
    disc.conductivity_ratio = ratio;
    const Eigen::RowVectorXd change = model.solve_at({{disc}}, bound_resolution).change.transpose();
    const FrameVerdict verdict = judge(change, reference);
    least_level_ = std::min(least_level_, verdict.level);
    most_level_ = std::max(most_level_, verdict.level);
    most_change_ = std::max(most_change_, verdict.change);
  };
  const PixelGrid places(sensor.sheet->bounds(), places_across, places_across);
  for (int p = 0; p < places.count(); ++p) {
    for (const double r : insulating_radii) take(places.centre(p), r * inner, insulator);
    for (const double r : conducting_radii) take(places.centre(p), r * inner, conductor);
  }
}

void FrameBounds::judge_levels(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                               const Eigen::Ref<const Eigen::RowVectorXd>& reference,
                               const FrameReport& said, FrameVerdict& verdict) const {
  const auto channels = static_cast<std::size_t>(change.size());
  const auto live = [&](std::size_t c) { return (electrodes_[c] & said.dead) == 0; };
  std::size_t counted = 0;
  for (std::size_t c = 0; c < channels; ++c) counted += live(c);
  const bool all = static_cast<double>(counted) < least_counted * static_cast<double>(channels);
  std::vector<std::pair<double, double>> ratios;
  double squares = 0;
  double changes = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    if (!all && !live(c)) continue;
    changes += change[i] * change[i];
    squares += reference[i] * reference[i];
    if (reference[i] == 0) continue;
    ratios.emplace_back(1 + change[i] / reference[i], std::abs(reference[i]));
  }
  const bool surely = squares > 0 && verdict.change < surely_possible;
  verdict.level = weighted_median(ratios);
  verdict.change = squares > 0 ? std::sqrt(changes / squares) : 0;
  if (squares == 0) verdict.faults = wrong_reference;
  if (!surely && verdict.level < 0) verdict.faults |= turned_sign;
  const double level = std::abs(verdict.level);
  const bool far = squares > 0 && (level < least_level_ || level > most_level_);
  if (!surely && far) verdict.faults |= wrong_level;
  if (verdict.faults != 0) return;
  const Eigen::RowVectorXd voltages = reference + change;
  if (voltages.maxCoeff() - voltages.minCoeff() <= same_value * voltages.cwiseAbs().maxCoeff()) {
    verdict.faults = unexplained;  // all channels have one value
    return;
  }
  for (auto& [ratio, weight] : ratios) ratio = std::abs(ratio - verdict.level);
  verdict.even = std::abs(verdict.level * (1 + said.level) - 1) > least_even &&
                 weighted_median(ratios) < even_spread * std::abs(verdict.level - 1);
  if (verdict.even) verdict.faults = wrong_level;
  if (!verdict.even && verdict.change > most_change_) verdict.faults = impossible_change;
}

void FrameBounds::judge_rest(const Eigen::Ref<const Eigen::RowVectorXd>& change, double size,
                             FrameVerdict& verdict) const {
  const Eigen::RowVectorXd rest = span_.rest(change);
  const double outside = rest.squaredNorm();
  Eigen::Index channel = 0;
  const double largest = rest.cwiseAbs().maxCoeff(&channel);
  // In noise no channel has so much of it, and contacts leave a seventh of the change at most. By
  // reciprocity half of a fault stands in the channel itself.
  if (largest * largest > one_channels_rest * outside && largest > one_channels_change * size &&
      largest > one_channels_share * change.norm()) {
    verdict.channel = static_cast<int>(channel);
    verdict.faults = unexplained;
  } else if (outside > std::pow(2 * noise_ * size, 2) &&
             outside > (1 - least_explained) * change.squaredNorm()) {
    verdict.faults = unexplained;
  }
}

void FrameBounds::judge_rounding(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                 const Eigen::Ref<const Eigen::RowVectorXd>& reference,
                                 FrameVerdict& verdict) const {
  const double error_of_step = std::sqrt(static_cast<double>(change.size()) / 12);
  const double least = coarse * reference.norm() / error_of_step;
  double step = 0;
  for (const Eigen::Index count : {std::min(few_channels, change.size()), change.size()}) {
    step = step_of((reference + change).head(count), least);
    if (step == 0) return;
  }
  if (change.norm() > above_rounding * error_of_step * step) return;
  verdict.step = step;
  verdict.faults = unexplained;
}

void FrameBounds::judge_electrodes(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& reference,
                                   ElectrodeSet known, FrameVerdict& verdict) const {
  std::array<double, 64> usual{}, here{};
  for (Eigen::Index c = 0; c < change.size(); ++c) {
    for (ElectrodeSet set = electrodes_[static_cast<std::size_t>(c)]; set != 0; set &= set - 1) {
      const auto e = static_cast<std::size_t>(std::countr_zero(set));
      usual[e] += std::abs(reference[c]);
      here[e] += std::abs(reference[c] + change[c]);
    }
  }
  double least = reads_zero;
  for (std::size_t e = 0; e < usual.size(); ++e) {
    if ((known >> e & 1) != 0 || here[e] >= least * usual[e]) continue;
    least = here[e] / usual[e];
    verdict.electrode = static_cast<int>(e);
    verdict.faults |= dead_electrode;
  }
}

void FrameBounds::set_dead(const std::vector<int>& electrodes) {
  dead_ = 0;
  for (const int e : electrodes) dead_ |= ElectrodeSet{1} << e;
}

FrameVerdict FrameBounds::judge(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                const Eigen::Ref<const Eigen::RowVectorXd>& reference,
                                const FrameReport& said) const {
  FrameVerdict verdict;
  if (!change.allFinite()) return verdict;  // undefined anyway
  const double size = reference.norm();
  const double gain = size > 0 ? change.dot(reference) / (size * size) : 0;
  verdict.change = size > 0 ? change.norm() / size : 0;
  verdict.level = 1 + gain;
  if (size == 0 || verdict.change >= surely_possible || std::abs(gain) > least_even / 2) {
    judge_levels(change, reference, said, verdict);
  }
  if ((dead_ & ~said.dead) != 0) verdict.faults |= dead_electrode;
  if (verdict.faults == 0) judge_electrodes(change, reference, said.dead | dead_, verdict);
  if (verdict.faults == 0) judge_rounding(change, reference, verdict);
  if (verdict.faults == 0 && said.dead == 0 && verdict.change > one_channels_change) {
    judge_rest(change, size, verdict);
  }
  return verdict;
}

Eigen::RowVectorXd median_of_rows(const Frames& frames) {
  Eigen::RowVectorXd out(frames.cols());
  for (Eigen::Index c = 0; c < frames.cols(); ++c) {
    const Eigen::VectorXd column = frames.col(c);
    out[c] = median(std::vector<double>(column.begin(), column.end()));
  }
  return out;
}

std::vector<FrameVerdict> FrameBounds::judge_references(const Frames& references) const {
  const Eigen::RowVectorXd usual = median_of_rows(references);
  std::vector<FrameVerdict> out;
  for (const auto& row : references.rowwise()) {
    out.push_back(judge(row - usual, usual));
    if (out.back().even) out.back().faults = 0;  // references of frames are there to follow a drift
  }
  return out;
}

void report(const FrameVerdict& verdict, FrameReport& report) {
  report.reasons |= verdict.faults;
  if (verdict.faults != 0 && report.status != FrameStatus::undefined) {
    report.status = FrameStatus::suspect;
  }
}

}  // namespace ertbench
