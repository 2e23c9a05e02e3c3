#include <algorithm>

#include "bench/plot/canvas.h"
#include "bench/plot/panel.h"
#include "bench/studies/consistency.h"
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
        count_(static_cast<int>(set.solvers.size())),
        columns_(std::min(count_, 4)),
        half_(0.5 * sensor.sheet->size_mm()),
        middle_(sensor.sheet->bounds().center() * sensor.sheet->unit_mm()),
        high_(wide * half_.y() / half_.x()),
        canvas_(left + columns_ * (wide + gap_x), top + rows() * (high_ + gap_y) + foot) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    for (int s = 0; s < count_; ++s) draw_solver(set_.solvers[static_cast<std::size_t>(s)], s);
    Legend legend(left, canvas_.width() - 10);
    for (int p = 0; p < parts_of_time; ++p) {
      const std::string first = p == 0 ? "first frames" : p == parts_of_time - 1 ? "last" : "";
      legend.add({first, LineStyle{shade(p), 1.2}, mark(p)});
    }
    legend.add({"electrode", {}, electrode});
    legend.draw(canvas_, canvas_.height() - 26);
    canvas_.draw(stem);
  }

 private:
  static constexpr double wide = 220;
  static constexpr double left = 44;
  static constexpr double top = 54;
  static constexpr double gap_x = 44;
  static constexpr double gap_y = 56;
  static constexpr double foot = 40;
  static constexpr double reach = 1.12;  ///< of the axes, in half sides
  static constexpr MarkStyle electrode{5, ink::black, 0.5, 1};
  static constexpr LineStyle outline{ink::light, 1};

  int rows() const { return (count_ + columns_ - 1) / columns_; }
  static Colour shade(int part) { return viridis(0.85 * part / (parts_of_time - 1)); }
  static MarkStyle mark(int part) { return {7, shade(part), 0.3, 1}; }

  Points in_mm(const std::vector<Vector2d>& places) const {
    Points out;
    for (const Vector2d& place : places) {
      out.emplace_back(place.x() - middle_.x(), place.y() - middle_.y());
    }
    return out;
  }

  void draw_sheet(Panel& panel) const {
    const Sheet& sheet = *sensor_.sheet;
    std::vector<Vector2d> border;
    for (int i = 0; i <= points_of_the_border; ++i) {
      border.push_back(sheet.unit_mm() *
                       sheet.border_point(sheet.border_length() * i / points_of_the_border));
    }
    panel.line(in_mm(border), outline);
    const Eigen::Matrix2Xd electrodes = electrode_positions(sensor_) * sheet.unit_mm();
    std::vector<Vector2d> places;
    for (Eigen::Index e = 0; e < electrodes.cols(); ++e) places.emplace_back(electrodes.col(e));
    panel.marks(in_mm(places), electrode);
  }

  void draw_solver(const ConsistencyOfSolver& solver, int number) {
    const Box box = Box::sized(left + number % columns_ * (wide + gap_x),
                               top + number / columns_ * (high_ + gap_y), wide, high_);
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
    if (!solver.failure.empty()) {
      canvas_.text(one_line(solver.failure, 34), box.middle(), box.centre(),
                   {.size = 9, .colour = ink::alarm});
    }
  }

  /// A line through consecutive frames, broken where a frame has no place.
  void draw_part(Panel& panel, const MeasuredPath& path, std::size_t begin, std::size_t end,
                 int part) const {
    std::vector<Vector2d> piece;
    const auto finish = [&] {
      panel.line(in_mm(piece), {shade(part), 1});
      panel.marks(in_mm(piece), mark(part));
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
  int count_;
  int columns_;
  Vector2d half_;
  Vector2d middle_;
  double high_;
  Canvas canvas_;
};

}  // namespace

ReportFigure path_figure(const ConsistentSet& set, const Sensor& sensor, const std::string& title,
                         const std::filesystem::path& stem) {
  const bool drawn = draw_or_say(
      stem, [&] { PathFigure(set, sensor).draw(title + ": paths seen, " + set.name, stem); });
  return {"Paths seen in " + set.name, stem.string() + ".svg",
          "axes in mm from the middle of the sheet; the strongest contact of each frame, early "
          "frames dark, late ones light",
          drawn};
}

}  // namespace ertbench
