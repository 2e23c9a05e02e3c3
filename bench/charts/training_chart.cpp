#include "bench/charts/training_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "bench/plot/axis_ticks.h"
#include "bench/plot/canvas.h"
#include "bench/plot/gnuplot.h"
#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr int kWidth = 720;
constexpr int kHeight = 480;
constexpr int kLeft = 72;
constexpr int kPanelWidth = 480;
constexpr int kKeyLeft = kLeft + kPanelWidth + 12;

/// The columns of one panel, over all runs, in the order in which they first come.
std::vector<std::string> columns_of(const TrainingChart& chart, bool validation) {
  std::vector<std::string> out;
  for (const TrainingRun& run : chart.runs) {
    for (const std::string& name : run.curves.columns) {
      const bool other = name == "epoch" || name == "learning_rate" || name == "seconds";
      if (other || name.starts_with("validation") != validation) continue;
      if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
    }
  }
  return out;
}

const std::vector<double>* find_column(const TrainingCurves& curves, const std::string& name) {
  const auto found = std::find(curves.columns.begin(), curves.columns.end(), name);
  if (found == curves.columns.end()) return nullptr;
  return &curves.values[static_cast<std::size_t>(found - curves.columns.begin())];
}

bool any_negative(const TrainingChart& chart, const std::string& name) {
  return std::any_of(chart.runs.begin(), chart.runs.end(), [&](const TrainingRun& run) {
    const auto* values = find_column(run.curves, name);
    return values && std::any_of(values->begin(), values->end(), [](double v) { return v < 0; });
  });
}

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// One panel: its curves and data files.
class Panel {
 public:
  Panel(const TrainingChart& chart, bool validation, FileContents& files)
      : chart_(chart), validation_(validation), files_(files) {}

  void plot(Canvas& canvas, double top, double height) {
    collect();
    canvas.area(kLeft, top, kPanelWidth, height);
    canvas.label(validation_ ? "validation error" : "loss", 14, top + height / 2, 11,
                 "center rotate by 90");
    std::ostream& out = canvas.out();
    if (curves_.empty()) {
      canvas.label(validation_ ? "the log has no validation error" : "the log has no loss",
                   kLeft + kPanelWidth / 2.0, top + height / 2, 11, "center");
      out << "unset key\nset xrange [0:1]\nset yrange [0:1]\nunset tics\nplot NaN notitle\n"
          << "unset label\n";
      return;
    }
    const double range = epochs_.high - epochs_.low;
    const double slack = std::max(0.02 * range, 0.25);
    if (range <= 12) out << "set xtics 1\n";
    const Span across{epochs_.low - slack, epochs_.high + slack};
    out << "set xrange [" << across.low << ":" << across.high << "]\n";
    set_range(out);
    out << "set key at " << canvas.screen(kKeyLeft, top) << " left top Left reverse samplen 2.5\n";
    std::string all;
    for (const std::string& curve : curves_) all += (all.empty() ? "" : ", ") + curve;
    out << "plot " << all << "\nunset label\n";
    add_tooltips(canvas, across, top, height);
  }

 private:
  /// A strip for each epoch with all values of it; of many epochs for some.
  void add_tooltips(Canvas& canvas, const Span& across, double top, double height) const {
    constexpr std::size_t most = 160;
    const std::size_t every = (texts_.size() + most - 1) / most;
    std::vector<std::pair<double, std::string>> shown;
    std::size_t index = 0;
    for (const auto& [epoch, text] : texts_) {
      if (index++ % every != 0) continue;
      const double place = (epoch - across.low) / (across.high - across.low);
      shown.emplace_back(kLeft + kPanelWidth * place, "epoch " + number_text(epoch) + text);
    }
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const double x = shown[i].first;
      const double left = i == 0 ? kLeft : (shown[i - 1].first + x) / 2;
      const double right =
          i + 1 == shown.size() ? kLeft + kPanelWidth : (x + shown[i + 1].first) / 2;
      canvas.tooltip(left, top, right - left, height, shown[i].second);
    }
  }

  void set_range(std::ostream& out) {
    Span shown = values_;
    if (validation_) {
      const double margin = std::max(0.06 * (shown.high - shown.low), 0.02 * std::abs(shown.high));
      out << "unset logscale y\nset ytics autofreq\nset yrange [" << shown.low - margin << ":"
          << shown.high + margin << "]\n";
      return;
    }
    const double margin = std::max(1.06, std::sqrt(1.3 * shown.low / shown.high));
    shown = {shown.low / margin, shown.high * margin};
    out << "set logscale y\nset yrange [" << shown.low << ":" << shown.high << "]\nset ytics ("
        << tick_list(log_ticks(shown)) << ")\n";
  }

  void collect() {
    std::size_t index = 0;
    for (const std::string& name : columns_of(chart_, validation_)) {
      const bool absolute = !validation_ && any_negative(chart_, name);
      std::string title = spaced(name) + (absolute ? ", absolute" : "");
      for (std::size_t r = 0; r < chart_.runs.size(); ++r) {
        const std::string file = write(chart_.runs[r], name);
        if (file.empty()) continue;
        const Colour base = validation_ ? Colour{} : hue(index);
        const double step = chart_.runs.size() > 1 ? 0.6 / double(chart_.runs.size() - 1) : 0;
        const std::string colour = "'" + base.towards_white(step * double(r)).hex() + "'";
        // A few marks on each line, so that the losses can be told apart in grey.
        const auto epochs = static_cast<int>(chart_.runs[r].curves.epochs());
        const std::string marks =
            validation_ && epochs > 2
                ? "lines"
                : "linespoints pointtype " + std::to_string(4 + 2 * (index % 5)) +
                      " pointsize 0.45 pointinterval " + std::to_string(std::max(1, epochs / 8));
        curves_.push_back("'" + file + "' using 1:2 with " + marks +
                          " linewidth 1.3 linecolor rgb " + colour +
                          (title.empty() ? " notitle" : " title " + gnuplot_string(title)));
        title.clear();
        if (validation_ && name == "validation_error") mark_kept(r, colour);
      }
      ++index;
    }
  }

  /// The file of a curve; empty where nothing of it can be drawn.
  std::string write(const TrainingRun& run, const std::string& name) {
    const std::vector<double>* column = find_column(run.curves, name);
    std::string text;
    bool any = false;
    for (std::size_t i = 0; column && i < column->size(); ++i) {
      const double epoch = run.curves.values.front()[i];
      const double value = validation_ ? (*column)[i] : std::abs((*column)[i]);
      const bool drawn = std::isfinite(epoch) && std::isfinite(value) && (validation_ || value > 0);
      if (drawn) {
        epochs_.extend(epoch);
        values_.extend(value);
        any = true;
        texts_[epoch] += "\n" + run.title + (run.title.empty() ? "" : ", ") + spaced(name) + ": " +
                         number_text((*column)[i]) + (run.kept_epoch == epoch ? " (kept)" : "");
      }
      text += number(epoch) + " " + (drawn ? number(value) : "NaN") + "\n";
    }
    if (!any) return "";
    std::string file = "curve" + std::to_string(files_.size()) + ".txt";
    files_[file] = text;
    return file;
  }

  void mark_kept(std::size_t run, const std::string& colour) {
    const auto& kept = chart_.runs[run].kept_epoch;
    if (!kept) return;
    const auto* errors = find_column(chart_.runs[run].curves, "validation_error");
    const auto& epochs = chart_.runs[run].curves.values.front();
    const auto found = std::find(epochs.begin(), epochs.end(), *kept);
    if (found == epochs.end()) return;
    const double error = (*errors)[static_cast<std::size_t>(found - epochs.begin())];
    const std::string file = "kept" + std::to_string(files_.size()) + ".txt";
    files_[file] = number(*kept) + " " + number(error) + "\n";
    curves_.push_back("'" + file + "' using 1:2 with points pointtype 7 pointsize 0.7 " +
                      "linecolor rgb " + colour +
                      (first_mark_ ? " title 'epoch kept'" : " notitle"));
    first_mark_ = false;
  }

  static std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.10g", value);
    return text;
  }

  const TrainingChart& chart_;
  bool validation_;
  FileContents& files_;
  std::vector<std::string> curves_;
  std::map<double, std::string> texts_;  ///< by epoch: a line for each value
  Span epochs_;
  Span values_;
  bool first_mark_ = true;
};

std::string runs_text(const TrainingChart& chart) {
  std::string out;
  for (const TrainingRun& run : chart.runs) out += (out.empty() ? "" : ", ") + run.title;
  return out + ": dark to light";
}

}  // namespace

void draw_training_chart(const TrainingChart& chart, const std::filesystem::path& stem) {
  constexpr double top = 34;
  constexpr double loss_height = 215;
  constexpr double gap = 18;
  constexpr double bottom = kHeight - 44;
  FileContents files;
  Canvas canvas(kWidth, kHeight);
  canvas.out()
      << "set multiplot\nset border linecolor '#404040'\nset tics font ',10'\n"
      << "set key font ',10'\nset grid ytics linetype 1 linecolor '#d8d8d8' linewidth 0.6\n"
      << "set format x ''\n";
  canvas.label(one_line(chart.title, 80), kLeft + kPanelWidth / 2.0, 16, 12, "center");
  Panel(chart, false, files).plot(canvas, top, loss_height);
  const double below = top + loss_height + gap;
  canvas.label("epoch", kLeft + kPanelWidth / 2.0, kHeight - 14, 11, "center");
  if (chart.runs.size() > 1) {
    double y = below + 64;
    for (const std::string& line : wrapped(runs_text(chart), 24)) {
      canvas.label(line, kKeyLeft + 6, y, 10, "left");
      y += 13;
    }
  }
  canvas.out() << "set format x '%g'\nset xtics autofreq\n";
  Panel(chart, true, files).plot(canvas, below, bottom - below);
  canvas.out() << "unset multiplot\n";
  canvas.draw(files, stem);
}

}  // namespace ertbench
