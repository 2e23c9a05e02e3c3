#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "bench/studies/collision.h"
#include "bench/studies/drawing.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Axes that both panels of a figure share.
struct PanelAxes {
  Axis x;
  Axis y;
};

/// A detector's look in all figures; both rules of a solver share it.
struct DetectorStyle {
  LineStyle line;
  MarkStyle mark;
};

/// Places and sizes in px.
struct PairLayout {
  static constexpr double left = 62;
  static constexpr double right = 16;
  static constexpr double gap = 66;
  static constexpr double top = 58;
  static constexpr double panel_width = 340;
  static constexpr double height = 260;
  static constexpr double legend_top = top + height + 56;

  static constexpr double width() { return left + 2 * panel_width + gap + right; }
};

std::vector<std::string> solvers_of(const CollisionResults& results) {
  std::vector<std::string> out;
  for (const Detector& detector : results.detectors) {
    if (detector.rule == AlarmRule::one_threshold) out.push_back(detector.label);
  }
  return out;
}

/// Two panels beside each other, alarms by one threshold on the left and those by region on the
/// right, the norm of the voltages in both, and the legend below.
class CollisionPair {
 public:
  /// `results` must outlive this.
  CollisionPair(const CollisionResults& results, PanelAxes axes)
      : results_(results),
        axes_(std::move(axes)),
        solvers_(solvers_of(results)),
        styles_(solvers_),
        legend_(PairLayout::left - 40, PairLayout::width(), 3) {
    for (const Detector& detector : results.detectors) {
      if (detector.rule == AlarmRule::by_region) continue;  // as its other rule
      const DetectorStyle style = style_of(detector);
      if (detector.failure.empty()) {
        legend_.add({detector.label, style.line, style.mark});
      } else {
        legend_.add({detector.label + ": " + detector.failure});
      }
    }
  }

  /// Adds an entry to the legend, behind the detectors.
  void explain(const std::string& text, const LineStyle& line) { legend_.add({text, line}); }

  /// Draws what lies under all detectors.
  using Ground = std::function<void(Panel&)>;
  /// Draws one detector; `place` is where it stands among those of the panel, -0.5 to 0.5, to set
  /// whiskers beside each other.
  using Plot = std::function<void(Panel&, const Detector&, const DetectorStyle&, double place)>;
  void draw(const std::string& title, const Ground& ground, const Plot& plot,
            const std::filesystem::path& stem) const {
    Canvas canvas(PairLayout::width(), PairLayout::legend_top + legend_.height() + 6);
    canvas.title(title);
    for (const AlarmRule rule : {AlarmRule::one_threshold, AlarmRule::by_region}) {
      const bool second = rule == AlarmRule::by_region;
      const double left =
          PairLayout::left + (second ? PairLayout::panel_width + PairLayout::gap : 0);
      Panel panel(canvas,
                  Box::sized(left, PairLayout::top, PairLayout::panel_width, PairLayout::height),
                  axes_.x, axes_.y);
      panel.title(second ? "a threshold for each region" : "one threshold");
      ground(panel);
      const std::vector<const Detector*> detectors = detectors_of(rule);
      for (std::size_t d = 0; d < detectors.size(); ++d) {
        const double place = (static_cast<double>(d) + 0.5) / static_cast<double>(detectors.size());
        plot(panel, *detectors[d], style_of(*detectors[d]), place - 0.5);
      }
      panel.draw();
    }
    legend_.draw(canvas, PairLayout::legend_top);
    canvas.draw(stem);
  }

 private:
  DetectorStyle style_of(const Detector& detector) const {
    if (detector.rule == AlarmRule::voltage_norm) {
      return {{ink::light, 2.2}, {cross, ink::light, 0.8, 2}};
    }
    const auto at = std::find(solvers_.begin(), solvers_.end(), detector.label);
    const auto s = static_cast<std::size_t>(at - solvers_.begin());
    return {styles_.line(s, 1.4), styles_.mark(s, 0.7)};
  }

  /// The detectors that are drawn in the panel of a rule, the lowest first.
  std::vector<const Detector*> detectors_of(AlarmRule rule) const {
    std::vector<const Detector*> out;
    for (const AlarmRule drawn : {AlarmRule::voltage_norm, rule}) {
      for (const Detector& detector : results_.detectors) {
        if (detector.rule == drawn && detector.failure.empty()) out.push_back(&detector);
      }
    }
    return out;
  }

  const CollisionResults& results_;
  PanelAxes axes_;
  std::vector<std::string> solvers_;
  MethodStyles styles_;
  Legend legend_;
};

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
  return std::to_string(share.count) + " of " + std::to_string(share.total) + " detected";
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
                     {Axis::logarithms(forces, "force (N)"), percent_axis("presses detected (%)")});
  pair.explain("95 %; whiskers: 95 % intervals", aimed_line);
  pair.draw(
      title + ": presses detected, " + results.condition,
      [](Panel& panel) { panel.level(95, aimed_line); },
      [](Panel& panel, const Detector& detector, const DetectorStyle& style, double place) {
        Series series;
        for (const ShareBin& bin : detector.by_force) {
          const auto share = bin.successes.share();
          if (!share) continue;
          const double x = bin.mean * std::exp(0.05 * place);
          series.add(x, *scaled(share, 100));
          panel.tooltip(x, 100 * share->value,
                        detector.name() + "\n" + fixed(bin.low, 2) + " to " + fixed(bin.high, 2) +
                            " N: " + percent_text(bin.successes));
        }
        panel.whiskers(series.whiskers, {style.line.colour.towards_white(0.6), 0.8});
        panel.line(series.points, style.line);
        panel.marks(series.points, style.mark);
      },
      stem);
}

/// The place of a number of false alarms on a logarithmic axis, which has none left of one.
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
  CollisionPair pair(results, {x, percent_axis("presses detected (%)")});
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

/// Runs of about the same speed: its median, and the peak force over that of a stop without delay
/// at each run's own speed, median and 5 and 95 %.
struct SpeedBin {
  double speed_m_s;
  double low, median, high;
  double median_N;
};

std::vector<SpeedBin> speed_bins(const ArmOutcome& arm, const ArmSettings& settings) {
  constexpr std::size_t most = 8;
  constexpr std::size_t least_runs = 10;
  std::vector<std::pair<double, double>> runs;  // speed, peak force
  for (const ArmRun& run : arm.runs) {
    if (run.needless_stop) continue;
    const double limit_N = settings.limit_N;
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
    std::vector<double> ratios;
    for (std::size_t r = first; r < end; ++r) {
      const auto& [speed, peak_N] = runs[r];
      speeds.push_back(speed);
      peaks.push_back(peak_N);
      ratios.push_back(peak_N / settings.peak_force_N(speed, 0));
    }
    const SortedValues sorted = ratios;
    bins.push_back({median(speeds), interpolated_quantile(sorted, 0.05), median(sorted),
                    interpolated_quantile(sorted, 0.95), median(peaks)});
  }
  return bins;
}

/// A force over that of a stop without delay, as far as both axes reach.
Points ratio_curve(double force_N, const ArmSettings& arm, const Span& speeds, const Span& ratios) {
  constexpr int steps = 200;
  Points out;
  for (int i = 0; i <= steps; ++i) {
    const double speed = speeds.low * std::pow(speeds.high / speeds.low, double(i) / steps);
    const double ratio = force_N / arm.peak_force_N(speed, 0);
    if (ratio >= ratios.low && ratio <= ratios.high) out.emplace_back(speed, ratio);
  }
  return out;
}

void draw_arm_figure(const CollisionResults& results, const std::string& title,
                     const std::filesystem::path& stem) {
  Span speeds;
  for (const ArmRun& run : results.undelayed.runs) speeds.extend(run.truth.speed_m_s);
  if (speeds.empty()) throw std::invalid_argument("no arm ran into anything");
  speeds = {speeds.low / 1.15, speeds.high * 1.15};
  Span ratios;
  ratios.extend(1);
  for (const Detector& detector : results.detectors) {
    for (const SpeedBin& bin : speed_bins(detector.arm, results.arm)) ratios.extend(bin.median);
  }
  ratios = {0.96 * ratios.low, 1.1 * ratios.high};
  CollisionPair pair(results, {Axis::logarithms(speeds, "speed (m/s)"),
                               Axis::logarithms(ratios, "peak force over that without delay")});
  pair.explain("1: no delay, no skin does better", undelayed_line);
  pair.explain("aim, " + number_text(results.arm.aim_N) + " N", aimed_line);
  pair.explain("limit, " + number_text(results.arm.limit_N) + " N, or more", limit_of_arm_line);
  pair.draw(
      title + ": peak force over that of a stop without delay, medians, " + results.condition,
      [&](Panel& panel) {
        panel.level(1, undelayed_line);
        panel.line(ratio_curve(results.arm.aim_N, results.arm, speeds, ratios), aimed_line);
        panel.line(ratio_curve(results.arm.limit_N, results.arm, speeds, ratios),
                   limit_of_arm_line);
      },
      [&](Panel& panel, const Detector& detector, const DetectorStyle& style, double) {
        Points points;
        for (const SpeedBin& bin : speed_bins(detector.arm, results.arm)) {
          points.emplace_back(bin.speed_m_s, bin.median);
          panel.tooltip(bin.speed_m_s, bin.median,
                        detector.name() + "\n" + fixed(bin.speed_m_s, 3) + " m/s: median " +
                            fixed(bin.median_N, 1) + " N, " + fixed(bin.median, 2) +
                            " times that without delay, 5 to 95 % " + fixed(bin.low, 2) + " to " +
                            fixed(bin.high, 2) + " times");
        }
        panel.line(points, style.line);
        panel.marks(points, style.mark);
      },
      stem);
}

}  // namespace

std::vector<StudyFigure> collision_figures(const std::shared_ptr<const CollisionResults>& results) {
  const auto drawn_by = [&](auto draw) {
    return [results, draw](const std::string& heading, const std::filesystem::path& stem) {
      draw(*results, heading, stem);
    };
  };
  return {{"_force", "Presses detected against force", results->condition, "",
           drawn_by(draw_force_figure)},
          {"_curve", "Presses detected against false alarms",
           "all thresholds multiplied by a factor; a detector without a ring is in alarm so long "
           "that its alarms run into each other; " +
               results->condition,
           "", drawn_by(draw_curve_figure)},
          {"_arm", "Peak force on the obstacle against the arm's speed",
           "over the peak force of a stop without delay at the same speed; medians over runs of "
           "about the same speed; " +
               results->condition,
           "", drawn_by(draw_arm_figure)}};
}

}  // namespace ertbench
