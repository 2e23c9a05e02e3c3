#include "bench/charts/fidelity_chart.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "bench/analysis/chart_text.h"
#include "bench/plot/canvas.h"
#include "bench/plot/label_layout.h"
#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr int panel_width = 290;
constexpr int panel_height = 250;
constexpr int left_margin = 70;
constexpr int gap = 34;
constexpr int top = 62;
constexpr int bar_top = top + panel_height + 92;
constexpr int bar_height = 22;
constexpr int height = bar_top + 3 * bar_height + 60;

struct Range {
  double low;
  double high;
  double share(double value) const { return std::log(value / low) / std::log(high / low); }
};

/// What one panel shows: a dataset's rows of all its scenes.
std::vector<std::string> datasets_of(const std::vector<FidelityRow>& rows) {
  std::vector<std::string> names;
  for (const FidelityRow& row : rows) {
    if (std::find(names.begin(), names.end(), row.dataset) == names.end()) {
      names.push_back(row.dataset);
    }
  }
  return names;
}

class Drawing {
 public:
  Drawing(const std::vector<FidelityRow>& rows, const std::string& title)
      : rows_(rows),
        title_(title),
        names_(datasets_of(rows)),
        canvas_(left_margin + static_cast<int>(names_.size()) * (panel_width + gap) + 6, height) {
    double fastest = INFINITY;
    double slowest = 0;
    double least = INFINITY;
    double most = 0;
    for (const FidelityRow& row : rows_) {
      fastest = std::min(fastest, row.time_low);
      slowest = std::max(slowest, row.time_high);
      least = std::min(least, row.error_median);
      most = std::max(most, row.error_max);
    }
    times_ = {fastest / 1.5, slowest * 1.5};
    errors_ = {std::max(least, 1e-5 * most) / 2, most * 1.6};
  }

  void draw(const std::filesystem::path& stem) {
    canvas_.out() << "set multiplot\nset errorbars small\n";
    for (std::size_t p = 0; p < names_.size(); ++p) plot(p);
    for (std::size_t p = 0; p < names_.size(); ++p) {
      name_points(p);
      sizes(p);
    }
    canvas_.label(title_, 16, 20, 13, "left");
    legend();
    canvas_.finish_marks();
    canvas_.out() << "unset multiplot\n";
    canvas_.draw(files_, stem);
  }

 private:
  double left(std::size_t p) const {
    return left_margin + static_cast<double>(p) * (panel_width + gap);
  }

  Box box_of(std::size_t p) const {
    return {left(p), top, left(p) + panel_width, top + panel_height};
  }

  void plot(std::size_t p) {
    std::ostringstream line;
    std::ostringstream grids;
    std::ostringstream autos;
    std::ostringstream whiskers;
    std::ostringstream times;
    double bound = 0.25;
    for (const FidelityRow& row : rows_) {
      if (row.dataset != names_[p] || row.scenes != "all") continue;
      bound = row.bound;
      const double error = std::max(row.error_median, errors_.low);
      const bool automatic = row.model == "auto";
      (automatic ? autos : grids) << row.time_us << ' ' << error << '\n';
      if (!automatic) line << row.time_us << ' ' << error << '\n';
      whiskers << row.time_us << ' ' << error << ' ' << error << ' ' << row.error_max << '\n';
      times << row.time_us << ' ' << error << ' ' << row.time_low << ' ' << row.time_high << '\n';
    }
    std::ostringstream limit;
    limit << times_.low << ' ' << bound << '\n' << times_.high << ' ' << bound << '\n';
    const Box box = box_of(p);
    canvas_.area(box.left, box.top, panel_width, panel_height);
    canvas_.out() << "unset key\nset border 3 linecolor '#606060'\nset logscale xy\n"
                  << "set grid xtics ytics linetype 1 linecolor '#e4e4e4' linewidth 0.6\n"
                  << "set tics nomirror scale 0.5\nset xrange [" << times_.low << ":" << times_.high
                  << "]\nset yrange [" << errors_.low << ":" << errors_.high << "]\nset xtics ("
                  << time_tics()
                  << ")\nset ytics ('10' 10, '1' 1, '0.1' 0.1, '0.01' 0.01, '0.001' 0.001)\n"
                  << "set xlabel 'time of a scene, one thread' offset 0,0.3\n"
                  << (p == 0 ? "set ylabel 'error of the voltages / noise' offset 1,0\n"
                             : "unset ylabel\n")
                  << "plot " << file(limit)
                  << " with lines dashtype 2 linewidth 1.2 linecolor '#303030', " << file(line)
                  << " with lines linewidth 1.2 linecolor '" << hue(0).towards_white(0.5).hex()
                  << "', " << file(whiskers)
                  << " with yerrorbars pointtype 0 linewidth 1 linecolor '#909090', " << file(times)
                  << " with xerrorbars pointtype 0 linewidth 1 linecolor '#909090', " << file(grids)
                  << " with points pointtype 5 pointsize 0.9 linecolor '" << hue(0).hex() << "', "
                  << file(autos) << " with points pointtype 7 pointsize 1.1 linecolor '"
                  << hue(1).hex() << "'\nunset logscale\nunset grid\nunset xlabel\nunset border\n";
  }

  void name_points(std::size_t p) {
    const Box box = box_of(p);
    canvas_.label(names_[p], (box.left + box.right) / 2, top - 14, 11, "center");
    std::vector<PointLabel> labels;
    std::vector<Box> taken;
    const auto y = [&](double value) { return box.bottom - errors_.share(value) * panel_height; };
    for (const FidelityRow& row : rows_) {
      if (row.dataset != names_[p] || row.scenes != "all") continue;
      const double error = std::max(row.error_median, errors_.low);
      const bool automatic = row.model == "auto";
      const double x = box.left + times_.share(row.time_us) * panel_width;
      labels.push_back({automatic ? "auto" : row.model, x, y(error)});
      taken.push_back({x - 4, y(row.error_max), x + 4, y(error) + 4});
      taken.push_back({box.left + times_.share(row.time_low) * panel_width, y(error) - 3,
                       box.left + times_.share(row.time_high) * panel_width, y(error) + 3});
      canvas_.tooltip_at(x, y(error),
                         row.model + (automatic ? "" : " grid") + "\n" + time_text(row.time_us) +
                             " a scene\nerror: median " + three_digits(row.error_median) +
                             ", 95 % " + three_digits(row.error_p95) + ", largest " +
                             three_digits(row.error_max) + " of the noise");
    }
    const auto places = place_labels(labels, 10, box, taken);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (!places[i]) continue;
      const Box& place = places[i]->box;
      canvas_.label(labels[i].text, (place.left + place.right) / 2, (place.top + place.bottom) / 2,
                    10, "center front");
    }
  }

  /// Stacked bars: which share of the scenes needs how many points.
  void sizes(std::size_t p) {
    double y = bar_top;
    for (const char* scenes : {"smooth", "other", "all"}) {
      for (const FidelityRow& row : rows_) {
        if (row.dataset != names_[p] || row.scenes != scenes || row.sizes.empty()) continue;
        canvas_.label(row.scenes, left(p) + 40, y + bar_height / 2.0 - 2, 9, "right");
        double x = left(p) + 46;
        const double room = panel_width - 46;
        for (std::size_t s = 0; s < row.sizes.size(); ++s) {
          const double width = room * row.sizes[s] / row.count;
          if (width <= 0) continue;
          canvas_.rectangle(x, y, width, bar_height - 5,
                            "fillcolor rgb '" + shade(s).hex() + "' fillstyle solid noborder");
          const std::string share = fixed(100.0 * row.sizes[s] / row.count, 0);
          if (width > 22) {
            canvas_.label(share + " %", x + width / 2, y + (bar_height - 5) / 2.0, 8,
                          std::string("center front textcolor '") +
                              (shade(s).lightness() > 0.55 ? "#000000'" : "#ffffff'"));
          }
          x += width;
        }
        y += bar_height;
      }
    }
  }

  static Colour shade(std::size_t size) {
    return viridis(1 - static_cast<double>(size) / static_cast<double>(std::size(fidelity_sizes)));
  }

  void legend() {
    canvas_.label("Share of the scenes of \"auto\" by points of the border equation:", left_margin,
                  bar_top - 16, 10, "left");
    double x = left_margin + 350;
    for (std::size_t s = 0; s <= std::size(fidelity_sizes); ++s) {
      const std::string text =
          s < std::size(fidelity_sizes) ? "≤ " + std::to_string(fidelity_sizes[s]) : "more";
      canvas_.rectangle(x, bar_top - 21, 12, 10,
                        "fillcolor rgb '" + shade(s).hex() + "' fillstyle solid noborder");
      canvas_.label(text, x + 16, bar_top - 16, 9, "left");
      x += 58;
    }
    const double y = height - 36;
    canvas_.label(
        "Points: medians; whiskers up to the largest error, and from 5 to 95 % of the "
        "times. Dashed: the bound that \"auto\" promises.",
        left_margin, y, 9, "left textcolor '#404040'");
    canvas_.label(
        "smooth: whole discs and ellipses apart from each other; other: corners, "
        "overlaps, contacts cut by the border of the sheet.",
        left_margin, y + 16, 9, "left textcolor '#404040'");
  }

  std::string file(const std::ostringstream& text) {
    const std::string name = "points" + std::to_string(files_.size()) + ".txt";
    files_[name] = text.str();
    return "'" + name + "'";
  }

  const std::vector<FidelityRow>& rows_;
  const std::string& title_;
  std::vector<std::string> names_;
  Canvas canvas_;
  Range times_{1, 1};
  Range errors_{1, 1};
  FileContents files_;
};

}  // namespace

void draw_fidelity_chart(const std::vector<FidelityRow>& rows, const std::string& title,
                         const std::filesystem::path& stem) {
  Drawing(rows, title).draw(stem);
}

}  // namespace ertbench
