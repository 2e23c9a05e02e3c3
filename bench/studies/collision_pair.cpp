#include "bench/studies/collision_pair.h"

#include <algorithm>
#include <utility>

namespace ertbench {
namespace {

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

}  // namespace

CollisionPair::CollisionPair(const CollisionResults& results, PanelAxes axes)
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

void CollisionPair::explain(const std::string& text, const std::optional<LineStyle>& line) {
  legend_.add({text, line});
}

void CollisionPair::draw(const std::string& title, const Ground& ground, const Plot& plot,
                         const std::filesystem::path& stem) const {
  Canvas canvas(PairLayout::width(), PairLayout::legend_top + legend_.height() + 6);
  canvas.title(title);
  for (const AlarmRule rule : {AlarmRule::one_threshold, AlarmRule::by_region}) {
    const bool second = rule == AlarmRule::by_region;
    const double left = PairLayout::left + (second ? PairLayout::panel_width + PairLayout::gap : 0);
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

std::size_t CollisionPair::number_of(const Detector& detector) const {
  const auto at = std::find(solvers_.begin(), solvers_.end(), detector.label);
  return static_cast<std::size_t>(at - solvers_.begin());
}

DetectorStyle CollisionPair::style_of(const Detector& detector) const {
  if (detector.rule == AlarmRule::voltage_norm) {
    return {{ink::light, 2.2}, {cross, ink::light, 0.8, 2}};
  }
  const std::size_t s = number_of(detector);
  return {styles_.line(s, 1.4), styles_.mark(s, 0.7)};
}

std::vector<const Detector*> CollisionPair::detectors_of(AlarmRule rule) const {
  std::vector<const Detector*> out;
  for (const AlarmRule drawn : {AlarmRule::voltage_norm, rule}) {
    for (const Detector& detector : results_.detectors) {
      if (detector.rule == drawn && detector.failure.empty()) out.push_back(&detector);
    }
  }
  return out;
}

}  // namespace ertbench
