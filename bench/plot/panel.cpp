#include "bench/plot/panel.h"

#include <algorithm>

#include "core/text_stream.h"

namespace ertbench {
namespace {

/// gnuplot's own error bars leave a white spot at their point.
const std::string whisker_ends =
    "using 1:2:3:4 with vectors heads size screen 0.003,90 fixed nofilled ";

/// Rows of numbers.
class Data {
 public:
  Data() { out_.precision(10); }
  void row(std::initializer_list<double> values) {
    for (const double value : values) out_ << value << ' ';
    out_ << '\n';
  }
  std::string text() const { return out_.str(); }

 private:
  TextStream out_;
};

std::string text_of(const Points& points) {
  Data data;
  for (const auto& [x, y] : points) data.row({x, y});
  return data.text();
}

/// gnuplot prints a tick's text by a number's format.
std::string as_format(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '%' ? "%%" : std::string(1, c);
  return out;
}

/// gnuplot's commands for the axis "x" or "y".
std::string commands(const Axis& axis, const std::string& name) {
  TextStream out;
  out.precision(10);
  out << (axis.logarithmic ? "set logscale " : "unset logscale ") << name << "\nset " << name
      << "range [" << axis.low << ":" << axis.high << "]\n";
  if (axis.ticks.empty()) {
    out << "unset " << name << "tics\n";
  } else {
    out << "set " << name << "tics (";
    for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
      const Tick& tick = axis.ticks[i];
      out << (i > 0 ? ", " : "") << gnuplot_string(as_format(tick.text)) << " " << tick.value;
    }
    out << ")" << (axis.slanted ? " rotate by 45 right" : " norotate") << "\n";
    if (axis.grid) {
      out << "set grid " << name << "tics linetype 1 linecolor '#e4e4e4' linewidth 0.6\n";
    }
  }
  return out.str();
}

std::string label(const Axis& axis, const std::string& name, const std::string& offset) {
  if (axis.title.empty()) return "";
  return "set " + name + "label " + gnuplot_string(axis.title) + " offset " + offset + "\n";
}

/// How far gnuplot's place of the upright axis's title is moved to the right, in characters. It
/// leaves room for the ticks by their characters' number, which is more than long numbers need.
std::string title_offset(const Axis& y) {
  std::size_t most = 0;
  for (const Tick& tick : y.ticks) most = std::max(most, character_count(tick.text));
  return most < 3 ? "0.3,0" : most == 3 ? "0.6,0" : "1,0";
}

}  // namespace

Panel::Panel(Canvas& canvas, const Box& box, Axis x, Axis y)
    : canvas_(canvas), box_(box), x_(std::move(x)), y_(std::move(y)) {}

void Panel::title(const std::string& text) {
  canvas_.text(text, box_.middle(), box_.top - 12, {.size = 11});
}

void Panel::add(const std::string& data, const std::string& style) {
  if (data.empty()) return;
  plots_ += canvas_.data(data) + " " + style + ", ";
}

void Panel::line(const Points& points, const LineStyle& style) {
  add(text_of(points), "using 1:2 with lines " + style.text());
}

void Panel::marks(const Points& points, const MarkStyle& style) {
  add(text_of(points), "using 1:2 with points " + style.text());
}

void Panel::level(double value, const LineStyle& style) {
  line({{x_.low, value}, {x_.high, value}}, style);
}

void Panel::band(double low, double high, const Colour& colour) {
  Data data;
  for (const double x : {x_.low, x_.high}) data.row({x, low, high});
  add(data.text(),
      "using 1:2:3 with filledcurves fillstyle solid linecolor rgb '" + colour.hex() + "'");
}

void Panel::whiskers(const std::vector<Whisker>& whiskers, const LineStyle& style) {
  Data data;
  for (const Whisker& one : whiskers) data.row({one.at, one.low, 0, one.high - one.low});
  add(data.text(), whisker_ends + style.text());
}

void Panel::whiskers_across(const std::vector<Whisker>& whiskers, const LineStyle& style) {
  Data data;
  for (const Whisker& one : whiskers) data.row({one.low, one.at, one.high - one.low, 0});
  add(data.text(), whisker_ends + style.text());
}

void Panel::bars(const std::vector<Bar>& bars, double width) {
  Data data;
  for (const Bar& bar : bars) {
    data.row({bar.x, bar.height, width, static_cast<double>(bar.colour.number())});
  }
  add(data.text(),
      "using 1:2:3:4 with boxes fillstyle solid border linecolor 'black' linewidth 0.6 linecolor "
      "rgb variable");
}

void Panel::labels(const std::vector<PointLabel>& labels, const std::vector<Box>& taken,
                   const std::vector<Segment>& lines) {
  constexpr int size = 10;
  const auto places = place_labels(labels, size, box_, taken, lines);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!places[i]) continue;
    const Box& place = places[i]->box;
    if (places[i]->leader) {
      const Segment leader = leader_of(labels[i], place);
      canvas_.line(leader.x1, leader.y1, leader.x2, leader.y2,
                   {labels[i].colour.towards_white(0.45), 0.6});
    }
    canvas_.text(labels[i].text, place.middle(), place.centre(),
                 {.size = size, .colour = labels[i].colour});
  }
}

void Panel::tooltip(double x_value, double y_value, std::string text) {
  canvas_.tooltip_at(x(x_value), y(y_value), std::move(text));
}

void Panel::draw() {
  canvas_.area(box_);
  canvas_.plots() << "unset key\nset border 3 linecolor '#606060'\n"
                  << "set tics nomirror scale 0.5 font ',10'\n"
                  << commands(x_, "x") << commands(y_, "y") << label(x_, "x", "0,0.3")
                  << label(y_, "y", title_offset(y_)) << "plot " << plots_ << "NaN notitle\n"
                  << "unset logscale\nunset grid\nunset xlabel\nunset ylabel\nunset border\n";
}

}  // namespace ertbench
