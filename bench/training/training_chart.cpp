#include "bench/training/training_chart.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "bench/plot/canvas.h"
#include "bench/plot/panel.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {

TrainingCurves read_training_curves(const std::filesystem::path& file) {
  const std::string text = contents_of(file);
  // What stands behind the last line end is still being written, or was cut off.
  std::vector<std::vector<std::string>> lines =
      csv_lines(std::string_view(text).substr(0, text.find_last_of('\n') + 1));
  std::erase(lines, std::vector<std::string>{""});
  TrainingCurves curves;
  if (!lines.empty()) curves.columns = lines.front();
  if (curves.columns.empty() || curves.columns.front() != "epoch") {
    throw InputError(file.string() + ": line 1: must name the columns, \"epoch\" first");
  }
  curves.values.resize(curves.columns.size());
  for (std::size_t l = 1; l < lines.size(); ++l) {
    const auto fail = [&](const std::string& what) {
      throw InputError(file.string() + ": line " + std::to_string(l + 1) + ": " + what);
    };
    const std::vector<std::string>& fields = lines[l];
    if (fields.size() != curves.columns.size()) {
      fail("must hold " + std::to_string(curves.columns.size()) + " numbers, holds " +
           std::to_string(fields.size()));
    }
    for (std::size_t c = 0; c < fields.size(); ++c) {
      char* end = nullptr;
      const double value = std::strtod(fields[c].c_str(), &end);
      if (fields[c].empty() || *end != '\0')
        fail("\"" + printable(fields[c]) + "\" is not a number");
      curves.values[c].push_back(value);
    }
  }
  return curves;
}

namespace {

namespace fs = std::filesystem;

// Places and sizes in px.
constexpr int chart_width = 760;
constexpr double panels_left = 72;
constexpr double panels_right = 552;
constexpr double key_left = 564;
constexpr double top = 34;
constexpr double gap = 18;     ///< between two panels
constexpr double bottom = 44;  ///< below the last, for the epochs

/// The panels of the figure.
enum class Group { losses, shares, validation };

struct GroupLook {
  double height;
  const char* title;
};

/// In the order of Group.
constexpr GroupLook looks[] = {{215, "loss"}, {110, "judged right"}, {169, "validation error"}};

const GroupLook& look_of(Group group) { return looks[static_cast<std::size_t>(group)]; }

Group group_of(const std::string& column) {
  if (column.starts_with("validation")) return Group::validation;
  return column.starts_with("discriminator_right") ? Group::shares : Group::losses;
}

/// The columns of one panel over all runs, in the order of their first occurrence.
std::vector<std::string> columns_of(const TrainingChart& chart, Group group) {
  std::vector<std::string> out;
  for (const TrainingRun& run : chart.runs) {
    for (const std::string& name : run.curves.columns) {
      const bool other = name == "epoch" || name == "learning_rate" || name == "seconds";
      if (other || group_of(name) != group) continue;
      if (std::ranges::find(out, name) == out.end()) out.push_back(name);
    }
  }
  return out;
}

const std::vector<double>* find_column(const TrainingCurves& curves, const std::string& name) {
  const auto found = std::ranges::find(curves.columns, name);
  if (found == curves.columns.end()) return nullptr;
  return &curves.values[static_cast<std::size_t>(found - curves.columns.begin())];
}

bool any_negative(const TrainingChart& chart, const std::string& name) {
  return std::ranges::any_of(chart.runs, [&](const TrainingRun& run) {
    const auto* values = find_column(run.curves, name);
    return values && std::ranges::any_of(*values, [](double v) { return v < 0; });
  });
}

/// One column of one run.
struct Curve {
  Points points;
  LineStyle line;
  MarkStyle mark;
  bool marked = false;  ///< draw a few marks on the line, to distinguish losses in grey
};

/// The content of one panel.
class Curves {
 public:
  Curves(const TrainingChart& chart, Group group) : chart_(chart), group_(group) {
    std::size_t index = 0;
    for (const std::string& name : columns_of(chart, group)) add(name, index++);
    if (!kept_.empty()) legend_.add({"epoch kept", {}, dot(kept_.front().second)});
  }

  void draw(Canvas& canvas, const Box& box) const {
    if (curves_.empty()) {
      canvas.text(std::string("the log has no ") + look_of(group_).title, box.middle(),
                  box.centre(), {.size = 11});
      return;
    }
    const Axis across = epoch_axis();
    Panel panel(canvas, box, across, value_axis());
    if (group_ == Group::shares) {  // the level of chance
      panel.line({{across.low, 0.5}, {across.high, 0.5}}, {ink::light, 1, 3});
    }
    for (const Curve& curve : curves_) {
      panel.line(curve.points, curve.line);
      if (curve.marked) panel.marks(some_of(curve.points), curve.mark);
    }
    for (const auto& [point, colour] : kept_) panel.marks({point}, dot(colour));
    panel.draw();
    legend_.draw(canvas, box.top + 8);
  }

 private:
  static MarkStyle dot(const Colour& colour) { return {filled(0), colour, 0.7}; }

  static Points some_of(const Points& points) {
    const std::size_t every = std::max<std::size_t>(1, points.size() / 8);
    Points out;
    for (std::size_t i = 0; i < points.size(); i += every) out.push_back(points[i]);
    return out;
  }

  void add(const std::string& name, std::size_t index) {
    const bool absolute = group_ == Group::losses && any_negative(chart_, name);
    bool named = false;
    for (std::size_t r = 0; r < chart_.runs.size(); ++r) {
      const TrainingRun& run = chart_.runs[r];
      const Points points = points_of(run, name);
      if (points.empty()) continue;
      const Colour base = group_ == Group::validation ? ink::black : hue(index);
      const double step = chart_.runs.size() > 1 ? 0.6 / double(chart_.runs.size() - 1) : 0;
      const Colour colour = base.towards_white(step * double(r));
      const bool marked = group_ != Group::validation || points.size() <= 2;
      const Curve curve{points, {colour, 1.3}, {hollow(index), colour, 0.45}, marked};
      if (!named) {
        legend_.add({replaced(name, "_", " ") + (absolute ? ", absolute" : ""), curve.line,
                     marked ? std::optional(curve.mark) : std::nullopt});
      }
      named = true;
      curves_.push_back(curve);
      if (!run.kept_epoch || name != "validation_error") continue;
      for (const auto& point : points) {
        if (point.first == *run.kept_epoch) kept_.emplace_back(point, colour);
      }
    }
  }

  /// The finite values, without zeros on a logarithmic axis.
  Points points_of(const TrainingRun& run, const std::string& name) {
    constexpr double most = 1e100;  // limit of the axes
    Points points;
    const std::vector<double>* column = find_column(run.curves, name);
    for (std::size_t i = 0; column && i < column->size(); ++i) {
      const double epoch = run.curves.values.front()[i];
      const bool loss = group_ == Group::losses;
      const double value = loss ? std::abs((*column)[i]) : (*column)[i];
      if (!(std::abs(epoch) < most) || !(std::abs(value) < most)) continue;
      if (loss && value < 1 / most) continue;
      epochs_.extend(epoch);
      values_.extend(value);
      points.emplace_back(epoch, value);
    }
    return points;
  }

  Axis epoch_axis() const {
    const double slack = std::max(0.02 * (epochs_.high - epochs_.low), 0.25);
    Axis axis = Axis::even({epochs_.low - slack, epochs_.high + slack});
    std::erase_if(axis.ticks,
                  [](const Tick& tick) { return tick.value != std::round(tick.value); });
    axis.grid = false;
    if (group_ != Group::validation) {
      for (Tick& tick : axis.ticks) tick.text.clear();
    }
    return axis;
  }

  Axis value_axis() const {
    Span shown = values_;
    if (group_ == Group::shares) return Axis::even({-0.05, 1.05});
    if (group_ == Group::validation) {
      const double spread = shown.high - shown.low;
      const double margin = std::max({0.06 * spread, 0.02 * std::abs(shown.high), 1e-6});
      return Axis::even({shown.low - margin, shown.high + margin});
    }
    const double margin = std::max(1.06, std::sqrt(1.3 * shown.low / shown.high));
    return Axis::logarithms({shown.low / margin, shown.high * margin});
  }

  const TrainingChart& chart_;
  Group group_;
  std::vector<Curve> curves_;
  std::vector<std::pair<std::pair<double, double>, Colour>> kept_;
  Span epochs_;
  Span values_;
  Legend legend_{key_left, chart_width, 1};
};

std::optional<double> best_epoch(const nlohmann::json& parameters) {
  const nlohmann::json::json_pointer place("/training/best_epoch");
  if (!parameters.contains(place) || !parameters.at(place).is_number()) return std::nullopt;
  return parameters.at(place).get<double>();
}

/// The log of a training with control characters removed: a plugin may have written it.
std::string harmless_csv(const fs::path& file) {
  require_regular_file(file);
  const std::string text = contents_of(file);
  std::string out;
  for (const std::vector<std::string>& line : csv_lines(text)) {
    for (std::size_t c = 0; c < line.size(); ++c) {
      out += (c > 0 ? "," : "") + csv_field(printable(line[c]));
    }
    out += "\n";
  }
  return out;
}

}  // namespace

void draw_training_chart(const TrainingChart& chart, const std::filesystem::path& stem) {
  std::vector<std::pair<Group, Box>> panels;
  double y = top;
  for (const Group group : {Group::losses, Group::shares, Group::validation}) {
    if (group == Group::shares && columns_of(chart, group).empty()) continue;
    panels.emplace_back(group, Box{panels_left, y, panels_right, y + look_of(group).height});
    y += look_of(group).height + gap;
  }
  const Box last = panels.back().second;
  const double height = last.bottom + bottom;
  Canvas canvas(chart_width, height);
  canvas.title(chart.title);
  for (const auto& [group, box] : panels) {
    Curves(chart, group).draw(canvas, box);
    canvas.text(look_of(group).title, 14, box.centre(), {.size = 11, .upright = true});
  }
  canvas.text("epoch", last.middle(), height - 14, {.size = 11});
  if (chart.runs.size() > 1) {
    y = last.top + 64;
    const std::string runs = joined(chart.runs, ", ", &TrainingRun::title) + ": dark to light";
    for (const std::string& line : wrapped(runs, 24)) {
      canvas.text(line, key_left + 6, y, {.align = TextAlign::left});
      y += 13;
    }
  }
  canvas.draw(stem);
}

std::optional<ReportFigure> write_training_results(const std::string& label,
                                                   const std::vector<TrainingSource>& sources,
                                                   const fs::path& folder) {
  TrainingChart chart;
  chart.title = label;
  for (const TrainingSource& source : sources) {
    if (!fs::exists(source.log)) continue;
    fs::create_directories(folder);
    try {
      write_file_atomically(folder / (source.stem + ".csv"), harmless_csv(source.log));
      chart.runs.push_back(
          {source.title, read_training_curves(source.log), best_epoch(*source.parameters)});
    } catch (const InputError& error) {
      spdlog::warn("{}: {}", source.stem, error.what());
    }
  }
  if (chart.runs.empty()) return std::nullopt;
  const bool drawn =
      draw_or_say(folder / label, [&] { draw_training_chart(chart, folder / label); });
  return ReportFigure{label, folder / (label + ".svg"),
                      "losses and validation error; dots mark the epochs that were kept", drawn};
}

}  // namespace ertbench
