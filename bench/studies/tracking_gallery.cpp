#include <algorithm>

#include "bench/charts/method_styles.h"
#include "bench/plot/drawing.h"
#include "bench/plot/legend.h"
#include "bench/plot/panel.h"
#include "bench/studies/tracking_figure.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t gallery_rows = 6;

/// At most gallery_rows of the characters, evenly chosen of those before the first is repeated; a
/// row for the solvers' failures where there are none.
std::vector<std::size_t> shown_characters(const TrackingCondition& condition) {
  std::vector<std::string> names;
  for (const TrackingOfSolver& solver : condition.solvers) {
    for (const TrackedCharacter& one : solver.characters) {
      if (std::find(names.begin(), names.end(), one.name) != names.end()) break;
      names.push_back(one.name);
    }
    if (!names.empty()) break;
  }
  if (names.empty()) return {0};
  const std::size_t rows = std::min(gallery_rows, names.size());
  std::vector<std::size_t> out;
  for (std::size_t r = 0; r < rows; ++r) {
    out.push_back(rows > 1 ? r * (names.size() - 1) / (rows - 1) : 0);
  }
  return out;
}

Points points_of_stroke(const Polyline& stroke) {
  Points out;
  for (const Eigen::Vector2d& place : stroke) out.emplace_back(place.x(), place.y());
  return out;
}

class TrackingGallery {
 public:
  explicit TrackingGallery(const TrackingCondition& condition)
      : condition_(condition),
        rows_(shown_characters(condition)),
        styles_(styles_of(condition.solvers)),
        columns_(static_cast<int>(condition.solvers.size())),
        side_(std::clamp(950.0 / columns_ - gap_x, 104.0, 150.0)),
        canvas_(std::max(520.0, left + columns_ * (side_ + gap_x)), height()) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    for (int c = 0; c < columns_; ++c) {
      const TrackingOfSolver& solver = condition_.solvers[static_cast<std::size_t>(c)];
      write_label(solver.label, c);
      for (std::size_t r = 0; r < rows_.size(); ++r) {
        const Box box = box_at(r, c);
        if (rows_[r] < solver.characters.size()) {
          draw_character(solver, static_cast<std::size_t>(c), solver.characters[rows_[r]], box);
        } else {
          Panel(canvas_, box, {}, {}).draw();
          canvas_.lines(solver.failure, characters_in(side_ - 8, 9), box.middle(), box.top + 14,
                        {.size = 9, .colour = ink::alarm});
        }
      }
    }
    Legend legend(left, canvas_.width());
    legend.add({"written", written});
    legend.add({"tracked, stroke by stroke", LineStyle{ink::black, 1.2}, dot(ink::black)});
    legend.draw(canvas_, canvas_.height() - 14);
    canvas_.draw(stem);
  }

 private:
  static constexpr double left = 14;
  static constexpr double top = 74;
  static constexpr double gap_x = 10;
  static constexpr double gap_y = 36;  ///< with two lines of words
  static constexpr LineStyle written{ink::light, 1.2};

  static MarkStyle dot(const Colour& colour) { return {7, colour, 0.22, 1}; }

  double height() const { return top + static_cast<double>(rows_.size()) * (side_ + gap_y) + 30; }

  Box box_at(std::size_t row, int column) const {
    return Box::sized(left + column * (side_ + gap_x),
                      top + static_cast<double>(row) * (side_ + gap_y), side_, side_);
  }

  void write_label(const std::string& label, int column) {
    const Box box = box_at(0, column);
    std::vector<std::string> lines = wrapped(label, characters_in(side_, 11));
    if (lines.size() > 3) {
      lines.resize(3);
      lines.back() += "…";
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const double up = 13 * (static_cast<double>(lines.size() - i) - 0.5);
      canvas_.text(lines[i], box.middle(), box.top - 3 - up, {.size = 11});
    }
  }

  void draw_character(const TrackingOfSolver& solver, std::size_t index,
                      const TrackedCharacter& character, const Box& box) {
    const double reach = 0.68 * condition_.size_mm;
    Panel panel(canvas_, box, {-reach, reach}, {-reach, reach});
    for (const Polyline& stroke : character.written) panel.line(points_of_stroke(stroke), written);
    const Colour colour = styles_.colour(index);
    for (const Polyline& stroke : character.tracked) {
      panel.line(points_of_stroke(stroke), {colour, 1.2});
      panel.marks(points_of_stroke(stroke), dot(colour));
    }
    panel.draw();
    const std::string rms =
        character.rms_mm ? "RMS " + fixed(*character.rms_mm, 1) + " mm" : "nothing tracked";
    const bool right = character.read_back();
    const std::string read = character.read_as.empty() ? "not read"
                             : right                   ? "read as " + character.read_as
                                                       : "misread as " + character.read_as;
    canvas_.text(rms, box.middle(), box.bottom + 9, {.size = 10});
    canvas_.text(read, box.middle(), box.bottom + 21,
                 {.size = 10, .colour = right ? ink::black : ink::alarm});
    canvas_.tooltip(box, solver.label + ", " + character.name + "\n" + rms + "\n" + read);
  }

  const TrackingCondition& condition_;
  std::vector<std::size_t> rows_;  ///< characters of each solver
  MethodStyles styles_;
  int columns_;
  double side_;  ///< of a panel, px
  Canvas canvas_;
};

}  // namespace

ReportFigure tracking_gallery(const TrackingCondition& condition, const std::string& law,
                              const std::string& title, const std::filesystem::path& stem) {
  const std::string what = number_text(condition.speed_mm_s) + " mm/s, " +
                           number_text(condition.frame_rate) + " frames/s, " + condition.noise +
                           ", " + law + " law";
  const bool drawn =
      draw_or_say(stem, [&] { TrackingGallery(condition).draw(title + ": " + what, stem); });
  return {"Written and tracked characters: " + condition.set, stem.string() + ".svg",
          what + "; below each its RMS distance, delay and all, and what it was read as", drawn};
}

}  // namespace ertbench
