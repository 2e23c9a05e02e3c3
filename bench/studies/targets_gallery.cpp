#include "bench/studies/targets_gallery.h"

#include <algorithm>
#include <cmath>

#include "bench/plot/drawing.h"
#include "bench/plot/legend.h"
#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

/// Panels of one size in rows and columns, px.
class TargetsGallery {
 public:
  TargetsGallery(const TargetResults& results, const Sheet& sheet)
      : results_(results),
        sheet_(sheet),
        side_(std::clamp(900 / std::max(1.0, double(results.solvers.size())) - gap, 92.0, 160.0)),
        titles_(titles_of(results, side_)),
        canvas_(width(), height()),
        outline_(canvas_.data(outline_of(sheet))) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    for (std::size_t c = 0; c < titles_.size(); ++c) {
      for (std::size_t i = 0; i < titles_[c].size(); ++i) {
        const double y = top() - 5 - line * (double(titles_[c].size() - i) - 0.5);
        canvas_.text(titles_[c][i], box(0, c).middle(), y, {.size = 11});
      }
    }
    for (std::size_t r = 0; r < results_.gallery.size(); ++r) {
      const int contacts = results_.gallery[r].contacts();
      canvas_.text(std::to_string(contacts) + (contacts == 1 ? " contact" : " contacts"), 16,
                   box(r, 0).centre(), {.upright = true});
      for (std::size_t c = 0; c < results_.solvers.size(); ++c) draw_panel(r, c);
    }
    Legend legend(left, canvas_.width() - 8);
    legend.add({"true footprint", {}, MarkStyle{7, footprint, 1.1, 1}});
    legend.add({"found", {}, right});
    legend.add({"ghost", {}, ghost});
    legend.add({"larger: stronger within its frame"});
    legend.draw(canvas_, canvas_.height() - 34);
    canvas_.draw(stem);
  }

 private:
  static constexpr double left = 30;
  static constexpr double gap = 9;
  static constexpr double line = 13;     ///< of a title
  static constexpr double caption = 26;  ///< below a panel, with the gap to the next
  static constexpr Colour footprint = rgb(0xc4c4c4);
  /// Upright and lying crosses, told apart in grey.
  inline static const MarkStyle right{1, hue(0), 1, 1.8};
  inline static const MarkStyle ghost{cross, hue(1), 1, 1.8};

  static std::vector<std::vector<std::string>> titles_of(const TargetResults& results,
                                                         double side) {
    constexpr std::size_t most_lines = 3;
    std::vector<std::vector<std::string>> out;
    for (const TargetSolver& solver : results.solvers) {
      out.push_back(wrapped(solver.label, characters_in(side, 11)));
      if (out.back().size() > most_lines) out.back().resize(most_lines);
    }
    return out;
  }

  static std::string outline_of(const Sheet& sheet) {
    constexpr int points = 180;
    TextStream out;
    for (int i = 0; i <= points; ++i) {
      const double along = sheet.border_length() * i / points;
      out << sheet.unit_mm() * sheet.border_point(along).transpose() << "\n";
    }
    return out.str();
  }

  double panel_height() const { return side_ * sheet_.size_mm().y() / sheet_.size_mm().x(); }
  double top() const {
    std::size_t lines = 1;
    for (const auto& title : titles_) lines = std::max(lines, title.size());
    return 34 + line * double(lines) + 5;
  }
  double width() const {
    return std::max(480.0, left + double(results_.solvers.size()) * (side_ + gap));
  }
  double height() const {
    return top() + double(results_.gallery.size()) * (panel_height() + caption) + 50;
  }
  Box box(std::size_t row, std::size_t column) const {
    return Box::sized(left + double(column) * (side_ + gap),
                      top() + double(row) * (panel_height() + caption), side_, panel_height());
  }

  void draw_panel(std::size_t row, std::size_t column) {
    const Box place = box(row, column);
    const TargetFrame& truth = results_.gallery[row];
    const TargetSolver& solver = results_.solvers[column];
    const auto& found = solver.gallery[row];
    // A pixel more to each side, so that the outline is not cut in half.
    const Eigen::Vector2d reach = sheet_.unit_mm() * sheet_.bounds().max() * (1 + 2 / side_);
    const Eigen::Vector2d other = sheet_.unit_mm() * sheet_.bounds().min() * (1 + 2 / side_);
    canvas_.area(place);
    canvas_.plots() << "unset key\nunset tics\nunset border\nset xrange [" << other.x() << ":"
                    << reach.x() << "]\nset yrange [" << other.y() << ":" << reach.y()
                    << "]\nplot ";
    if (found) {  // else the panel is left to the words
      draw_truth(truth);
      draw_found(*found, true, right);
      draw_found(*found, false, ghost);
    }
    canvas_.plots() << outline_ << " with lines " << LineStyle{ink::light, 1}.text() << "\n";

    std::string result;
    if (found) {
      const int ghosts = found->match.score.found - found->match.score.matched;
      result =
          std::to_string(found->match.score.matched) + " of " + std::to_string(truth.contacts());
      if (ghosts > 0) result += ", " + std::to_string(ghosts) + (ghosts > 1 ? " ghosts" : " ghost");
      canvas_.text(result, place.middle(), place.bottom + 9, {.size = 9});
    } else {
      result = solver.failure.empty() ? "no reading" : solver.failure;
      const auto characters = characters_in(side_, 10);
      canvas_.lines(one_line(result, 4 * characters), characters, place.middle(),
                    place.centre() - 18, {.size = 10, .colour = ink::alarm});
    }
    canvas_.tooltip(
        place, solver.label + ", contacts: " + std::to_string(truth.contacts()) + "\n" + result);
  }

  void draw_truth(const TargetFrame& truth) {
    TextStream discs;
    for (std::size_t t = 0; t < truth.places_mm.size(); ++t) {
      discs << truth.places_mm[t].transpose() << " " << truth.radii_mm[t] << "\n";
    }
    canvas_.plots() << canvas_.data(discs.str())
                    << " using 1:2:3 with circles fillstyle solid noborder linecolor rgb '"
                    << footprint.hex() << "', ";
  }

  /// The contacts that belong to a true one, or those that do not.
  void draw_found(const TargetSolver::Found& found, bool matched, const MarkStyle& style) {
    double strongest = 0;
    for (const ContactReading& contact : found.contacts) {
      strongest = std::max(strongest, std::abs(contact.strength));
    }
    TextStream crosses;
    for (std::size_t i = 0; i < found.contacts.size(); ++i) {
      if (found.match.right[i] != matched) continue;
      const ContactReading& contact = found.contacts[i];
      const double share = strongest > 0 ? std::abs(contact.strength) / strongest : 0;
      crosses << contact.place_mm.transpose() << " " << 0.45 + 0.85 * std::sqrt(share) << "\n";
    }
    if (crosses.str().empty()) return;
    canvas_.plots() << canvas_.data(crosses.str()) << " using 1:2:3 with points pointtype "
                    << style.shape << " pointsize variable linewidth " << style.width
                    << " linecolor rgb '" << style.colour.hex() << "', ";
  }

  const TargetResults& results_;
  const Sheet& sheet_;
  double side_;
  std::vector<std::vector<std::string>> titles_;
  Canvas canvas_;
  std::string outline_;  ///< name of its file
};

}  // namespace

ReportFigure targets_gallery(const TargetCircumstances& circumstances, const TargetResults& results,
                             const std::string& title, const std::filesystem::path& folder) {
  const std::filesystem::path stem = folder / (circumstances.name + "_gallery");
  const bool drawn = draw_or_say(stem, [&] {
    TargetsGallery(results, *circumstances.sheet)
        .draw(title + ": contacts found, " + circumstances.conditions, stem);
  });
  return {"True and found contacts", stem.string() + ".svg",
          "the first frame of each number of contacts, chosen by nothing else; " +
              circumstances.conditions,
          drawn};
}

}  // namespace ertbench
