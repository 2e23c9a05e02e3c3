#include "bench/plot/canvas.h"

#include <spdlog/spdlog.h>

#include <fstream>
#include <stdexcept>
#include <utility>

#include "core/errors.h"
#include "core/files.h"
#include "core/process.h"
#include "core/text.h"

namespace ertbench {

std::string with_tooltips(const std::string& svg, const std::vector<Tooltip>& tooltips) {
  if (tooltips.empty()) return svg;
  const auto end = svg.rfind("</svg>");
  if (end == std::string::npos) throw std::invalid_argument("tooltips: the SVG has no end");
  TextStream out;
  out << svg.substr(0, end) << "<g class=\"tooltips\" fill=\"none\" pointer-events=\"all\">\n";
  for (const Tooltip& tooltip : tooltips) {
    const Box& box = tooltip.box;
    out << "<rect x=\"" << box.left << "\" y=\"" << box.top << "\" width=\"" << box.width()
        << "\" height=\"" << box.height() << "\"><title>" << html_escaped(tooltip.text)
        << "</title></rect>\n";
  }
  out << "</g>\n" << svg.substr(end);
  return out.str();
}

namespace {

namespace fs = std::filesystem;

constexpr const char* kScript = "chart.gnuplot";
constexpr const char* kLog = "gnuplot.log";
constexpr int kTimeLimit_s = 600;

void write_file(const fs::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary);
  out << bytes;
  if (!out.flush()) throw InputError(path.string() + ": cannot be written; is the disk full?");
}

std::string manner_of(const ProcessEnd& end) {
  if (end.timed_out) return "stopped after " + std::to_string(kTimeLimit_s) + " s";
  if (end.signal != 0) return "stopped by signal " + std::to_string(end.signal);
  return "exit code " + std::to_string(end.exit_code);
}

/// gnuplot titles the picture "Gnuplot" and each of its plots with a line of the script, which
/// viewers show wherever the pointer is.
std::string without_titles(std::string svg) {
  const std::string end = "</title>";
  for (auto at = svg.find("<title>"); at != std::string::npos; at = svg.find("<title>", at)) {
    svg.erase(at, svg.find(end, at) + end.size() - at);
  }
  return svg;
}

std::string mended(const std::string& svg) {
  // gnuplot escapes "<" and "&" alone; XML has this end of CDATA nowhere else.
  const std::string untitled = without_titles(replaced(svg, "]]>", "]]&gt;"));
  // gnuplot draws a text in a box twice, first with a filter that fills the box. Where a page is
  // printed the filter leaves a coarse shadow of the text; a white rim does the same without one.
  const std::string rimmed =
      replaced(untitled, "style='filter:url(#textbox)'",
               "style='fill:white;stroke:white;stroke-width:3;stroke-linejoin:round'");
  // Viewers would smooth the pictures when they enlarge them; pixels are to stay squares.
  return replaced(rimmed, "<image ",
                  "<image image-rendering='optimizeSpeed' style='image-rendering:pixelated' ");
}

std::string margins(const Box& box, double width, double height) {
  TextStream out;
  out.precision(10);
  out << "set lmargin at screen " << box.left / width << "\nset rmargin at screen "
      << box.right / width << "\nset tmargin at screen " << 1 - box.top / height
      << "\nset bmargin at screen " << 1 - box.bottom / height << "\n";
  return out.str();
}

/// Draws commands.gnuplot, which sets neither terminal nor output, as chart.svg and chart.png.
std::string script_of(int width, int height) {
  // A generic family: fontconfig and browsers both know it.
  const auto drawn = [&](const std::string& terminal, int scale, const std::string& name) {
    return "set terminal " + terminal + " noenhanced background rgb 'white' font 'sans-serif,11'" +
           " size " + std::to_string(scale * width) + "," + std::to_string(scale * height) +
           "\nset output '" + name + "'\nload 'commands.gnuplot'\nunset output\nreset\n";
  };
  const int scale = width * height > 800000 ? 2 : 3;
  const std::string times = std::to_string(scale);
  // A point of the font is 1 px in the SVG and 4/3 px in the PNG.
  return "set encoding utf8\n" + drawn("svg", 1, "chart.svg") +
         drawn("pngcairo fontscale " + fixed(0.75 * scale, 2) + " linewidth " + times +
                   " pointscale " + times,
               scale, "chart.png");
}

/// A picture of a few lines of text.
std::string picture_of(const std::string& text) {
  constexpr int line_px = 16;
  const std::vector<std::string> lines = wrapped(one_line(text, 600), 90);
  const auto height = std::to_string(line_px * (static_cast<int>(lines.size()) + 2));
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"640\" height=\"" + height +
                    "\" viewBox=\"0 0 640 " + height + "\">\n<rect width=\"640\" height=\"" +
                    height + "\" fill=\"white\" stroke=\"black\"/>\n";
  int y = line_px;
  for (const std::string& line : lines) {
    y += line_px;
    svg.append("<text x=\"16\" y=\"")
        .append(std::to_string(y - line_px / 4))
        .append("\" font-family=\"sans-serif\" font-size=\"12\">")
        .append(html_escaped(line))
        .append("</text>\n");
  }
  return svg + "</svg>\n";
}

}  // namespace

FileContents run_gnuplot(const std::string& script, const FileContents& inputs,
                         const std::vector<std::string>& outputs) {
  const TemporaryFolder folder("gnuplot");
  for (const auto& [name, bytes] : inputs) write_file(folder.path() / name, bytes);
  write_file(folder.path() / kScript, script);

  const fs::path log = folder / kLog;
  const ProcessEnd end =
      ChildProcess({"gnuplot", "--default-settings", kScript},
                   {.log = log, .output = log, .folder = folder.path()}, {kTimeLimit_s})
          .wait();
  if (end.exit_code == ChildProcess::not_started) {
    throw InputError("gnuplot: not found, no charts can be drawn; apt-get install gnuplot-nox");
  }
  if (!end.ok()) {
    throw std::runtime_error("gnuplot failed, " + manner_of(end) + ": " + contents_of(log));
  }
  FileContents made;
  for (const std::string& name : outputs) {
    made[name] = contents_of(folder / name);
    if (made[name].empty()) {
      throw std::runtime_error("gnuplot did not make " + name + ": " + contents_of(log));
    }
  }
  return made;
}

std::string gnuplot_string(const std::string& text) {
  // Octal, since gnuplot runs what stands between back-ticks, and doubled single quotes fail at the
  // start of a string.
  std::string out = "\"";
  for (const char c : printable(text, text.size())) {  // an SVG must not hold control characters
    out += c == '"' ? "\\042" : c == '\\' ? "\\134" : c == '`' ? "\\140" : std::string(1, c);
  }
  return out + "\"";
}

Canvas::Canvas(double width, double height)
    : width_(static_cast<int>(width)), height_(static_cast<int>(height)) {
  plots_.precision(10);
  marks_.precision(10);
}

std::string Canvas::screen(double x, double y) const {
  TextStream place;
  place.precision(10);
  place << "screen " << x / width_ << ", screen " << 1 - y / height_;
  return place.str();
}

void Canvas::text(const std::string& text, double x, double y, const TextStyle& style) {
  marks_ << "set label " << gnuplot_string(text) << " at " << screen(x, y) << " font ',"
         << style.size << "' " << style.text() << "\n";
}

void Canvas::lines(const std::string& text, std::size_t characters, double x, double y,
                   const TextStyle& style) {
  for (const std::string& line : wrapped(text, characters)) {
    this->text(line, x, y, style);
    y += style.size + 2;
  }
}

void Canvas::title(const std::string& text) {
  constexpr int size = 12;
  this->text(one_line(text, characters_in(width_, size)), width_ / 2.0, 16, {.size = size});
}

void Canvas::letter(int index, double y) {
  const std::string text = std::string("(") + static_cast<char>('a' + index % 26) + ")";
  this->text(text, 14, y, {.size = 12, .align = TextAlign::left});
}

void Canvas::line(double x1, double y1, double x2, double y2, const LineStyle& style) {
  marks_ << "set arrow from " << screen(x1, y1) << " to " << screen(x2, y2) << " nohead "
         << style.text() << "\n";
}

void Canvas::rectangle(const Box& box, const BoxStyle& style) {
  marks_ << "set object rectangle from " << screen(box.left, box.bottom) << " to "
         << screen(box.right, box.top) << " " << style.text() << "\n";
}

void Canvas::mark(double x, double y, const MarkStyle& style) {
  marks_ << "set label \"\" at " << screen(x, y) << " point " << style.text() << "\n";
}

void Canvas::tooltip(const Box& box, std::string text) {
  tooltips_.push_back({box, std::move(text)});
}

void Canvas::tooltip_at(double x, double y, std::string text) {
  constexpr double reach = 6;
  tooltip(Box::around(x, y, reach), std::move(text));
}

void Canvas::area(const Box& box) { plots_ << margins(box, width_, height_); }

std::string Canvas::data(const std::string& text) {
  const std::string name = "data" + std::to_string(files_.size()) + ".txt";
  files_[name] = text;
  return "'" + name + "'";
}

void Canvas::draw(const std::filesystem::path& stem) const {
  // The marks belong to a last, empty plot over the whole picture.
  FileContents files = files_;
  files["commands.gnuplot"] =
      "set multiplot\nset style textbox opaque noborder fillcolor 'white' margins 0.3,0.3\n" +
      plots_.str() + margins({0, 0, double(width_), double(height_)}, width_, height_) +
      "unset key\nunset tics\nunset border\nset xrange [0:1]\nset yrange [0:1]\n" + marks_.str() +
      "plot NaN notitle\nunset multiplot\n";
  const FileContents made =
      run_gnuplot(script_of(width_, height_), files, {"chart.svg", "chart.png"});
  write_file_atomically(stem.string() + ".svg",
                        with_tooltips(mended(made.at("chart.svg")), tooltips_));
  write_file_atomically(stem.string() + ".png", made.at("chart.png"));
}

bool draw_or_say(const std::filesystem::path& stem, const std::function<void()>& draw) {
  try {
    draw();
    return true;
  } catch (const std::exception& error) {
    const std::string name = stem.filename().string();
    spdlog::warn("the figure \"{}\" could not be drawn: {}", name, one_line(error.what(), 600));
    std::error_code ignored;
    std::filesystem::remove(stem.string() + ".png", ignored);
    write_file_atomically(stem.string() + ".svg", picture_of("This figure could not be drawn: " +
                                                             std::string(error.what())));
    return false;
  }
}

}  // namespace ertbench
