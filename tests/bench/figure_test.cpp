#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>

#include "bench/plot/canvas.h"
#include "bench/plot/palette.h"
#include "bench/report/reconstruction_figure.h"
#include "core/errors.h"
#include "tests/bench/figure_testing.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using testing::count;
using testing::drawn;
using testing::Environment;
using testing::tooltips;

class Figure : public testing::FigureTest {};

ReconstructionFigure sample(int scenes, int solvers) {
  ReconstructionFigure figure;
  const int pixels = figure.sensor.pixels();
  figure.conductivity = Images::Constant(scenes, pixels, figure.sensor.background);
  figure.conductivity.leftCols(40).array() *= 0.6;
  for (int i = 0; i < scenes; ++i) figure.row_labels.push_back("scene " + std::to_string(i));
  for (int c = 0; c < solvers; ++c) {
    FigureColumn column;
    column.label = "solver-" + std::to_string(c);
    column.changes = Images::Constant(scenes, pixels, -0.001 * c);
    column.errors.assign(static_cast<std::size_t>(scenes), 0.123);
    figure.columns.push_back(std::move(column));
  }
  return figure;
}

/// Big-endian number in a PNG.
unsigned number_at(const std::string& png, std::size_t at) {
  unsigned value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value = value << 8U | static_cast<unsigned char>(png.at(at + i));
  }
  return value;
}

TEST_F(Figure, MakesAWholePngAndSvg) {
  draw_reconstruction_figure(sample(2, 3), results() / "reconstructions");
  EXPECT_EQ(files(), (std::set<std::string>{"reconstructions.png", "reconstructions.svg"}));

  const std::string png = read("reconstructions.png");
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(png.substr(png.size() - 8, 4), "IEND");

  const std::string svg = read("reconstructions.svg");
  EXPECT_NE(svg.find("<svg"), std::string::npos);
  EXPECT_TRUE(svg.ends_with("</svg>\n\n") || svg.ends_with("</svg>\n"))
      << svg.substr(svg.size() - 20);
  EXPECT_EQ(count(svg, "<g"), count(svg, "</g>"));
  EXPECT_EQ(count(svg, "<text"), count(svg, "</text>"));
  EXPECT_EQ(count(svg, "<image "), 2U * 4U + 1U);  // panels and the colour bar
  EXPECT_EQ(count(svg, "pixelated"), 2U * 4U + 1U);
  for (const char* text : {"truth", "solver-2", "scene 1", "rel. error 0.123", "δσ / background"}) {
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  }
  EXPECT_EQ(count(svg, "<title>"), 2U * 4U);
  EXPECT_NE(tooltips(svg).find("<title>truth, scene 1</title>"), std::string::npos);
  EXPECT_NE(tooltips(svg).find("<title>solver-2, scene 1\nrel. error 0.123<"), std::string::npos);
  const auto width = svg.find("width=\"") + 7;
  EXPECT_EQ(number_at(png, 16), 3 * std::stoul(svg.substr(width)));
}

TEST_F(Figure, KeepsTheColumnsOfSolversThatFailed) {
  ReconstructionFigure figure = sample(2, 2);
  figure.columns[0].failure = "timed out";
  figure.columns[0].changes = Images();
  figure.columns[0].errors.clear();
  figure.columns[1].changes.row(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  figure.columns[1].errors[1].reset();
  draw_reconstruction_figure(figure, results() / "f");
  const std::string svg = read("f.svg");
  EXPECT_EQ(count(drawn(svg), "timed out"), 2U);
  EXPECT_EQ(count(drawn(svg), "undefined"), 1U);
  for (const char* text : {"solver-0, scene 1\ntimed out<", "solver-1, scene 1\nundefined<"}) {
    EXPECT_EQ(count(tooltips(svg), text), 1U) << text;
  }
  EXPECT_NE(svg.find("solver-0"), std::string::npos);
  EXPECT_NE(svg.find("rel. error —"), std::string::npos);
}

TEST_F(Figure, LabelsAreTextAndNothingElse) {
  ReconstructionFigure figure = sample(1, 2);
  figure.columns[0].label = "it's `x` <&> \"q\" \\042";
  figure.columns[1].label = "a very long label of many words that will not fit above its own panel";
  figure.row_labels[0] = "'; system('touch owned'); '";
  draw_reconstruction_figure(figure, results() / "f");
  const std::string svg = read("f.svg");
  EXPECT_NE(svg.find("it's `x` &lt;&amp;> \"q\" \\042"), std::string::npos);
  EXPECT_NE(svg.find("'; system('"), std::string::npos);
  EXPECT_NE(svg.find("…"), std::string::npos);
  EXPECT_EQ(files().size(), 2U);
}

TEST_F(Figure, IsDrawnInAllSizes) {
  struct Size {
    int scenes, solvers, bands;
  };
  for (const auto& [scenes, solvers, bands] :
       {Size{1, 0, 1}, Size{1, 1, 1}, Size{8, 9, 1}, Size{3, 12, 2}, Size{1, 20, 3}}) {
    draw_reconstruction_figure(sample(scenes, solvers), results() / "f");
    const std::string svg = read("f.svg");
    EXPECT_EQ(count(svg, "<image "), static_cast<std::size_t>(scenes * (solvers + bands) + 1))
        << solvers;
    const auto width = std::stoul(svg.substr(svg.find("width=\"") + 7));
    EXPECT_LT(width, 1150U) << "as wide as a page: " << solvers;
  }
}

TEST_F(Figure, SaysWhereItCannotWrite) {
  EXPECT_THROW(draw_reconstruction_figure(sample(1, 1), results() / "absent" / "f"), InputError);
}

TEST_F(Figure, RefusesSizesThatDoNotFit) {
  ReconstructionFigure figure = sample(2, 1);
  figure.columns[0].changes = Images::Zero(1, figure.sensor.pixels());
  EXPECT_THROW(draw_reconstruction_figure(figure, results() / "f"), std::invalid_argument);
  figure = sample(2, 1);
  figure.row_labels.pop_back();
  EXPECT_THROW(draw_reconstruction_figure(figure, results() / "f"), std::invalid_argument);
}

TEST_F(Figure, GnuplotsOwnWordsAreInTheError) {
  try {
    run_gnuplot("plot 'absent.txt'\n", {}, {});
    FAIL() << "no error";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("absent.txt"), std::string::npos) << e.what();
  }
  EXPECT_THROW(run_gnuplot("x = 1\n", {}, {"chart.png"}), std::runtime_error);  // makes no file
}

TEST_F(Figure, SaysThatGnuplotIsMissing) {
  const Environment nowhere("PATH", results().string());
  try {
    run_gnuplot("x = 1\n", {}, {});
    FAIL() << "found gnuplot in an empty folder";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("gnuplot-nox"), std::string::npos) << e.what();
  }
}

Images one(double low, double high) {
  Images image = Images::Zero(1, 4);
  image(0, 0) = low;
  image(0, 1) = high;
  return image;
}

TEST(ColourScale, SpansAllValuesInRoundSteps) {
  const ColourScale scale = colour_scale(one(-0.4, 0), {one(-0.47, 0.02), one(-0.3, 0)}, 9);
  EXPECT_NEAR(scale.step, 0.2, 1e-12);
  EXPECT_NEAR(scale.low, -0.6, 1e-12);  // zero in the middle, ends multiples of the step
  EXPECT_NEAR(scale.high, 0.6, 1e-12);
  EXPECT_FALSE(scale.below || scale.above);
}

TEST(ColourScale, LargeArtefactsDoNotPaleTheRest) {
  const ColourScale scale = colour_scale(one(-0.4, 0), {one(-7, 3)}, 9);
  EXPECT_NEAR(scale.low, -0.6, 1e-12);
  EXPECT_NEAR(scale.high, 0.6, 1e-12);
  EXPECT_TRUE(scale.below && scale.above);
}

TEST(ColourScale, BlankAndNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ColourScale blank = colour_scale(one(0, 0), {one(nan, 0)}, 6);
  EXPECT_LT(blank.low, 0);
  EXPECT_GT(blank.high, 0);
  EXPECT_TRUE(std::isfinite(blank.step) && blank.step > 0);
  const ColourScale artefact = colour_scale(one(0, 0), {one(-0.02, nan)}, 6);
  EXPECT_NEAR(artefact.low, -0.02, 1e-12);
}

}  // namespace
}  // namespace ertbench
