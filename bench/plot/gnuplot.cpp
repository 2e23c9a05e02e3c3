#include "bench/plot/gnuplot.h"

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "core/atomic_file.h"
#include "core/errors.h"
#include "core/process.h"
#include "core/regular_file.h"
#include "core/temporary_folder.h"
#include "core/text.h"

namespace ertbench {
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

/// gnuplot draws a text in a box twice, first with a filter that fills the box. Where a page is
/// printed the filter leaves a coarse shadow of the text; a white rim does the same without one.
std::string without_filters(std::string svg) {
  const std::string filter = "style='filter:url(#textbox)'";
  const std::string rim = "style='fill:white;stroke:white;stroke-width:3;stroke-linejoin:round'";
  for (auto at = svg.find(filter); at != std::string::npos; at = svg.find(filter, at)) {
    svg.replace(at, filter.size(), rim);
  }
  return svg;
}

/// gnuplot escapes "<" and "&" alone; XML has this end of CDATA nowhere else.
std::string without_cdata_ends(std::string svg) {
  for (auto at = svg.find("]]>"); at != std::string::npos; at = svg.find("]]>", at)) {
    svg.replace(at, 3, "]]&gt;");
  }
  return svg;
}

/// Viewers would smooth the pictures in an SVG when they enlarge them; pixels are to stay squares.
std::string with_sharp_pixels(std::string svg) {
  const std::string tag = "<image ";
  const std::string style = "image-rendering='optimizeSpeed' style='image-rendering:pixelated' ";
  for (auto at = svg.find(tag); at != std::string::npos; at = svg.find(tag, at + tag.size())) {
    svg.insert(at + tag.size(), style);
  }
  return svg;
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

void draw_chart(const std::string& commands, const FileContents& inputs, int width, int height,
                const fs::path& stem, const std::vector<Tooltip>& tooltips) {
  // A generic family: fontconfig and browsers both know it.
  const std::string font = "noenhanced background rgb 'white' font 'sans-serif,11'";
  const auto size = [&](int scale) {
    return " size " + std::to_string(scale * width) + "," + std::to_string(scale * height) + "\n";
  };
  const std::string script =
      "set encoding utf8\n"
      "set terminal svg " +
      font + size(1) +
      "set output 'chart.svg'\n"
      "load 'commands.gnuplot'\n"
      "unset output\n"
      "reset\n"
      // A point of the font is 1 px in the SVG and 4/3 px here.
      "set terminal pngcairo " +
      font + " fontscale 2.25 linewidth 3 pointscale 3" + size(3) +
      "set output 'chart.png'\n"
      "load 'commands.gnuplot'\n"
      "unset output\n";
  FileContents files = inputs;
  files["commands.gnuplot"] = commands;
  const FileContents made = run_gnuplot(script, files, {"chart.svg", "chart.png"});
  const std::string svg =
      with_sharp_pixels(without_filters(without_titles(without_cdata_ends(made.at("chart.svg")))));
  write_file_atomically(stem.string() + ".svg", with_tooltips(svg, tooltips));
  write_file_atomically(stem.string() + ".png", made.at("chart.png"));
}

std::string gnuplot_string(const std::string& text) {
  // Octal, since gnuplot runs what stands between back-ticks, and doubled single quotes fail at the
  // start of a string.
  std::string out = "\"";
  for (const char c : printable(text, text.size())) {  // an SVG must not hold control characters
    switch (c) {
      case '"':
        out += "\\042";
        break;
      case '\\':
        out += "\\134";
        break;
      case '`':
        out += "\\140";
        break;
      default:
        out += c;
    }
  }
  return out + "\"";
}

}  // namespace ertbench
