#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/studies/collision.h"
#include "bench/studies/drawing.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Places and sizes in px.
constexpr double left = 62;
constexpr double between = 66;  ///< the two panels
constexpr double top = 58;
constexpr double panel_width = 340;
constexpr double panel_height = 260;
constexpr double legend_top = top + panel_height + 56;
constexpr double picture_width = left + 2 * panel_width + between + 16;

constexpr LineStyle aimed_line{ink::dark, 1.2, 2};
constexpr LineStyle limit_of_arm_line{ink::dark, 1.2, 3};
constexpr LineStyle undelayed_line{ink::black, 2.4};

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
  std::ranges::sort(runs);
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

std::vector<std::string> solvers_of(const CollisionResults& results) {
  std::vector<std::string> out;
  for (const Detector& detector : results.detectors) {
    if (detector.rule == AlarmRule::one_threshold) out.push_back(detector.label);
  }
  return out;
}

/// The peak force over that of a stop without delay against the speed. Two panels beside each
/// other, alarms by one threshold on the left and those by region on the right, the norm of the
/// voltages in both, and the legend below.
class ArmDrawing {
 public:
  /// `results` must outlive this.
  explicit ArmDrawing(const CollisionResults& results)
      : results_(results), solvers_(solvers_of(results)), styles_(solvers_) {
    for (const ArmRun& run : results.undelayed.runs) speeds_.extend(run.truth.speed_m_s);
    if (speeds_.empty()) throw std::invalid_argument("no arm ran into anything");
    speeds_ = {speeds_.low / 1.15, speeds_.high * 1.15};
    ratios_.extend(1);
    for (const Detector& detector : results.detectors) {
      for (const SpeedBin& bin : speed_bins(detector.arm, results.arm)) ratios_.extend(bin.median);
    }
    ratios_ = {0.96 * ratios_.low, 1.1 * ratios_.high};
  }

  void draw(const std::string& title, const std::filesystem::path& stem) const {
    const Legend legend = this->legend();
    Canvas canvas(picture_width, legend_top + legend.height() + 6);
    canvas.title(title);
    draw_panel(canvas, left, AlarmRule::one_threshold, "one threshold");
    draw_panel(canvas, left + panel_width + between, AlarmRule::by_region,
               "a threshold for each region");
    legend.draw(canvas, legend_top);
    canvas.draw(stem);
  }

 private:
  /// Both rules of a solver look alike.
  LineStyle line_of(const Detector& detector) const {
    if (detector.rule == AlarmRule::voltage_norm) return {ink::light, 2.2};
    return styles_.line(number_of(detector), 1.4);
  }
  MarkStyle mark_of(const Detector& detector) const {
    if (detector.rule == AlarmRule::voltage_norm) return {cross, ink::light, 0.8, 2};
    return styles_.mark(number_of(detector), 0.7);
  }
  std::size_t number_of(const Detector& detector) const {
    const auto at = std::ranges::find(solvers_, detector.label);
    return static_cast<std::size_t>(at - solvers_.begin());
  }

  Legend legend() const {
    Legend legend(left - 40, picture_width, 3);
    for (const Detector& detector : results_.detectors) {
      if (detector.rule == AlarmRule::by_region) continue;  // as its other rule
      if (detector.failure.empty()) {
        legend.add({detector.label, line_of(detector), mark_of(detector)});
      } else {
        legend.add({detector.label + ": " + detector.failure});
      }
    }
    legend.add({"1: no delay, no skin does better", undelayed_line});
    legend.add({"aim, " + number_text(results_.arm.aim_N) + " N", aimed_line});
    legend.add({"limit, " + number_text(results_.arm.limit_N) + " N, or more", limit_of_arm_line});
    return legend;
  }

  void draw_panel(Canvas& canvas, double from, AlarmRule rule, const std::string& title) const {
    Panel panel(canvas, Box::sized(from, top, panel_width, panel_height),
                Axis::logarithms(speeds_, "speed (m/s)"),
                Axis::logarithms(ratios_, "peak force over that without delay"));
    panel.title(title);
    panel.level(1, undelayed_line);
    panel.line(ratio_curve(results_.arm.aim_N), aimed_line);
    panel.line(ratio_curve(results_.arm.limit_N), limit_of_arm_line);
    for (const AlarmRule drawn : {AlarmRule::voltage_norm, rule}) {
      for (const Detector& detector : results_.detectors) {
        if (detector.rule == drawn && detector.failure.empty()) add(detector, panel);
      }
    }
    panel.draw();
  }

  /// A force over that of a stop without delay, as far as both axes reach.
  Points ratio_curve(double force_N) const {
    constexpr int steps = 200;
    Points out;
    for (int i = 0; i <= steps; ++i) {
      const double speed = speeds_.low * std::pow(speeds_.high / speeds_.low, double(i) / steps);
      const double ratio = force_N / results_.arm.peak_force_N(speed, 0);
      if (ratio >= ratios_.low && ratio <= ratios_.high) out.emplace_back(speed, ratio);
    }
    return out;
  }

  void add(const Detector& detector, Panel& panel) const {
    Points points;
    for (const SpeedBin& bin : speed_bins(detector.arm, results_.arm)) {
      points.emplace_back(bin.speed_m_s, bin.median);
      panel.tooltip(bin.speed_m_s, bin.median,
                    detector.name() + "\n" + fixed(bin.speed_m_s, 3) + " m/s: median " +
                        fixed(bin.median_N, 1) + " N, " + fixed(bin.median, 2) +
                        " times that without delay, 5 to 95 % " + fixed(bin.low, 2) + " to " +
                        fixed(bin.high, 2) + " times");
    }
    panel.line(points, line_of(detector));
    panel.marks(points, mark_of(detector));
  }

  const CollisionResults& results_;
  std::vector<std::string> solvers_;
  MethodStyles styles_;
  Span speeds_, ratios_;
};

}  // namespace

StudyFigure collision_figure(const std::shared_ptr<const CollisionResults>& results) {
  return {"_arm", "Peak force on the obstacle against the arm's speed",
          "over the peak force of a stop without delay at the same speed; medians over runs of "
          "about the same speed; " +
              results->condition,
          "", [results](const std::string& heading, const std::filesystem::path& stem) {
            ArmDrawing(*results).draw(heading +
                                          ": peak force over that of a stop without delay, "
                                          "medians, " +
                                          results->condition,
                                      stem);
          }};
}

}  // namespace ertbench
