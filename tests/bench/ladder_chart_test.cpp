#include "bench/charts/ladder_chart.h"

#include <cmath>
#include <string>

#include "tests/bench/figure_testing.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using namespace testing;

class LadderChart : public FigureTest {
 protected:
  /// Of so many solvers "m1", "m2", ..., whose frames fail the sooner the later they stand.
  std::string svg_of(int solvers) {
    Ladders ladders;
    LadderAxis axis;
    axis.name = "noise";
    axis.title = "Noise";
    axis.unit = "dB";
    for (const int level : {80, 60, 40, 20}) axis.levels.emplace_back(level);
    std::vector<SolverEntry> entries(static_cast<std::size_t>(solvers));
    std::vector<LadderOutcome> outcomes;
    for (int s = 0; s < solvers; ++s) {
      SolverEntry& entry = entries[static_cast<std::size_t>(s)];
      entry.label = "m" + std::to_string(s + 1);
      LadderClimb climb{axis.name, {}, {}};
      for (const Level& level : axis.levels) {
        LadderLevel step{level, std::vector<JudgedFrame>(20), ""};
        for (std::size_t f = 0; f < step.frames.size(); ++f) {
          JudgedFrame& frame = step.frames[f];
          frame.error =
              0.1 * (1 + s) * std::exp((80 - level.number()) / 30) * (1 + 0.02 * double(f));
          if (*frame.error > 1) frame.failed = static_cast<int>(FailureKind::worse_than_nothing);
        }
        climb.levels.push_back(std::move(step));
      }
      outcomes.push_back({&entry, LadderRecord{{}, {std::move(climb)}}, ""});
    }
    draw_ladder_chart(ladders, axis, outcomes, results() / "chart");
    return read_text(results() / "chart.svg");
  }
};

int count(const std::string& text, const std::string& what) {
  int found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) {
    ++found;
  }
  return found;
}

TEST_F(LadderChart, MoreThanEightSolversStandInSeveralColumns) {
  for (const auto& [solvers, columns] : {std::pair(8, 1), std::pair(9, 2), std::pair(17, 3)}) {
    SCOPED_TRACE(solvers);
    const std::string svg = svg_of(solvers);
    EXPECT_EQ(count(svg, "level (dB)"), columns);
    EXPECT_EQ(count(svg, "failing frames"), 1) << "the same axis for all columns";
    for (int s = 1; s <= solvers; ++s) {
      EXPECT_EQ(count(svg, ">m" + std::to_string(s) + "<"), 1) << s;
    }
  }
}

}  // namespace
}  // namespace ertbench
