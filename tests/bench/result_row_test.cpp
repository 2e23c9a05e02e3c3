#include "bench/record/result_row.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/errors.h"
#include "core/json.h"

namespace ertbench {
namespace {

using nlohmann::json;

ResultRow sample() {
  ResultRow row;
  row.label = "GN";
  row.type = "one-step-gn";
  row.dataset = "test";
  row.parameters = json{{"lambda", 0.03}};
  row.frames = 5;
  row.undefined_frames = 1;
  row.frames_not_converged = 2;
  row.metrics[Metric::AR] = {1.1, Interval{1.0, 1.2}, 1.05, 4, 1, Interval{0.9, 1.15}};
  row.metrics[Metric::PE] = {std::nullopt, std::nullopt, std::nullopt, 0, 5};
  row.family = "gauss-newton";
  row.validation.emplace()[Metric::relative_error] = {0.5, Interval{0.4, 0.6}, 0.45, 9, 0};
  row.latency_us = LatencySummary{10, 20, 30, {9, 11}, {2, 2.4}, 1.5, 14, 28};
  row.calibration_us = 4.5;
  row.frames_per_s = 1e5;
  row.throughput_batch = 64;
  row.fit_s = 0.25;
  return row;
}

TEST(ResultRow, IsWrittenAsTheContractSays) {
  const json out = to_json(sample());
  EXPECT_EQ(out.at("label"), "GN");
  EXPECT_EQ(out.at("status"), "ok");
  EXPECT_EQ(out.at("parameters").at("lambda"), 0.03);
  EXPECT_EQ(out.at("metrics").at("AR").at("ci95"), json::parse("[1.0, 1.2]"));
  EXPECT_EQ(out.at("metrics").size(), 2u) << "what the truth does not tell is absent";
  EXPECT_TRUE(out.at("metrics").at("PE").at("mean").is_null());
  EXPECT_TRUE(out.at("metrics").at("PE").at("ci95").is_null());
  EXPECT_EQ(out.at("metrics").at("PE").at("undefined"), 5);
  EXPECT_EQ(out.at("metrics").at("AR").at("median_ci95"), json::parse("[0.9, 1.15]"));
  EXPECT_EQ(out.at("latency_us").at("p99"), 20);
  EXPECT_EQ(out.at("latency_us").at("pipe"), 1.5);
  EXPECT_EQ(out.at("latency_us").at("contacts_p99"), 28);
  EXPECT_EQ(out.at("validation").at("relative_error").at("mean"), 0.5);
  EXPECT_EQ(out.at("frames_per_s"), 1e5);
  EXPECT_TRUE(out.at("peak_rss_mb").is_null());
}

TEST(ResultRow, ComesBackAsItWas) {
  ResultRow failed;
  failed.label = "x";
  failed.type = "pdipm";
  failed.dataset = "test";
  failed.status = "crashed";
  failed.message = "signal 11\n\"quoted\"";
  for (const ResultRow& row : {sample(), failed}) {
    const json written = json::parse(to_json(row).dump());
    const ResultRow read = result_row_from_json(JsonObject(written, "summary.json", "/rows/0"));
    EXPECT_EQ(to_json(read), written);
    EXPECT_EQ(read.metrics.values, row.metrics.values);
    EXPECT_EQ(read.latency_us, row.latency_us);
    EXPECT_EQ(read.message, row.message);
    EXPECT_EQ(read.ok(), row.ok());
  }
}

ResultRow sample_of_seeds() {
  ResultRow row = sample();
  SeedSpread& seeds = row.seeds.emplace();
  seeds.values = {1, 5};
  row.fit_s = 2.5;
  seeds.fit_s = {2.0, 3.0};
  for (const Metric metric : kMetrics) seeds.means[metric] = {std::nullopt, std::nullopt};
  seeds.means[Metric::AR] = {1.0, 1.2};
  seeds.deviation[Metric::AR] = 0.1414;
  seeds.parameters = json::parse(R"([{"seed":1},{"seed":5}])");
  row.sweep = json{{"alpha", 0.001}, {"form", "minimax"}};
  return row;
}

TEST(ResultRow, SeedsAndSweepAreThereWhereTheyAreMeant) {
  EXPECT_FALSE(to_json(sample()).contains("seeds"));
  EXPECT_FALSE(to_json(sample()).contains("sweep"));
  const json out = to_json(sample_of_seeds());
  EXPECT_EQ(out.at("seeds").at("values"), json({1, 5}));
  EXPECT_EQ(out.at("seeds").at("means").at("AR"), json({1.0, 1.2}));
  EXPECT_EQ(out.at("seeds").at("deviation").at("AR"), 0.1414);
  EXPECT_TRUE(out.at("seeds").at("deviation").at("PE").is_null());
  EXPECT_EQ(out.at("sweep").at("alpha"), 0.001);
  const ResultRow read = result_row_from_json(JsonObject(out, "summary.json", "/rows/0"));
  EXPECT_EQ(to_json(read), out);
  EXPECT_EQ(read.seeds->means[Metric::AR], sample_of_seeds().seeds->means[Metric::AR]);
}

TEST(ResultRow, NamesThePlaceOfWhatIsWrongInTheSeeds) {
  json written = to_json(sample_of_seeds());
  written["seeds"]["means"]["AR"] = {1.0};
  try {
    result_row_from_json(JsonObject(written, "summary.json", "/rows/0"));
    FAIL() << "accepted a mean for one of two seeds";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("/rows/0/seeds/means/AR: must be a list of 2"),
              std::string::npos)
        << e.what();
  }
}

TEST(ResultRow, RowsOfBeforeAMetricAreReadWithoutIt) {
  json written = to_json(sample_of_seeds());
  written["metrics"].erase("CC");
  written["validation"].erase("CC");
  for (const char* part : {"means", "deviation"}) written["seeds"][part].erase("CC");
  const ResultRow read = result_row_from_json(JsonObject(written, "summary.json", "/rows/0"));
  EXPECT_EQ(read.metrics[Metric::CC], MetricSummary{});
  EXPECT_EQ(read.metrics[Metric::AR], sample_of_seeds().metrics[Metric::AR]);
  EXPECT_EQ(read.seeds->means[Metric::CC].size(), 2U);
  EXPECT_FALSE(read.seeds->deviation[Metric::CC]);
}

TEST(ResultRow, PublishedRowsAreRead) {
  const std::filesystem::path folder =
      std::filesystem::path(ERTBENCH_SOURCE_DIR) / "results/published";
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().filename() != "summary.json") continue;
    SCOPED_TRACE(entry.path());
    const json summary = read_json_file(entry.path());
    for (const json& value : summary.at("rows")) {
      const ResultRow row = result_row_from_json(JsonObject(value, entry.path().string(), "/rows"));
      const bool tells = value.at("metrics").contains("RIE");  // measured frames have no truth
      const json mean = tells ? value.at("metrics").at("RIE").at("mean") : json();
      EXPECT_EQ(row.metrics[Metric::RIE].mean.has_value(), mean.is_number());
      if (mean.is_number()) {
        EXPECT_EQ(row.metrics[Metric::RIE].mean, mean.get<double>());
      }
    }
    ++files;
  }
  EXPECT_GT(files, 0);
}

TEST(ResultRow, NamesThePlaceOfWhatIsWrong) {
  const auto error = [](const char* place, const json& value) -> std::string {
    json written = to_json(sample());
    written[json::json_pointer(place)] = value;
    try {
      result_row_from_json(JsonObject(written, "summary.json", "/rows/0"));
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(error("/metrics/AR/mean", "high").find("summary.json: /rows/0/metrics/AR/mean"), 0u);
  const json of_one = {{"p50", 10}, {"p99", 20}, {"max", 30}, {"contacts_p99", 28}};
  EXPECT_EQ(error("/latency_us", of_one)
                .find("summary.json: /rows/0/latency_us/contacts_p99: is there only beside"),
            0u);
}

}  // namespace
}  // namespace ertbench
