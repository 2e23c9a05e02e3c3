#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/features/features.h"
#include "bench/report/report.h"
#include "bench/run/rows.h"
#include "bench/studies/study.h"
#include "solvers/registry/registry.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using nlohmann::json;

TEST(StudyTrainings, SpreadsAreOfSolversThatWereTrainedMoreThanOnce) {
  const std::vector<std::vector<Headline>> trainings = {
      {{"net", "a (mm)", 2, 1.0},
       {"fixed", "a (mm)", 2, 9.0},
       {"other", "a (mm)", 2, 5.0},
       {"net", "b (mm)", 2, 4.0}},
      {{"net", "a (mm)", 2, 2.0}, {"other", "a (mm)", 2, std::nullopt}, {"net", "b (mm)", 2, 4.0}},
      {{"net", "a (mm)", 2, 6.0}, {"net", "b (mm)", 2, 4.0}}};
  const std::vector<HeadlineSpread> spread = spread_of(trainings);
  ASSERT_EQ(spread.size(), 3u) << "not of the solver that was trained once";
  EXPECT_EQ(spread[0].label, "net");
  EXPECT_EQ(spread[0].values, (std::vector<std::optional<double>>{1.0, 2.0, 6.0}));
  EXPECT_DOUBLE_EQ(mean_of(spread[0].values).value(), 3);
  EXPECT_DOUBLE_EQ(deviation_of(spread[0].values).value(), std::sqrt(7.0));  // (4 + 1 + 9) / 2
  EXPECT_EQ(spread[1].label, "net") << "a solver's numbers stand together";
  EXPECT_EQ(deviation_of(spread[1].values), 0);
  EXPECT_EQ(spread[2].label, "other");
  EXPECT_EQ(mean_of(spread[2].values), 5) << "of the training that has a value";
  EXPECT_EQ(deviation_of(spread[2].values), std::nullopt);
}

/// Touches at nine places, and solvers whose places are `off_mm` [solvers][trainings] away.
class TrainingsOfAStudy {
 public:
  explicit TrainingsOfAStudy(const std::vector<std::vector<double>>& off_mm) {
    json places = {{"snr_db", 50}, {"snr_basis", "absolute"}};
    places["scenes"] = {{"touches", 1},
                        {"indenters", {{{"type", "flat"}}}},
                        {"force_N", 5},
                        {"places", {{"grid", {3, 3}}}}};
    json value = {{"title", "t"},
                  {"question", "q"},
                  {"sensor", {{"skin", json::object()}}},
                  {"datasets", {{"places", places}}},
                  {"studies", {{{"type", "localisation"}, {"sets", {"places"}}}}}};
    for (std::size_t s = 0; s < off_mm.size(); ++s) {
      value["solvers"].push_back({{"type", "tsvd"}, {"rank", 20 + s}, {"label", label(s)}});
    }
    testing::write_text(folder_ / "e.json", value.dump());
    SolverRegistry registry;
    experiment_ = read_experiment(folder_ / "e.json", registry, chart_types());
    const DatasetSpec& spec = experiment_->tests.front();
    const auto& touches = std::get<TouchDistribution>(spec.scenes);
    for (std::size_t s = 0; s < off_mm.size(); ++s) {
      for (const double off : off_mm[s]) {
        std::vector<FrameReading> frames(spec.count);
        for (std::uint64_t f = 0; f < spec.count; ++f) {
          const auto place = static_cast<int>(spec.scene_number(f)) % touches.places->count();
          const Eigen::Vector2d at = touches.places->place_mm(place) + Eigen::Vector2d(off, 0);
          frames[f].centroid_mm = frames[f].centroid25_mm = at;
          frames[f].contacts = {{at, 1, 1, 1}};
        }
        results_.readings[label(s)]["places"].push_back(std::move(frames));
      }
    }
  }

  static std::string label(std::size_t solver) { return "solver " + std::to_string(solver); }

  std::shared_ptr<const Study> study() const {
    return make_study(
        {experiment_->studies.front(), *experiment_, results_, Cache(folder_ / "cache")});
  }
  std::filesystem::path folder() const { return folder_.path(); }

 private:
  testing::TemporaryFolder folder_;
  std::optional<Experiment> experiment_;
  ExperimentResults results_;
};

TEST(StudyTrainings, TheStudyIsOfTheFirstAndTellsOfTheOthers) {
  const TrainingsOfAStudy two({{3, 5, 10}, {4}});
  const json summary = two.study()->numbers;
  const json& sets = summary.at("sets").at("places").at("solvers");
  EXPECT_NEAR(sets.at("solver 0").at("thresholded").at("median_mm").at("value"), 3, 1e-9);
  EXPECT_NEAR(sets.at("solver 1").at("thresholded").at("median_mm").at("value"), 4, 1e-9);
  const json& trainings = summary.at("trainings");
  ASSERT_EQ(trainings.size(), 2u) << "two headlines of the solver that was trained thrice";
  for (const json& one : trainings) {
    EXPECT_EQ(one.at("solver"), "solver 0");
    ASSERT_EQ(one.at("values").size(), 3u);
    EXPECT_NEAR(one.at("values")[1], 5, 1e-9);
    EXPECT_NEAR(one.at("mean"), 6, 1e-9);
  }
  const std::vector<ReportSection> sections = two.study()->report("t", two.folder());
  EXPECT_NE(sections.back().title.find("another training"), std::string::npos);
  EXPECT_NE(testing::read_text(two.folder() / "localisation_trainings.md").find("solver 0"),
            std::string::npos);
  EXPECT_NE(testing::read_text(two.folder() / "localisation_trainings.csv").find(",3,10"),
            std::string::npos);
}

TEST(StudyTrainings, OfOneTrainingThereIsNothingToTell) {
  const TrainingsOfAStudy one({{3}, {4}});
  EXPECT_FALSE(one.study()->numbers.contains("trainings"));
  EXPECT_EQ(one.study()->report("t", one.folder()).size(), 1u);
}

TEST(StudyText, AHeadingNamesTheLawOnce) {
  EXPECT_EQ(without_law("Collision, rising law"), "Collision");
  EXPECT_EQ(without_law("Collision"), "Collision");
  EXPECT_EQ(without_law("The rising law, a collision"), "The rising law, a collision");
}

}  // namespace
}  // namespace ertbench
