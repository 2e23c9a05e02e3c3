#include <algorithm>
#include <cctype>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

#include "bench/plot/panel.h"
#include "bench/record/limit_file.h"
#include "bench/report/chart.h"
#include "bench/speed/speed_chart.h"

namespace ertbench {
namespace {

/// The methods that the front page shows, the classical ones first.
const std::vector<std::string> methods = {"one-step-gn", "lmmse",    "fcnn",    "eit-nn",
                                          "dd-ert",      "contacts", "lean-net"};

struct Setting {
  std::string name;
  std::size_t method;
  double us;
  double error;
  std::optional<Interval> ci95;
};

/// "lean-net 8" of "lean-net width=8"; Gauss-Newton has its prior in its name.
std::string name_of(const ResultRow& row) {
  if (row.type != "one-step-gn") {
    return std::regex_replace(row.label, std::regex(" [a-z_]+=([0-9]+)[-0-9]*"), " $1");
  }
  std::string prior = (*row.parameters).value("prior", "");
  std::ranges::transform(prior, prior.begin(), [](unsigned char c) { return std::toupper(c); });
  return "GN (" + prior + ")";
}

/// The settings of `all` with an error that nothing faster has, by a thousandth; from the fastest.
std::vector<Setting> frontier_of(std::vector<Setting> all) {
  std::ranges::sort(all, {}, &Setting::us);
  double least = std::numeric_limits<double>::infinity();
  std::erase_if(all, [&](const Setting& one) {
    return one.error > 0.999 * least || (least = one.error, false);
  });
  return all;
}

/// The band in which the least possible error lies: above the lower bound, where there is one, and
/// below the best known estimator's error.
void draw_bracket(const SpeedAccuracy& chart, std::span<const ResultRow> rows, Panel& panel,
                  Canvas& canvas) {
  if (!chart.limit_ci95) return;
  Interval band = *chart.limit_ci95;
  std::string text = "best known estimator";
  for (const ResultRow& row : rows) {
    const auto& below = row.metrics[chart.metric].ci95;
    if (row.type != limit_lower || row.dataset != chart.dataset || !below) continue;
    band.low = below->low;
    text = "from the lower bound to the best known estimator";
  }
  panel.band(band.low, band.high, ink::alarm.towards_white(0.86));
  canvas.text(text + ", 95 %", 62, panel.y((band.low + band.high) / 2),
              {.align = TextAlign::left, .colour = ink::alarm});
}

}  // namespace

void draw_frontier_figure(const SpeedAccuracy& chart, std::span<const ResultRow> rows,
                          const std::filesystem::path& stem) {
  std::vector<Setting> settings;
  Canvas canvas(690, 430);
  Panel panel(canvas, {56, 16, 676, 380}, {2.5, 4000, true, time_ticks(), "time of one frame, p50"},
              Axis::even({0.1, 0.8}, "mean relative error of δσ (empty image: 1)"));
  draw_bracket(chart, rows, panel, canvas);
  for (const ResultRow& row : rows) {
    if (row.dataset != chart.dataset) continue;
    const MetricSummary& error = row.metrics[chart.metric];
    const auto point = std::ranges::find(chart.points, row.label, &SpeedPoint::label);
    const auto method =
        static_cast<std::size_t>(std::ranges::find(methods, row.type) - methods.begin());
    if (method == methods.size() || point == chart.points.end() || !point->latency) continue;
    if (point->standing != Standing::ok || !error.mean || *error.mean > 0.8) continue;
    settings.push_back({name_of(row), method, point->latency->p50, *error.mean, error.ci95});
  }
  const std::vector<Setting> frontier = frontier_of(settings);
  Points steps;
  for (const Setting& one : frontier) {
    steps.emplace_back(one.us, steps.empty() ? 0.8 : steps.back().second);
    steps.emplace_back(one.us, one.error);
  }
  if (!steps.empty()) steps.emplace_back(4000, steps.back().second);
  panel.line(steps, {ink::dark, 1.6, 2});
  std::vector<Segment> lines;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    lines.push_back({panel.x(steps[i - 1].first), panel.y(steps[i - 1].second),
                     panel.x(steps[i].first), panel.y(steps[i].second)});
  }
  canvas.text("frontier: nothing faster has a smaller error", 672, panel.y(0.125),
              {.align = TextAlign::right});
  const MethodStyles styles(methods);
  std::vector<PointLabel> labels;
  std::vector<Box> taken = {{56, panel.y(0.255), 676, 380}};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::vector<Setting> own;
    std::ranges::copy_if(settings, std::back_inserter(own),
                         [m](const Setting& one) { return one.method == m; });
    own = frontier_of(own);
    Points points;
    std::vector<Whisker> whiskers;
    for (const Setting& one : own) {
      points.emplace_back(one.us, one.error);
      if (one.ci95) whiskers.push_back({one.us, one.ci95->low, one.ci95->high});
      taken.push_back(Box::around(panel.x(one.us), panel.y(one.error), 5));
      const bool named =
          &one == &own.back() || std::ranges::count(frontier, one.name, &Setting::name);
      if (named)
        labels.push_back(
            {one.name, panel.x(one.us), panel.y(one.error), styles.colour(m).for_text()});
    }
    panel.line(points, {styles.colour(m).towards_white(0.5), 1.2});
    panel.whiskers(whiskers, {ink::light, 1});
    panel.marks(points, styles.filled_mark(m, 0.9));
  }
  panel.draw();
  panel.labels(labels, taken, lines);
  canvas.draw(stem);
}

}  // namespace ertbench
