#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_charts.h"
#include "bench/features/features.h"
#include "bench/report/chart.h"
#include "bench/run/results.h"
#include "core/errors.h"
#include "core/json.h"
#include "solvers/registry/registry.h"
#include "tests/bench/figure_testing.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A type of chart that the program does not know: it counts the rows it is asked for.
class CountChart : public Chart {
 public:
  static constexpr const char* type = "count";

  explicit CountChart(const ChartRequest& request)
      : Chart(request.place),
        labels_(read_row_labels(request.object, request.experiment)),
        unit_(request.object.text("unit")) {}

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const fs::path& folder) const override {
    std::ofstream(folder / (name() + ".svg"))
        << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">" << title << " "
        << count(rows) << "</svg>\n";
  }
  std::string caption() const override { return "rows in " + unit_; }
  std::string section() const override { return "Counted rows"; }
  Table table(std::span<const ResultRow>) const override {
    Table table;
    table.text = "One for each label.";
    return table;
  }
  void summarise(std::span<const ResultRow> rows, json& summary) const override {
    summary["counts"][name()] = count(rows);
  }

 private:
  int count(std::span<const ResultRow> rows) const {
    int found = 0;
    for (const std::string& label : labels_) found += find_row(rows, label) != nullptr ? 1 : 0;
    return found;
  }

  std::vector<std::string> labels_;
  std::string unit_;
};

ChartTypes types_with_count() {
  ChartTypes types = chart_types();
  types.push_back({CountChart::type, [](const ChartRequest& request) {
                     return std::make_shared<const CountChart>(request);
                   }});
  return types;
}

class ANewTypeOfChart : public testing::FigureTest {
 protected:
  Experiment read(const json& chart, const ChartTypes& types) {
    json value = testing::small_experiment();
    value["figure"]["scenes"] = json::array();
    value["charts"] = json::array({chart});
    const fs::path file = results() / "e.json";
    std::ofstream(file) << value.dump();
    return read_experiment(file, registry_, types);
  }
  std::string refusal(const json& chart, const ChartTypes& types) {
    try {
      read(chart, types);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

 private:
  SolverRegistry registry_;
};

const json good_chart = {{"type", "count"}, {"name", "number"}, {"unit", "pieces"}};

/// Its class and its line in the list are all that it takes.
TEST_F(ANewTypeOfChart, IsReadDrawnReportedAndSummarised) {
  const Experiment experiment = read(good_chart, types_with_count());
  ExperimentResults made;
  ResultRow row;
  row.label = "tsvd";
  row.dataset = "test";
  made.rows = {row};
  write_results(experiment, Cache(results() / "cache"), made, {}, results());
  const std::string page = testing::FigureTest::read("report.html");
  for (const char* text : {"Counted rows", "rows in pieces", "One for each label."}) {
    EXPECT_NE(page.find(text), std::string::npos) << text;
  }
  const json summary = json::parse(testing::FigureTest::read("summary.json"));
  EXPECT_EQ(summary.at("counts").at("number"), 1);
}

TEST_F(ANewTypeOfChart, IsCheckedAsTheOthersAre) {
  json chart = good_chart;
  EXPECT_EQ(refusal(chart, types_with_count()), "");
  chart["unti"] = "pieces";
  EXPECT_NE(refusal(chart, types_with_count()).find("/charts/0/unti"), std::string::npos);
  chart = good_chart;
  chart["solvers"] = json::array({"absent"});
  EXPECT_NE(refusal(chart, types_with_count()).find("/charts/0/solvers/0"), std::string::npos);
  chart = good_chart;
  chart["type"] = "cuont";
  EXPECT_NE(refusal(chart, types_with_count()).find("\"count\""), std::string::npos);
  EXPECT_NE(refusal(good_chart, chart_types()).find("/charts/0/type"), std::string::npos);
}

TEST_F(ANewTypeOfChart, IsLeftUnreadByAProcessThatDrawsNothing) {
  EXPECT_TRUE(read({{"type", "anything"}}, {}).charts.empty());
}

}  // namespace
}  // namespace ertbench
