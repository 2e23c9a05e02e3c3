#include <algorithm>
#include <iterator>

#include "bench/studies/drawing.h"
#include "bench/studies/tracking.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t gallery_rows = 2;
constexpr std::size_t most_columns = 6;  // of methods, further ones stand below

/// At most gallery_rows of the characters, evenly chosen of those before the first is repeated; a
/// row for the solvers' failures where there are none.
std::vector<std::size_t> shown_characters(const TrackingCondition& condition) {
  std::vector<std::string> names;
  for (const TrackingOfSolver& solver : condition.solvers) {
    for (const TrackedCharacter& one : solver.characters) {
      if (contains(names, one.name)) break;
      names.push_back(one.name);
    }
  }
  std::vector<std::size_t> out(std::clamp<std::size_t>(names.size(), 1, gallery_rows));
  for (std::size_t r = 1; r < out.size(); ++r) out[r] = r * (names.size() - 1) / (out.size() - 1);
  return out;
}

constexpr LineStyle written_line{ink::light, 1.2};

MarkStyle dot(const Colour& colour) { return {7, colour, 0.22, 1}; }

/// A character as it was written and tracked, and below it how well.
void draw_character(Canvas& canvas, const Box& box, const TrackedCharacter& character,
                    double size_mm, const std::string& label, const Colour& colour) {
  const double reach = 0.68 * size_mm;
  Panel panel(canvas, box, {-reach, reach}, {-reach, reach});
  for (const Polyline& stroke : character.written) panel.line(points_of(stroke), written_line);
  for (const Polyline& stroke : character.tracked) {
    panel.line(points_of(stroke), {colour, 1.2});
    panel.marks(points_of(stroke), dot(colour));
  }
  panel.draw();
  const std::string rms =
      character.rms_mm ? "RMS " + fixed(*character.rms_mm, 1) + " mm" : "nothing tracked";
  const bool right = character.read_back();
  const std::string read = character.read_as.empty() ? "not read"
                           : right                   ? "read as " + character.read_as
                                                     : "misread as " + character.read_as;
  canvas.text(rms, box.middle(), box.bottom + 9, {.size = 10});
  canvas.text(read, box.middle(), box.bottom + 21,
              {.size = 10, .colour = right ? ink::black : ink::alarm});
  canvas.tooltip(box, label + ", " + character.name + "\n" + rms + "\n" + read);
}

/// A method's label in at most three lines above `box`.
void draw_label(Canvas& canvas, const Box& box, const std::string& label) {
  std::vector<std::string> lines = wrapped(label, characters_in(box.width(), 11));
  if (lines.size() > 3) {
    lines.resize(3);
    lines.back() += "…";
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double up = 13 * (static_cast<double>(lines.size() - i) - 0.5);
    canvas.text(lines[i], box.middle(), box.top - 3 - up, {.size = 11});
  }
}

void draw_gallery(const TrackingCondition& condition, const std::string& heading,
                  const std::filesystem::path& stem) {
  constexpr double left = 14;
  constexpr double top = 74;
  constexpr double gap_x = 10;
  constexpr double gap_y = 36;  // with two lines of words
  const std::vector<std::size_t> rows = shown_characters(condition);
  const MethodStyles styles = styles_of(condition.solvers);
  const std::size_t columns = std::clamp<std::size_t>(condition.solvers.size(), 1, most_columns);
  const double side = std::clamp(700.0 / static_cast<double>(columns) - gap_x, 104.0, 150.0);
  const double band = 50 + static_cast<double>(rows.size()) * (side + gap_y);
  const auto bands = static_cast<double>((condition.solvers.size() + columns - 1) / columns);
  Canvas canvas(std::max(520.0, left + static_cast<double>(columns) * (side + gap_x)),
                top - 20 + bands * band);
  canvas.title(heading);
  for (std::size_t c = 0; c < condition.solvers.size(); ++c) {
    const TrackingOfSolver& solver = condition.solvers[c];
    const double column = left + static_cast<double>(c % columns) * (side + gap_x);
    const double first = top + static_cast<double>(c / columns) * band;
    draw_label(canvas, Box::sized(column, first, side, side), solver.label);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const double row = first + static_cast<double>(r) * (side + gap_y);
      const Box box = Box::sized(column, row, side, side);
      if (rows[r] < solver.characters.size()) {
        draw_character(canvas, box, solver.characters[rows[r]], condition.size_mm, solver.label,
                       styles.colour(c));
        continue;
      }
      Panel(canvas, box, {}, {}).draw();
      canvas.lines(solver.failure, characters_in(side - 8, 9), box.middle(), box.top + 14,
                   {.size = 9, .colour = ink::alarm});
    }
  }
  Legend legend(left, canvas.width());
  legend.add({"written", written_line});
  legend.add({"tracked, stroke by stroke", LineStyle{ink::black, 1.2}, dot(ink::black)});
  legend.draw(canvas, canvas.height() - 14);
  canvas.draw(stem);
}

}  // namespace

StudyFigure tracking_figure(const TrackingConditions& conditions, const std::string& law) {
  const TrackingCondition& first = conditions->front();
  const std::string what = number_text(first.speed_mm_s) + " mm/s, " +
                           number_text(first.frame_rate) + " frames/s, " + first.noise + ", " +
                           law + " law";
  return {"_characters", "Written and tracked characters: " + first.set,
          what + "; below each its RMS distance, delay and all, and what it was read as",
          ": " + what, [conditions](const auto& heading, const auto& stem) {
            draw_gallery(conditions->front(), heading, stem);
          }};
}

}  // namespace ertbench
