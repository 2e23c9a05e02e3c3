#include "bench/studies/collision_figure.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/plot/drawing.h"
#include "bench/studies/collision_pair.h"
#include "core/quantile.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr LineStyle aimed_line{ink::dark, 1.2, 2};
constexpr LineStyle limit_of_arm_line{ink::dark, 1.2, 3};
constexpr LineStyle undelayed_line{ink::black, 2.4};

Axis percent_axis(std::string title) {
  Axis axis{-2, 103, false, {}, std::move(title)};
  for (int percent = 0; percent <= 100; percent += 20) {
    axis.ticks.push_back({double(percent), std::to_string(percent)});
  }
  return axis;
}

std::string percent_text(const CountedShare& share) {
  return std::to_string(share.count) + " of " + std::to_string(share.total) + " found";
}

void draw_force_figure(const CollisionResults& results, const std::string& title,
                       const std::filesystem::path& stem) {
  Span forces;
  for (const Detector& detector : results.detectors) {
    for (const ShareBin& bin : detector.by_force) forces.extend(bin.mean);
  }
  if (forces.empty()) throw std::invalid_argument("no press was read");
  forces = {forces.low / 1.15, forces.high * 1.15};
  CollisionPair pair(results,
                     {Axis::logarithms(forces, "force (N)"), percent_axis("presses found (%)")});
  pair.explain("95 %; whiskers: 95 % intervals", aimed_line);
  pair.draw(
      title + ": presses found, " + results.condition,
      [](Panel& panel) { panel.level(95, aimed_line); },
      [](Panel& panel, const Detector& detector, const DetectorStyle& style, double place) {
        Points points;
        std::vector<Whisker> whiskers;
        for (const ShareBin& bin : detector.by_force) {
          const auto share = bin.successes.share();
          if (!share) continue;
          const double x = bin.mean * std::exp(0.05 * place);
          points.emplace_back(x, 100 * share->value);
          whiskers.push_back({x, 100 * share->ci95.low, 100 * share->ci95.high});
          panel.tooltip(x, 100 * share->value,
                        detector.name() + "\n" + fixed(bin.low, 2) + " to " + fixed(bin.high, 2) +
                            " N: " + percent_text(bin.successes));
        }
        panel.whiskers(whiskers, {style.line.colour.towards_white(0.6), 0.8});
        panel.line(points, style.line);
        panel.marks(points, style.mark);
      },
      stem);
}

/// Where a count of false alarms stands on a logarithmic axis, on which none is left of one.
double alarms_place(const FalseAlarms& quiet) {
  return std::max(quiet.per_hour(), 0.4 / quiet.hours);
}

void draw_curve_figure(const CollisionResults& results, const std::string& title,
                       const std::filesystem::path& stem) {
  Span rates;
  rates.extend(results.per_hour);
  double none = 0;  // where no alarm at all is drawn
  for (const Detector& detector : results.detectors) {
    for (const OperatingPoint& point : detector.curve) {
      rates.extend(alarms_place(point.quiet));
      none = alarms_place({0, point.quiet.hours});
    }
  }
  if (!results.reference || none == 0) throw std::invalid_argument("no press was read");
  Axis x =
      Axis::logarithms({std::min(rates.low, none) / 1.5, rates.high * 1.5}, "false alarms an hour");
  std::erase_if(x.ticks, [&](const Tick& tick) { return tick.value < 2 * none; });
  x.ticks.insert(x.ticks.begin(), {none, "none"});
  CollisionPair pair(results, {x, percent_axis("presses found (%)")});
  pair.explain(number_text(results.per_hour) + " an hour; ringed: as fitted", aimed_line);
  const ShareBin* bin = nullptr;
  for (const Detector& detector : results.detectors) {
    if (detector.failure.empty()) bin = &detector.by_force[*results.reference];
  }
  pair.draw(
      title + ": presses of " + fixed(bin->low, 2) + " to " + fixed(bin->high, 2) + " N, " +
          results.condition,
      [&](Panel& panel) {
        panel.line({{results.per_hour, -2}, {results.per_hour, 103}}, aimed_line);
      },
      [](Panel& panel, const Detector& detector, const DetectorStyle& style, double) {
        Points points;
        Points fitted;
        for (const OperatingPoint& point : detector.curve) {
          const double place = alarms_place(point.quiet);
          const double found = 100.0 * point.found.count / std::max(point.found.total, 1);
          points.emplace_back(place, found);
          if (point.factor == 1) fitted.emplace_back(place, found);
          panel.tooltip(place, found,
                        detector.name() + "\nthreshold × " + fixed(point.factor, 2) + ": " +
                            three_digits(point.quiet.per_hour()) + " false alarms an hour, " +
                            percent_text(point.found));
        }
        panel.line(points, style.line);
        panel.marks(fitted, style.mark);
        panel.marks(fitted, {circle, style.mark.colour, 1.7, 1.4});
      },
      stem);
}

/// Runs of about the same speed: medians of speed and peak force, 5 and 95 % of the latter.
struct SpeedBin {
  double speed_m_s;
  double low_N, median_N, high_N;
};

std::vector<SpeedBin> speed_bins(const ArmOutcome& arm, double limit_N) {
  constexpr std::size_t most = 8;
  constexpr std::size_t least_runs = 10;
  std::vector<std::pair<double, double>> runs;  // speed, peak force
  for (const ArmRun& run : arm.runs) {
    if (run.needless_stop) continue;
    runs.emplace_back(run.truth.speed_m_s, std::min(run.peak_N.value_or(limit_N), limit_N));
  }
  std::sort(runs.begin(), runs.end());
  const std::size_t count = std::clamp<std::size_t>(runs.size() / least_runs, 1, most);
  std::vector<SpeedBin> bins;
  for (std::size_t b = 0; b < count && !runs.empty(); ++b) {
    const std::size_t first = b * runs.size() / count;
    const std::size_t end = (b + 1) * runs.size() / count;
    std::vector<double> speeds;
    std::vector<double> peaks;
    for (std::size_t r = first; r < end; ++r) {
      speeds.push_back(runs[r].first);
      peaks.push_back(runs[r].second);
    }
    const SortedValues sorted = peaks;
    bins.push_back({median(speeds), interpolated_quantile(sorted, 0.05), median(sorted),
                    interpolated_quantile(sorted, 0.95)});
  }
  return bins;
}

void draw_arm_figure(const CollisionResults& results, const std::string& title,
                     const std::filesystem::path& stem) {
  Span speeds;
  for (const ArmRun& run : results.undelayed.runs) speeds.extend(run.truth.speed_m_s);
  if (speeds.empty()) throw std::invalid_argument("no arm ran into anything");
  speeds = {speeds.low / 1.15, speeds.high * 1.15};
  Span forces;
  forces.extend(results.arm.aim_N);
  forces.extend(results.arm.limit_N);
  forces.extend(results.arm.peak_force_N(speeds.low, 0));
  forces.extend(results.arm.peak_force_N(speeds.high, 0));
  Axis y = Axis::logarithms({forces.low / 1.3, forces.high * 1.25}, "peak force (N)");
  CollisionPair pair(results, {Axis::logarithms(speeds, "speed (m/s)"), y});
  pair.explain("no delay: no skin does better", undelayed_line);
  pair.explain("aim, " + number_text(results.arm.aim_N) + " N", aimed_line);
  pair.explain("limit, " + number_text(results.arm.limit_N) + " N, or more", limit_of_arm_line);
  pair.explain("whiskers: 5 to 95 % of the runs", std::nullopt);
  pair.draw(
      title + ": median peak force, " + results.condition,
      [&](Panel& panel) {
        Points bound;  // a straight line between logarithmic axes
        for (const double speed : {speeds.low, speeds.high}) {
          bound.emplace_back(speed, results.arm.peak_force_N(speed, 0));
        }
        panel.line(bound, undelayed_line);
        panel.level(results.arm.aim_N, aimed_line);
        panel.level(results.arm.limit_N, limit_of_arm_line);
      },
      [&](Panel& panel, const Detector& detector, const DetectorStyle& style, double place) {
        Points points;
        std::vector<Whisker> whiskers;
        for (const SpeedBin& bin : speed_bins(detector.arm, results.arm.limit_N)) {
          const double x = bin.speed_m_s * std::exp(0.04 * place);
          points.emplace_back(x, y.capped(bin.median_N));
          whiskers.push_back({x, y.capped(bin.low_N), y.capped(bin.high_N)});
          panel.tooltip(x, y.capped(bin.median_N),
                        detector.name() + "\n" + fixed(bin.speed_m_s, 3) + " m/s: median " +
                            fixed(bin.median_N, 1) + " N, 5 to 95 % " + fixed(bin.low_N, 1) +
                            " to " + fixed(bin.high_N, 1) + " N");
        }
        panel.whiskers(whiskers, {style.line.colour.towards_white(0.6), 0.8});
        panel.line(points, style.line);
        panel.marks(points, style.mark);
      },
      stem);
}

}  // namespace

std::vector<ReportFigure> collision_figures(const CollisionResults& results,
                                            const std::string& title,
                                            const std::filesystem::path& stem) {
  std::vector<ReportFigure> figures;
  const auto add = [&](const std::string& part, const std::string& heading,
                       const std::string& caption, const auto& draw) {
    const std::string file = stem.string() + part;
    const bool drawn = draw_or_say(file, [&] { draw(results, title, file); });
    figures.push_back({heading, file + ".svg", caption, drawn});
  };
  add("_force", "Presses found against force", results.condition, draw_force_figure);
  add("_curve", "Presses found against false alarms",
      "all thresholds multiplied by a factor; a detector without a ring is in alarm so long that "
      "its "
      "alarms run into each other; " +
          results.condition,
      draw_curve_figure);
  add("_arm", "Peak force on the obstacle against the arm's speed",
      "medians over runs of about the same speed; " + results.condition, draw_arm_figure);
  return figures;
}

}  // namespace ertbench
