#include <gtest/gtest.h>

#include <cmath>

#include "bench/plot/panel.h"
#include "tests/bench/figure_testing.h"

namespace ertbench {
namespace {

using testing::count;

std::vector<std::string> texts(const Axis& axis) {
  std::vector<std::string> out;
  for (const Tick& tick : axis.ticks) out.push_back(tick.text);
  return out;
}

TEST(Axis, HasRoundTicksWithinItsSpan) {
  EXPECT_EQ(texts(Axis::even({-0.5, 1})),
            (std::vector<std::string>{"-0.4", "-0.2", "0", "0.2", "0.4", "0.6", "0.8", "1"}));
  EXPECT_EQ(texts(Axis::logarithms({0.5, 60})),
            (std::vector<std::string>{"0.5", "1", "2", "5", "10", "20", "50"}));
  EXPECT_EQ(texts(Axis::logarithms({1e-3, 2e2})),
            (std::vector<std::string>{"0.001", "0.01", "0.1", "1", "10", "100"}));
  EXPECT_EQ(texts(Axis::logarithms({0.9, 1.35})),
            (std::vector<std::string>{"0.9", "1", "1.1", "1.2", "1.3"}));
}

TEST(Axis, HasNoTicksBetweenNumbersThatAreHardlyTwo) {
  EXPECT_TRUE(even_ticks({1e17, 1e17 + 32}, 6).empty());
  EXPECT_TRUE(even_ticks({1.268, std::nextafter(1.268, 2)}, 6).empty());
  EXPECT_TRUE(even_ticks({3, 3}, 6).empty());
  EXPECT_EQ(even_ticks({1e6, 1e6 + 5}, 6),
            (std::vector<double>{1e6, 1e6 + 1, 1e6 + 2, 1e6 + 3, 1e6 + 4, 1e6 + 5}));
}

TEST(Axis, PlacesValuesByItsScale) {
  const Axis even = Axis::even({-1, 3});
  EXPECT_DOUBLE_EQ(even.share(-1), 0);
  EXPECT_DOUBLE_EQ(even.share(0), 0.25);
  EXPECT_DOUBLE_EQ(even.capped(7), 3);
  const Axis logarithmic = Axis::logarithms({1, 100});
  EXPECT_DOUBLE_EQ(logarithmic.share(10), 0.5);
  EXPECT_DOUBLE_EQ(logarithmic.share(100), 1);
}

TEST(Axis, SaysWhereItEndsBeforeTheValuesDo) {
  Axis axis = Axis::logarithms({0.1, 10.1});
  axis.cap();
  EXPECT_EQ(texts(axis).back(), "≥ 10.1");  // in place of the 10, for which there is no room
  EXPECT_EQ(texts(axis)[axis.ticks.size() - 2], "5");
}

TEST(Panel, PointsLieWhereTheAxesSay) {
  Canvas canvas(300, 200);
  const Panel panel(canvas, {50, 20, 250, 120}, Axis::even({0, 10}), Axis::logarithms({1, 100}));
  EXPECT_DOUBLE_EQ(panel.x(0), 50);
  EXPECT_DOUBLE_EQ(panel.x(10), 250);
  EXPECT_DOUBLE_EQ(panel.y(1), 120);
  EXPECT_DOUBLE_EQ(panel.y(10), 70);
}

TEST(CategoryNames, StandUprightWhereAWordIsWiderThanItsSlot) {
  const CategoryNames level({"one-step-gn", "dd-ert alpha=0.1"}, 60);
  EXPECT_FALSE(level.upright());
  const CategoryNames upright({"tsvd", "unbreakable_no_longer", "incomprehensible"}, 60);
  EXPECT_TRUE(upright.upright());
  EXPECT_GT(upright.height(), text_width("unbreakable_no_longer", 9));
}

/// What is said to fit into a width is not broken there, whatever its letters.
TEST(TextWidth, AgreesWithTheCharactersThatFit) {
  for (const std::string word : {"electrodes", "illicit", "lmmse", "components=64"}) {
    EXPECT_GE(characters_in(text_width(word, 9) + 1e-9, 9), word.size()) << word;
  }
  EXPECT_GT(text_width("mmmm", 10), text_width("aaaa", 10));
}

TEST(Legend, BreaksItsLinesAtTheEdgeAndWhereItIsTold) {
  Legend flowing(0, 300);
  flowing.add({"a short one"});
  EXPECT_EQ(flowing.height(), Legend::line_height);
  flowing.add({"another, which does not fit beside the first of them"});
  EXPECT_EQ(flowing.height(), 2 * Legend::line_height);
  flowing.new_line();
  flowing.add({"c"});
  EXPECT_EQ(flowing.height(), 3 * Legend::line_height);
  Legend columns(0, 300, 3);
  for (int i = 0; i < 7; ++i) columns.add({"entry"});
  EXPECT_EQ(columns.height(), 3 * Legend::line_height);
  columns.add({"a text for two columns"});  // beside the seventh
  EXPECT_EQ(columns.height(), 3 * Legend::line_height);
  columns.add({"a text for two columns"});
  columns.add({"entry"});
  EXPECT_EQ(columns.height(), 4 * Legend::line_height);
}

class Plot : public testing::FigureTest {};

/// All kinds of marks and plots on one canvas: gnuplot takes the commands, texts are drawn once.
TEST_F(Plot, EverythingThatAPanelCanHoldIsDrawn) {
  Canvas canvas(400, 300);
  canvas.title("Title `x` \"q\"");
  canvas.letter(1, 20);
  for (const double left : {60.0, 240.0}) {
    Panel panel(canvas, Box::sized(left, 40, 140, 180), Axis::even({0, 4}, "across"),
                Axis::logarithms({0.1, 10}, "up"));
    panel.title("panel");
    panel.bars({{1, 2, hue(0)}, {2, 3, hue(1)}}, 0.5);
    panel.line({{0.5, 0.5}, {3, 5}}, {hue(2), 1.2, 2});
    panel.marks({{0.5, 0.5}, {3, 5}}, {hollow(3), hue(3)});
    panel.level(1, {});
    panel.whiskers({{2, 0.5, 2}}, {});
    panel.whiskers_across({{2, 0.5, 2}}, {});
    panel.marks({}, {});
    panel.labels({{"near", panel.x(3), panel.y(5)}}, {});
    panel.tooltip(3, 5, "here");
    panel.draw();
  }
  Legend legend(60, 380);
  legend.add({"line and mark", LineStyle{}, MarkStyle{}});
  legend.add({"colour", {}, {}, hue(4)});
  legend.draw(canvas, 280);
  canvas.draw(results() / "all");
  const std::string svg = read("all.svg");
  EXPECT_EQ(count(svg, ">panel<"), 2u);
  EXPECT_EQ(count(svg, ">near<"), 2u);
  EXPECT_EQ(count(svg, "<title>here</title>"), 2u);
  for (const char* text : {">Title `x` \"q\"<", ">(b)<", ">line and mark<", ">colour<"}) {
    EXPECT_EQ(count(svg, text), 1u) << text;
  }
}

}  // namespace
}  // namespace ertbench
