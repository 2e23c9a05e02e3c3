#include <algorithm>
#include <cmath>

#include "bench/studies/drawing.h"
#include "bench/studies/targets.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Two panels side by side, px.
class TargetsChart {
 public:
  explicit TargetsChart(const TargetResults& results)
      : results_(results),
        styles_(styles_of(results.solvers)),
        legend_(legend()),
        canvas_(width, height()) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    legend_.draw(canvas_, legend_top);
    const double half = (width - 2 * left - 2 * right) / 2;
    draw_counts("recall", Box::sized(left, top(), half, panel));
    draw_counts("ghosts", Box::sized(2 * left + right + half, top(), half, panel));
    add_footnote(canvas_, "marks: means; whiskers: their 95 % intervals", left);
    canvas_.draw(stem);
  }

 private:
  static constexpr double width = 900;
  static constexpr double left = 56;
  static constexpr double right = 26;
  static constexpr double legend_top = 40;
  static constexpr double panel = 200;

  Legend legend() const {
    Legend legend(left, width - right);
    for (std::size_t s = 0; s < results_.solvers.size(); ++s) {
      const TargetSolver& solver = results_.solvers[s];
      const std::string failure =
          solver.failure.empty() ? "" : " (" + one_line(solver.failure, 40) + ")";
      legend.add({solver.label + failure, styles_.line(s), styles_.mark(s)});
    }
    return legend;
  }
  double top() const { return legend_top + legend_.height() + 22; }
  double height() const { return top() + panel + 64; }

  /// Offset of a solver's marks, so that those of several solvers stand beside each other.
  double beside(std::size_t solver, double step) const {
    const auto solvers = static_cast<double>(results_.solvers.size());
    return step * (static_cast<double>(solver) - (solvers - 1) / 2);
  }

  Axis number_axis() const {
    Axis axis{0.5, 5.5};
    if (!results_.numbers.empty()) {
      axis.low = results_.numbers.front() - 0.5;
      axis.high = results_.numbers.back() + 0.5;
    }
    for (const int number : results_.numbers) {
      axis.ticks.push_back({double(number), std::to_string(number)});
    }
    axis.title = "true contacts";
    axis.grid = false;
    return axis;
  }

  /// An axis from zero to the highest whisker.
  Axis value_axis(const std::string& key, const std::string& title) const {
    Span span{0, key == "recall" ? 1.0 : 0.0};
    for (const TargetSolver& solver : results_.solvers) {
      for (const auto& [number, count] : solver.counts) {
        if (const auto& estimate = count.metrics.at(key)) span.extend(estimate->ci95.high);
      }
    }
    if (span.high <= 0) span.high = 1;
    return Axis::even(span, title);
  }

  void draw_counts(const std::string& key, const Box& box) {
    const std::string title = key == "recall" ? "recall" : "false positives a frame";
    const Axis values = value_axis(key, title);
    Panel axes(canvas_, box, number_axis(), values);
    axes.title(key == "recall" ? "Share of the contacts that were detected"
                               : "Detected contacts that are none");
    const double step = std::min(0.1, 0.6 / static_cast<double>(results_.solvers.size()));
    for (std::size_t n = 1; n < results_.numbers.size(); ++n) {
      // Between two numbers, whose marks stand side by side and mean no fractions.
      const double border = (results_.numbers[n - 1] + results_.numbers[n]) / 2.0;
      axes.line({{border, values.low}, {border, values.high}}, {rgb(0xd0d0d0), 0.8});
    }
    for (std::size_t s = 0; s < results_.solvers.size(); ++s) {
      const TargetSolver& solver = results_.solvers[s];
      Series series;
      for (const auto& [number, count] : solver.counts) {
        const auto& estimate = count.metrics.at(key);
        if (!estimate) continue;
        const double x = number + beside(s, step);
        series.add(x, *estimate);
        axes.tooltip(x, estimate->value,
                     solver.label + ", contacts: " + std::to_string(number) + "\n" + title + " " +
                         estimate_text(*estimate, 3));
      }
      series.draw(axes, styles_.line(s), styles_.mark(s), {styles_.colour(s), 1});
    }
    axes.draw();
  }

  const TargetResults& results_;
  MethodStyles styles_;
  Legend legend_;
  Canvas canvas_;
};

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
    legend.add({"detected", {}, right});
    legend.add({"false positive", {}, ghost});
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
  /// Upright and lying crosses, which differ in grey too.
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
    TextStream out;
    for (const Eigen::Vector2d& point : border_mm(sheet, 180)) out << point.transpose() << "\n";
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
      if (ghosts > 0) result += ", " + std::to_string(ghosts) + " false";
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

StudyFigure targets_chart(const TargetCircumstances& circumstances,
                          std::shared_ptr<const TargetResults> results) {
  return {"", "Contacts detected",
          "recall and false positives by the number of contacts; " + circumstances.conditions,
          ": contacts detected, false positives; " + circumstances.conditions,
          [results](const auto& heading, const auto& stem) {
            TargetsChart(*results).draw(heading, stem);
          }};
}

StudyFigure targets_gallery(const TargetCircumstances& circumstances,
                            std::shared_ptr<const TargetResults> results) {
  return {"_gallery", "True and detected contacts",
          "the first frame of each number of contacts, chosen by nothing else; " +
              circumstances.conditions,
          ": contacts detected, " + circumstances.conditions,
          [results, sheet = circumstances.sheet](const auto& heading, const auto& stem) {
            TargetsGallery(*results, *sheet).draw(heading, stem);
          }};
}

}  // namespace ertbench
