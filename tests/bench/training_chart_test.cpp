// Charts of training logs as other people's solvers may leave them, and figures that fail.

#include "bench/training/training_chart.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "bench/plot/canvas.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

TEST(TrainingChart, IsDrawnOfEveryLog) {
  const TemporaryFolder folder;
  for (const std::string log : {
           "epoch,loss\n1,0.5\n2,0.25\n",                           // no validation error
           "epoch,loss,validation_error\n1,0.5,nan\n2,0.25,inf\n",  // none that is usable
           "epoch,loss,validation_error\n1,0.5,0\n2,0.25,0\n",      // none at all
           "epoch,loss,validation_error\n1,0,1e308\n2,-0.5,-1e308\n",
           "epoch,validation_error\n7,0.5\n",
           "epoch,seconds\n1,2\n",
           "epoch\n",
           "epoch,loss,validation_error\nnan,0.5,0.5\n",
       }) {
    SCOPED_TRACE(log);
    write_text(folder / "log.csv", log);
    TrainingChart chart;
    chart.title = "any";
    chart.runs.push_back({"", read_training_curves(folder / "log.csv"), 1.0});
    EXPECT_NO_THROW(draw_training_chart(chart, folder / "chart"));
    EXPECT_TRUE(fs::exists(folder / "chart.png"));
    fs::remove(folder / "chart.png");
  }
}

TEST(DrawOrSay, PutsTheReasonInTheFiguresPlace) {
  const TemporaryFolder folder;
  write_text(folder / "chart.png", "of an earlier run");
  EXPECT_FALSE(draw_or_say(folder / "chart", [] {
    throw std::runtime_error("gnuplot <script>alert(1)</script> failed");
  }));
  const std::string svg = read_text(folder / "chart.svg");
  EXPECT_NE(svg.find("could not be drawn: gnuplot &lt;script&gt;"), std::string::npos) << svg;
  EXPECT_FALSE(fs::exists(folder / "chart.png"));
  EXPECT_TRUE(draw_or_say(folder / "chart", [] {}));
}

TEST(Program, AFigureThatCannotBeDrawnEndsNothing) {
  const TemporaryFolder folder("undrawn");
  write_text(folder / "small.json", small_experiment().dump());
  {
    const FailingGnuplot gnuplot(folder.path());
    const Outcome outcome = run_program(folder.path(), "run small.json");
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("\"reconstructions\" could not be drawn"), std::string::npos)
        << outcome.output;
  }
  const json summary = summary_of(folder / "results/small");
  EXPECT_EQ(summary.at("undrawn"), json::array({"reconstructions"}));
  EXPECT_EQ(row_of(summary, "tsvd").at("status"), "ok");
  const std::string page = read_text(folder / "results/small/report.html");
  EXPECT_NE(page.find("This figure could not be drawn"), std::string::npos);
  // The next run draws it.
  EXPECT_EQ(run_program(folder.path(), "run small.json").exit_code, 0);
  EXPECT_FALSE(summary_of(folder / "results/small").contains("undrawn"));
}

}  // namespace
}  // namespace ertbench
