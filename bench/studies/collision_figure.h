#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/plot/panel.h"
#include "bench/report/chart.h"
#include "bench/report/report.h"
#include "bench/studies/collision_detectors.h"

namespace ertbench {

/// Axes that both panels of a figure share.
struct PanelAxes {
  Axis x;
  Axis y;
};

/// How a detector looks in all figures: the same for both rules of a solver.
struct DetectorStyle {
  LineStyle line;
  MarkStyle mark;
};

/// Two panels beside each other, alarms by one threshold on the left and those by region on the
/// right, the norm of the voltages in both, and the legend below.
class CollisionPair {
 public:
  /// `results` must outlive this.
  CollisionPair(const CollisionResults& results, PanelAxes axes);

  /// Adds an entry to the legend, behind the detectors.
  void explain(const std::string& text, const std::optional<LineStyle>& line);

  /// What lies under all detectors.
  using Ground = std::function<void(Panel&)>;
  /// One detector; `place` is where it stands among those of the panel, -0.5 to 0.5, to set
  /// whiskers beside each other.
  using Plot = std::function<void(Panel&, const Detector&, const DetectorStyle&, double place)>;
  void draw(const std::string& title, const Ground& ground, const Plot& plot,
            const std::filesystem::path& stem) const;

 private:
  std::size_t number_of(const Detector& detector) const;
  DetectorStyle style_of(const Detector& detector) const;
  /// The detectors that are drawn in the panel of a rule, the lowest first.
  std::vector<const Detector*> detectors_of(AlarmRule rule) const;

  const CollisionResults& results_;
  PanelAxes axes_;
  std::vector<std::string> solvers_;
  MethodStyles styles_;
  Legend legend_;
};

/// Draws `stem`_force (detection against force), `stem`_curve (detection against false alarms) and
/// `stem`_arm (peak force against speed).
std::vector<ReportFigure> collision_figures(const CollisionResults& results,
                                            const std::string& title,
                                            const std::filesystem::path& stem);

}  // namespace ertbench
