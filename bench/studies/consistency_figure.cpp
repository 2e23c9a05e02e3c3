#include <algorithm>

#include "bench/studies/consistency.h"
#include "bench/studies/drawing.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

constexpr int parts_of_time = 6;  ///< shades of the path
constexpr int points_of_the_border = 120;

class PathFigure {
 public:
  PathFigure(const ConsistentSet& set, const Sensor& sensor)
      : set_(set),
        sensor_(sensor),
        half_(0.5 * sensor.sheet->size_mm()),
        middle_(sensor.sheet->bounds().center() * sensor.sheet->unit_mm()),
        grid_{.panels = static_cast<int>(set.solvers.size()),
              .height = 220 * half_.y() / half_.x(),
              .gap_y = 56},
        canvas_(grid_.right(), grid_.bottom() + 40) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    int panel = 0;
    for (const ConsistencyOfSolver& solver : set_.solvers) draw_solver(solver, panel++);
    Legend legend(grid_.left, canvas_.width() - 10);
    for (int p = 0; p < parts_of_time; ++p) {
      const std::string first = p == 0 ? "first frames" : p == parts_of_time - 1 ? "last" : "";
      legend.add({first, LineStyle{shade(p), 1.2}, mark(p)});
    }
    legend.add({"electrode", {}, electrode});
    legend.draw(canvas_, canvas_.height() - 26);
    canvas_.draw(stem);
  }

 private:
  static constexpr double reach = 1.12;  ///< of the axes, in half sides
  static constexpr MarkStyle electrode{5, ink::black, 0.5, 1};
  static constexpr LineStyle outline{ink::light, 1};

  static Colour shade(int part) { return viridis(0.85 * part / (parts_of_time - 1)); }
  static MarkStyle mark(int part) { return {7, shade(part), 0.3, 1}; }

  void draw_sheet(Panel& panel) const {
    panel.line(points_of(border_mm(*sensor_.sheet, points_of_the_border), middle_), outline);
    panel.marks(points_of(electrodes_mm(sensor_), middle_), electrode);
  }

  void draw_solver(const ConsistencyOfSolver& solver, int number) {
    const Box box = grid_.box(number);
    Panel panel(canvas_, box, Axis::even({-reach * half_.x(), reach * half_.x()}),
                Axis::even({-reach * half_.y(), reach * half_.y()}));
    const auto& jerk = solver.scores.jerk_mm;
    panel.title(solver.label + (jerk ? ", jerk " + fixed(jerk->value, 1) + " mm" : std::string()));
    draw_sheet(panel);
    const std::size_t frames = solver.path.size();
    for (int p = 0; p < parts_of_time; ++p) {
      const std::size_t begin = frames * static_cast<std::size_t>(p) / parts_of_time;
      const std::size_t end = frames * static_cast<std::size_t>(p + 1) / parts_of_time;
      draw_part(panel, solver.path, begin, end, p);
    }
    panel.draw();
    add_failure(canvas_, box, solver.failure);
  }

  /// A line through consecutive frames, broken where a frame has no place.
  void draw_part(Panel& panel, const MeasuredPath& path, std::size_t begin, std::size_t end,
                 int part) const {
    std::vector<Vector2d> piece;
    const auto finish = [&] {
      panel.line(points_of(piece, middle_), {shade(part), 1});
      panel.marks(points_of(piece, middle_), mark(part));
      piece.clear();
    };
    for (std::size_t f = begin; f < std::min(end + 1, path.size()); ++f) {
      if (path[f]) {
        piece.push_back(*path[f]);
      } else {
        finish();
      }
    }
    finish();
  }

  const ConsistentSet& set_;
  const Sensor& sensor_;
  Vector2d half_;
  Vector2d middle_;  ///< mm from the origin of the domain units
  PanelGrid grid_;
  Canvas canvas_;
};

}  // namespace

StudyFigure path_figure(std::shared_ptr<const ConsistentSet> set, const Sensor& sensor) {
  return {"_paths_" + set->name, "Paths seen in " + set->name,
          "axes in mm from the middle of the sheet; the strongest contact of each frame, early "
          "frames dark, late ones light",
          ": paths seen, " + set->name, [set, sensor](const auto& heading, const auto& stem) {
            PathFigure(*set, sensor).draw(heading, stem);
          }};
}

}  // namespace ertbench
