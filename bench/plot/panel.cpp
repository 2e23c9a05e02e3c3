#include "bench/plot/panel.h"

#include <cmath>

#include "core/text.h"

namespace ertbench {
namespace {

std::vector<Tick> named(const std::vector<double>& values) {
  std::vector<Tick> ticks;
  for (const double value : values) ticks.push_back({value, number_text(value)});
  return ticks;
}

constexpr double gap_below = 6;  ///< below the panel, px
constexpr int name_size = 9;     ///< of a category's name

bool fits(const std::string& name, double slot) {
  constexpr std::size_t most_lines = 4;
  return widest_word(name, name_size) <= slot &&
         wrapped(name, characters_in(slot, name_size)).size() <= most_lines;
}

constexpr int size = 10;
constexpr double entry_gap = 16;  ///< between two entries, px

/// Width of the symbol before the text, px.
double sample_width(const LegendEntry& entry) {
  if (entry.line) return entry.mark && entry.line->dash > 1 ? 46 : 34;
  if (entry.mark || entry.fill) return 13;
  return 0;
}

double text_left(const LegendEntry& entry) {
  const double sample = sample_width(entry);
  return sample > 0 ? sample + 6 : 0;
}

/// gnuplot's own error bars leave a white spot at their point.
const std::string whisker_ends =
    "using 1:2:3:4 with vectors heads size screen 0.003,90 fixed nofilled ";

using Rows = std::vector<std::vector<double>>;

Rows rows_of(const Points& points) {
  Rows rows;
  for (const auto& [x, y] : points) rows.push_back({x, y});
  return rows;
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

double round_step(double span, int ticks) {
  const double power = std::pow(10.0, std::floor(std::log10(span / ticks)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= span / ticks * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::vector<double> even_ticks(const Span& span, int ticks) {
  std::vector<double> out;
  const double step = round_step(span.high - span.low, ticks);
  const double first = std::ceil(span.low / step - 1e-9);
  const double last = std::floor(span.high / step + 1e-9);
  // Spans whose ends are nearly equal have no ticks between them.
  constexpr double most = 1e15;
  constexpr int most_ticks = 1000;
  if (!(std::abs(first) < most && last - first < most_ticks)) return out;
  const int count = static_cast<int>(last - first) + 1;
  for (int k = 0; k < count; ++k) {
    const double i = first + k;
    out.push_back(i == 0 ? 0 : i * step);  // never minus zero
  }
  return out;
}

std::vector<double> log_ticks(const Span& span) {
  const double decades = std::log10(span.high / span.low);
  if (decades < 0.7) return even_ticks(span, 6);
  std::vector<double> ticks;
  const int every = std::max(1, static_cast<int>(std::ceil(decades / 8)));
  const int first = static_cast<int>(std::floor(std::log10(span.low)));
  for (int power = first; std::pow(10.0, power) <= span.high; ++power) {
    if (power % every != 0) continue;
    for (const double digit : decades > 3 ? std::vector{1.0} : std::vector{1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, power);
      if (value >= span.low && value <= span.high) ticks.push_back(value);
    }
  }
  return ticks;
}

std::vector<Tick> time_ticks() {
  return {{0.1, "0.1 µs"}, {1, "1 µs"},     {10, "10 µs"}, {100, "100 µs"}, {1e3, "1 ms"},
          {1e4, "10 ms"},  {1e5, "100 ms"}, {1e6, "1 s"},  {1e7, "10 s"},   {1e8, "100 s"}};
}

std::vector<Tick> rate_ticks() {
  return {{0.1, "0.1"},  {1, "1"},       {10, "10"},   {100, "100"}, {1e3, "1 k"},
          {1e4, "10 k"}, {1e5, "100 k"}, {1e6, "1 M"}, {1e7, "10 M"}};
}

Axis Axis::even(const Span& span, std::string title) {
  return {span.low, span.high, false, named(even_ticks(span, 8)), std::move(title)};
}

Axis Axis::logarithms(const Span& span, std::string title) {
  return {span.low, span.high, true, named(log_ticks(span)), std::move(title)};
}

double Axis::share(double value) const {
  if (logarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

void Axis::cap() {
  constexpr double room = 0.05;  // of the axis, between two ticks
  while (!ticks.empty() && share(ticks.back().value) > 1 - room) ticks.pop_back();
  ticks.push_back({high, "≥ " + number_text(high)});
}

double widest_word(const std::string& text, int size) {
  double widest = 0;
  std::string word;
  for (const char c : text + " ") {
    if (c != ' ') word += c;
    if (c != ' ' && c != '-' && c != '_') continue;
    widest = std::max(widest, text_width(word, size));
    word.clear();
  }
  return widest;
}

CategoryNames::CategoryNames(std::vector<std::string> names, double slot)
    : names_(std::move(names)),
      slot_(slot),
      upright_(std::ranges::any_of(names_,
                                   [&](const std::string& name) { return !fits(name, slot); })) {}

double CategoryNames::height() const {
  double most = 0;
  for (const std::string& name : names_) {
    const auto lines = static_cast<double>(wrapped(name, characters_in(slot_, name_size)).size());
    most = std::max(most, upright_ ? text_width(name, name_size) : lines * (name_size + 2));
  }
  return gap_below + most;
}

void CategoryNames::draw(Canvas& canvas, double left, double bottom) const {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const double x = left + (static_cast<double>(i) + 0.5) * slot_;
    if (upright_) {
      canvas.text(names_[i], x, bottom + gap_below,
                  {.size = name_size, .align = TextAlign::right, .upright = true});
    } else {
      canvas.lines(names_[i], characters_in(slot_, name_size), x,
                   bottom + gap_below + name_size / 2.0, {.size = name_size});
    }
  }
}

Legend::Legend(double left, double right, std::optional<int> columns)
    : left_(left), right_(right), columns_(columns) {}

void Legend::add(LegendEntry entry) {
  double width = text_left(entry) + text_width(entry.text, size) + entry_gap;
  if (columns_) {
    const double column = (right_ - left_) / *columns_;
    const double taken = std::ceil((width - entry_gap + 4) / column);
    width = column * std::clamp<double>(taken, 1, *columns_);
    entry.text = one_line(entry.text, characters_in(width - text_left(entry) - 4, size));
  }
  const bool fits = left_ + next_ + width <= right_ + (columns_ ? 1 : entry_gap);
  if (next_ > 0 && (broken_ || !fits)) {
    next_ = 0;
    ++line_;
  }
  broken_ = false;
  entries_.push_back({std::move(entry), left_ + next_, line_});
  next_ += width;
}

void Legend::draw(Canvas& canvas, double top) const {
  for (const Place& place : entries_) {
    const LegendEntry& entry = place.entry;
    const double y = top + line_height * place.line;
    const double sample = sample_width(entry);
    if (entry.line && entry.mark) {  // from the mark on, so that both sides show the same dashes
      canvas.line(place.left + sample / 2, y, place.left, y, *entry.line);
      canvas.line(place.left + sample / 2, y, place.left + sample, y, *entry.line);
    } else if (entry.line) {
      canvas.line(place.left, y, place.left + sample, y, *entry.line);
    }
    if (entry.fill)
      canvas.rectangle({place.left, y - 5, place.left + 12, y + 5}, {.fill = entry.fill});
    if (entry.mark) canvas.mark(place.left + sample / 2, y, *entry.mark);
    canvas.text(entry.text, place.left + text_left(entry), y,
                {.size = size, .align = TextAlign::left});
  }
}

Panel::Panel(Canvas& canvas, const Box& box, Axis x, Axis y)
    : canvas_(canvas), box_(box), x_(std::move(x)), y_(std::move(y)) {}

void Panel::title(const std::string& text) {
  canvas_.text(text, box_.middle(), box_.top - 12, {.size = 11});
}

void Panel::add(const std::vector<std::vector<double>>& rows, const std::string& style) {
  if (rows.empty()) return;
  TextStream data;
  data.precision(10);
  for (const std::vector<double>& row : rows) {
    for (const double value : row) data << value << ' ';
    data << '\n';
  }
  plots_ += canvas_.data(data.str()) + " " + style + ", ";
}

void Panel::line(const Points& points, const LineStyle& style) {
  add(rows_of(points), "using 1:2 with lines " + style.text());
}

void Panel::marks(const Points& points, const MarkStyle& style) {
  add(rows_of(points), "using 1:2 with points " + style.text());
}

void Panel::level(double value, const LineStyle& style) {
  line({{x_.low, value}, {x_.high, value}}, style);
}

void Panel::band(double low, double high, const Colour& colour) {
  band({{x_.low, low, high}, {x_.high, low, high}}, colour);
}

void Panel::band(const std::vector<Whisker>& edges, const Colour& colour) {
  Rows rows;
  for (const Whisker& one : edges) rows.push_back({one.at, one.low, one.high});
  add(rows, "using 1:2:3 with filledcurves fillstyle solid linecolor rgb '" + colour.hex() + "'");
}

void Panel::whiskers(const std::vector<Whisker>& whiskers, const LineStyle& style) {
  Rows rows;
  for (const Whisker& one : whiskers) rows.push_back({one.at, one.low, 0, one.high - one.low});
  add(rows, whisker_ends + style.text());
}

void Panel::whiskers_across(const std::vector<Whisker>& whiskers, const LineStyle& style) {
  Rows rows;
  for (const Whisker& one : whiskers) rows.push_back({one.low, one.at, one.high - one.low, 0});
  add(rows, whisker_ends + style.text());
}

void Panel::bars(const std::vector<Bar>& bars, double width) {
  Rows rows;
  for (const Bar& bar : bars) {
    rows.push_back({bar.x, bar.height, width, static_cast<double>(bar.colour.number())});
  }
  add(rows,
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
