// The load generator in simulated time, against queueing theory.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bench/speed/load_run.h"
#include "bench/speed/offered_load.h"
#include "core/errors.h"
#include "core/random.h"
#include "tests/bench/figure_testing.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using testing::Outcome;
using testing::TemporaryFolder;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Mean wait by a run of so many frames without any deadline.
double mean_wait(std::vector<double> service_s, double rate, std::size_t frames) {
  SimulatedServer server(service_s);
  const LoadRun run =
      offer_load(arrival_times(Arrivals::poisson, rate, frames, 7), {1e9, 0.99}, server);
  return mean_of(run.latency_s) - mean_of(service_s);
}

// Pollaczek and Khinchine: W = rate E[S²] / (2 (1 - rho)). The mean of n waits of an M/D/1 queue
// has a standard error of about sqrt(2 tau / n) times their deviation, with a correlation time tau
// of some (1 - rho)^-2 frames: 400 000 frames at rho = 0.8 leave 0.7 % of W; 4 % is six of these.
TEST(Load, WaitsOfAConstantServiceAreThoseOfTheory) {
  const double service = 0.002;
  for (const double rho : {0.3, 0.5, 0.8}) {
    const double rate = rho / service;
    const double theory = rate * service * service / (2 * (1 - rho));
    EXPECT_NEAR(mean_wait({service}, rate, 400000), theory, 0.04 * theory) << rho;
  }
}

TEST(Load, WaitsOfAVaryingServiceAreThoseOfTheory) {
  // Two times in random order, so that services are independent of each other.
  RandomStream random(3, 1, 0, Purpose::scene);
  std::vector<double> service;
  for (int i = 0; i < 400000; ++i) service.push_back(random.uniform() < 0.1 ? 0.011 : 0.001);
  const double mean = mean_of(service);
  double square = 0;
  for (const double s : service) square += s * s / static_cast<double>(service.size());
  const double rate = 0.6 / mean;
  const double theory = rate * square / (2 * (1 - 0.6));
  EXPECT_NEAR(mean_wait(service, rate, 400000), theory, 0.06 * theory);
}

TEST(Load, ArrivalsHaveTheirRateAndTheirSpread) {
  const std::vector<double> fixed = arrival_times(Arrivals::fixed, 50, 101, 1);
  EXPECT_EQ(fixed.front(), 0);
  EXPECT_DOUBLE_EQ(fixed.back(), 2);
  const std::vector<double> poisson = arrival_times(Arrivals::poisson, 50, 100000, 1);
  std::vector<double> steps;
  for (std::size_t i = 1; i < poisson.size(); ++i) steps.push_back(poisson[i] - poisson[i - 1]);
  const double mean = mean_of(steps);
  EXPECT_NEAR(mean, 0.02, 6 * 0.02 / std::sqrt(1e5));  // six standard errors
  // Of an exponential distribution the standard deviation is the mean, P(step > mean) = 1/e.
  const auto longer = std::count_if(steps.begin(), steps.end(), [](double s) { return s > 0.02; });
  EXPECT_NEAR(static_cast<double>(longer) / 1e5, std::exp(-1), 6 * 0.5 / std::sqrt(1e5));
  EXPECT_NE(poisson, arrival_times(Arrivals::poisson, 50, 100000, 2));
  EXPECT_EQ(poisson, arrival_times(Arrivals::poisson, 50, 100000, 1));
}

TEST(Load, AFrameThatWaitsHasWaited) {
  // One frame takes 100 ms, and those that arrive meanwhile wait for it, though the generator could
  // not have offered them: 9, 8, ... 1 times 10 ms and their own 1 ms.
  std::vector<double> service(10, 0.001);
  service[0] = 0.1;
  SimulatedServer server(service);
  const LoadRun run = offer_load(arrival_times(Arrivals::fixed, 100, 10, 1), {1, 0.99}, server);
  for (std::size_t i = 0; i < 10; ++i) {
    const double done = 0.1 + 0.001 * static_cast<double>(i);
    EXPECT_NEAR(run.latency_s[i], done - 0.01 * static_cast<double>(i), 1e-12) << i;
  }
}

TEST(Load, MissesAreCountedToTheRank) {
  const LoadDeadline deadline{0.01, 0.99};
  EXPECT_EQ(deadline.misses_allowed(1000), 10u);
  EXPECT_EQ(deadline.misses_allowed(100), 1u);
  for (const auto& [late, kept] : {std::pair(10, true), std::pair(11, false)}) {
    std::vector<double> service(1000, 0.001);
    for (int i = 0; i < late; ++i) service[static_cast<std::size_t>(i * 90)] = 0.02;
    SimulatedServer server(service);
    const LoadRun run = offer_load(arrival_times(Arrivals::fixed, 10, 1000, 1), deadline, server);
    EXPECT_EQ(run.kept, kept) << late;
    EXPECT_EQ(run.missed, static_cast<std::size_t>(late));
  }
}

RateSearch search_for(Arrivals arrivals, double deadline_s) {
  RateSearch search;
  search.arrivals = arrivals;
  search.deadline.seconds = deadline_s;
  search.least_frames = 20000;
  return search;
}

TEST(HighestRate, AtAFixedRateAConstantServiceIsFullyUsed) {
  for (const double deadline_s : {0.0011, 0.005, 0.02}) {
    SimulatedServer server({0.001});
    const KeptRate rate = highest_rate(search_for(Arrivals::fixed, deadline_s), {0.001}, server);
    ASSERT_TRUE(rate.per_s);
    EXPECT_LT(*rate.per_s, 1000);
    EXPECT_GT(*rate.per_s, 1000 / 1.03);
    EXPECT_TRUE(rate.confirmed);
  }
}

TEST(HighestRate, NoRateKeepsADeadlineShorterThanTheService) {
  SimulatedServer server({0.001});
  EXPECT_FALSE(highest_rate(search_for(Arrivals::poisson, 0.0009), {0.001}, server).per_s);
}

/// P(wait <= t) of an M/D/1 queue (Erlang 1909): (1 - rho) times the sum over k <= t/s of
/// (-x)^k e^x / k! with x = rate (t - k s), in long double as the terms alternate.
double erlang_share(double rate, double service_s, double t) {
  long double sum = 0;
  long double factorial = 1;
  for (int k = 0; k * service_s <= t; ++k) {
    if (k > 0) factorial *= k;
    const long double x = static_cast<long double>(rate) * (t - k * service_s);
    sum += std::pow(-x, k) * std::exp(x) / factorial;
  }
  return static_cast<double>((1 - rate * service_s) * sum);
}

TEST(HighestRate, WithPoissonArrivalsItIsTheRateOfErlangsFormula) {
  const double service = 0.001;
  for (const double deadline_s : {0.002, 0.003, 0.005}) {
    double low = 1;
    double high = 999;
    while (high - low > 0.01) {
      const double middle = (low + high) / 2;
      (erlang_share(middle, service, deadline_s - service) >= 0.99 ? low : high) = middle;
    }
    RateSearch search = search_for(Arrivals::poisson, deadline_s);
    search.least_frames = 200000;
    SimulatedServer server({service});
    const KeptRate rate = highest_rate(search, {service}, server);
    ASSERT_TRUE(rate.per_s);
    // The resolution of the search, and what draws of arrivals make of a share of 1 %.
    EXPECT_NEAR(*rate.per_s, low, 0.05 * low) << deadline_s;
  }
}

LoadResults some_results() {
  LoadResults results;
  results.title = "Some";
  results.deadlines_s = {0.001, 0.02};
  SolverLoad quick{"quick & <small>", "", 1e-5, 2e-5, 1.2e-5, 0.001, {}};
  const KeptRate high{40000, 0.0009, 0.00095, true, 0.5, 50000, 9};
  const KeptRate edge{60000, 0.019, 0.021, false, 0.7, 60000, 9};
  quick.deadlines = {{0.001, high, high}, {0.02, high, edge}};
  SolverLoad slow{"slow", "", 0.1, 0.2, 0.1, 0.3, {}};
  slow.deadlines = {{0.001, {}, {}}, {0.02, {}, {}}};
  SolverLoad lost;
  lost.label = "lost";
  lost.failure = "Segmentation fault";
  results.solvers = {quick, slow, lost};
  return results;
}

using LoadFigureTest = testing::FigureTest;

TEST_F(LoadFigureTest, TableAndFigureSayWhatWasAndWhatWasNot) {
  const LoadResults results = some_results();
  const Table table = load_table(results);
  const auto& rows = table.sections.front().rows;
  EXPECT_EQ(rows[0][3].text, "40000");
  EXPECT_EQ(rows[0][6].text, "60000*");
  EXPECT_EQ(rows[1][3].text, "–");
  EXPECT_EQ(rows[1][0].lines, (std::vector<std::string>{"machine busy: 30 % of the time lost"}));
  EXPECT_EQ(rows[2][0].lines, (std::vector<std::string>{"Segmentation fault"}));
  EXPECT_EQ(table.sections.front().notes.size(), 3u);
  write_load(results, this->results());
  EXPECT_EQ(files(),
            (std::set<std::string>{"load.csv", "load.json", "load.md", "load.png", "load.svg"}));
  const std::string svg = read("load.svg");
  for (const char* part : {"keeps none of the deadlines", "Segmentation fault", "20 ms"}) {
    EXPECT_NE(svg.find(part), std::string::npos) << part;
  }
  const nlohmann::json written = nlohmann::json::parse(read("load.json"));
  EXPECT_EQ(solver_load_from_json(written.at("rows").at(0)).deadlines[1].poisson.per_s, 60000);
  EXPECT_FALSE(solver_load_from_json(written.at("rows").at(1)).deadlines[0].fixed.per_s);
}

// The whole way, with a solver that takes its process down. Whether the other keeps a deadline is
// the machine's affair.
TEST(LoadProgram, ASolverThatCrashesCostsItsOwnRates) {
  const TemporaryFolder folder("load");
  nlohmann::json experiment = testing::small_experiment();
  experiment["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  experiment["solvers"] =
      nlohmann::json::array({{{"type", "tsvd"}, {"rank", 30}},
                             {{"type", "misbehaving"}, {"label", "lost"}, {"how", "crash"}}});
  testing::write_text(folder / "e.json", experiment.dump());
  const Outcome outcome = testing::run_program(
      folder.path(), "timing load e.json --deadline 10 --frames 700 --out out");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_NE(outcome.output.find("Aborted"), std::string::npos) << outcome.output;
  const nlohmann::json result = nlohmann::json::parse(testing::read_text(folder / "out/load.json"));
  const nlohmann::json& rate = result.at("rows").at(0).at("rates").at(0);
  EXPECT_EQ(rate.at("arrivals"), "fixed");
  if (rate.at("frames_per_s").is_number()) {
    EXPECT_LE(rate.at("p99_s").get<double>(), 0.01);
    EXPECT_LT(rate.at("utilisation").get<double>(), 1);
  }
  EXPECT_GT(result.at("rows").at(0).at("service_us").at("p50").get<double>(), 0);

  const Outcome unknown =
      testing::run_program(folder.path(), "timing load e.json --only gn --out out");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.output.find("there are lost, tsvd"), std::string::npos) << unknown.output;
}

TEST(LoadProgram, RatesWithoutTheirFigureAreSaidToBeSo) {
  const TemporaryFolder folder("undrawn_load");
  nlohmann::json experiment = testing::small_experiment();
  experiment["solvers"] = nlohmann::json::array({{{"type", "tsvd"}, {"rank", 30}}});
  testing::write_text(folder / "e.json", experiment.dump());
  const testing::FailingGnuplot gnuplot(folder.path());
  const Outcome outcome = testing::run_program(
      folder.path(), "timing load e.json --deadline 10 --frames 700 --out out");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_NE(outcome.output.find("\"load\" could not be drawn"), std::string::npos)
      << outcome.output;
  EXPECT_TRUE(testing::fs::exists(folder / "out/load.json"));
  EXPECT_FALSE(testing::fs::exists(folder / "out/load.png"));
}

}  // namespace
}  // namespace ertbench
