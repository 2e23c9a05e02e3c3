// Metrics of contacts, by hand; how their rule is chosen; solvers that know contacts themselves.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/record/measurement_records.h"
#include "bench/run/accuracy_stage.h"
#include "bench/score/image_contacts.h"
#include "bench/score/metric_formulas.h"
#include "bench/score/metrics.h"
#include "core/files.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "tests/bench/disc_scenes.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::Vector2d;
using nlohmann::json;
using testing::disc;
using testing::kSensor;
using testing::true_image;

FoundContact at(double x, double y) {
  FoundContact contact;
  contact.place = {x, y};
  contact.strength = 0.001;
  contact.peak = 0.02;
  contact.area = 0.05;
  return contact;
}

FrameMetrics metrics_of(const Scene& scene, const std::vector<FoundContact>& found) {
  const RowVectorXd truth = true_image(scene);
  return frame_metrics(kSensor, truth, RowVectorXd::Zero(truth.size()), scene,
                       {found, ContactSettings{}.distances(kSensor)});
}

TEST(ContactMetrics, ByHand) {
  // Units are 100 mm. (0, 0) is found 5 mm away, (0.5, 0.5) 30 mm away: too far for a match, and
  // .3 of OSPA's 50 mm; (-0.9, 0) is a ghost. (1.2, 0) is not on the sheet.
  const Scene scene{{disc(0, 0), disc(0.5, 0.5), disc(1.2, 0)}, {}};
  const FrameMetrics metrics = metrics_of(scene, {at(0.5, 0.8), at(0.03, 0.04), at(-0.9, 0)});
  EXPECT_EQ(metrics[Metric::detected], 1);
  EXPECT_EQ(metrics[Metric::false_positives], 2);
  EXPECT_DOUBLE_EQ(metrics[Metric::precision].value(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(metrics[Metric::recall].value(), 1.0 / 2);
  EXPECT_NEAR(metrics[Metric::location_error_mm].value(), 5, 1e-9);
  EXPECT_EQ(metrics[Metric::count_error], 1);
  EXPECT_NEAR(metrics[Metric::ospa_mm].value(), (5.0 + 30 + 50) / 3, 1e-9);
}

TEST(ContactMetrics, WhereNothingIsThereOrNothingWasFound) {
  const FrameMetrics missed = metrics_of({{disc(0, 0)}, {}}, {});
  EXPECT_EQ(missed[Metric::detected], 0);
  EXPECT_EQ(missed[Metric::false_positives], 0);
  EXPECT_EQ(missed[Metric::precision], std::nullopt);
  EXPECT_EQ(missed[Metric::recall], 0);
  EXPECT_EQ(missed[Metric::location_error_mm], std::nullopt);
  EXPECT_EQ(missed[Metric::count_error], 1);
  EXPECT_EQ(missed[Metric::ospa_mm], 50);

  const FrameMetrics ghost = metrics_of({}, {at(0, 0)});
  EXPECT_EQ(ghost[Metric::false_positives], 1);
  EXPECT_EQ(ghost[Metric::precision], 0);
  EXPECT_EQ(ghost[Metric::recall], std::nullopt);
  EXPECT_EQ(ghost[Metric::ospa_mm], 50);

  const FrameMetrics nothing = metrics_of({}, {});
  EXPECT_EQ(nothing[Metric::count_error], 0);
  EXPECT_EQ(nothing[Metric::ospa_mm], 0);
}

TEST(ContactMetrics, AContactIsMatchedOnce) {
  const FrameMetrics metrics = metrics_of({{disc(0, 0)}, {}}, {at(0.05, 0), at(0.01, 0)});
  EXPECT_EQ(metrics[Metric::detected], 1);
  EXPECT_EQ(metrics[Metric::false_positives], 1);
  EXPECT_NEAR(metrics[Metric::location_error_mm].value(), 1, 1e-9) << "the nearer one";
}

TEST(ContactMetrics, TheTrueImageShowsWhatIsThere) {
  const Scene scene{{disc(-0.4, 0.1), disc(0.4, -0.3)}, {}};
  const RowVectorXd truth = true_image(scene);
  const FrameMetrics metrics =
      frame_metrics(kSensor, truth, truth.array() - kSensor.background, scene);
  EXPECT_EQ(metrics[Metric::detected], 2);
  EXPECT_EQ(metrics[Metric::false_positives], 0);
  EXPECT_LT(metrics[Metric::ospa_mm].value(), 2);
  EXPECT_EQ(
      frame_metric(Metric::detected, kSensor, truth, truth.array() - kSensor.background, scene), 2);
}

TEST(ContactSettings, DistancesAreAsLargeAsTheSheet) {
  const ContactDistances distances = ContactSettings{}.distances(kSensor);  // 200 mm
  EXPECT_DOUBLE_EQ(distances.match, 20);
  EXPECT_DOUBLE_EQ(distances.ospa, 50);
  ContactSettings given;
  given.match_mm = 3;
  EXPECT_EQ(given.distances(kSensor).match, 3);
}

/// Images that are the true ones, doubled or not, over ripples that are no contacts; its frames are
/// told by their number alone.
class Known : public Solver {
 public:
  Known(const DatasetFile& set, double scale)
      : changes_(set.voltages(0, set.size()).rowwise() - set.reference_voltages().transpose()),
        images_(scale * (set.conductivity(0, set.size()).array() - kSensor.background)) {
    const double ripple = 0.3 * images_.cwiseAbs().maxCoeff();
    for (Eigen::Index f = 0; f < images_.rows(); ++f) {
      for (Eigen::Index p = f % 7; p < images_.cols(); p += 37) images_(f, p) += ripple;
    }
  }

  nlohmann::json parameters() const override { return json::object(); }
  void fit(const FitInput&) override {}
  void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport>) const override {
    for (Eigen::Index f = 0; f < changes.rows(); ++f)
      images.row(f) = images_.row(number_of(changes.row(f)));
  }
  void save(const std::filesystem::path&) const override {}
  void load(const std::filesystem::path&, const Sensor&) override {}

 protected:
  Eigen::Index number_of(const RowVectorXd& change) const {
    Eigen::Index number = 0;
    (changes_.rowwise() - change).rowwise().squaredNorm().minCoeff(&number);
    return number;
  }

 private:
  Frames changes_;
  Images images_;
};

/// The same, which says that there is always one contact at (0.25, -0.5), and one nowhere.
class Finder : public Known, public ContactFinder {
 public:
  using Known::Known;
  const ContactFinder* contact_finder() const override { return this; }
  void find_contacts(FramesView, std::span<std::vector<FoundContact>> contacts) const override {
    for (auto& of_frame : contacts) of_frame = {at(0.25, -0.5), at(std::nan(""), 0)};
  }
};

class ContactsOfSolvers : public ::testing::Test {
 protected:
  static DatasetFile made(const std::filesystem::path& file) {
    DatasetSpec spec;
    spec.name = "validation";
    spec.count = 20;
    spec.seed = 5;
    spec.noise = {60, SnrBasis::absolute};
    spec.scenes = SceneDistribution{};
    generate_dataset(spec, file);
    return DatasetFile(file);
  }

  TemporaryFolder folder_{"contacts"};
  DatasetFile set_ = made(folder_ / "validation.h5");
};

TEST_F(ContactsOfSolvers, TheRuleIsChosenOnTheValidationSetWhateverTheImagesScale) {
  const ContactRuleChoice choice = choose_contact_rule({}, kSensor, Known(set_, 1), &set_);
  EXPECT_EQ(choice.frames, 20);
  // Ripples of .3 of the largest image are above the threshold of .25.
  EXPECT_NE(choice.rule, ContactRule{});
  const ContactRuleChoice twice = choose_contact_rule({}, kSensor, Known(set_, 2), &set_);
  EXPECT_EQ(twice.rule.threshold, choice.rule.threshold);
  EXPECT_NEAR(twice.rule.floor, 2 * choice.rule.floor, 1e-12);
  const json recorded = to_json(choice);
  EXPECT_EQ(recorded.at("threshold"), choice.rule.threshold);
  EXPECT_EQ(recorded.at("floor"), choice.rule.floor);
  EXPECT_EQ(recorded.at("chosen_on"), 20);

  // No pair of the grid does better; the default does worse.
  const auto ospa_of = [&](const ContactRule& rule) {
    const ScoredFrames scored =
        score_set(Known(set_, 1), set_, kSensor, {{}, rule, ContactSettings{}.distances(kSensor)});
    return *scored.row.metrics[Metric::ospa_mm].mean;
  };
  const double least = ospa_of(choice.rule);
  EXPECT_LT(least, ospa_of(ContactRule{}));
  ContactRule other = choice.rule;
  for (const double threshold : thresholds_to_try) {
    other.threshold = threshold;
    EXPECT_GE(ospa_of(other), least - 1e-9);
  }
}

TEST_F(ContactsOfSolvers, WhatIsGivenIsNotChosen) {
  ContactSettings settings;
  settings.threshold = 0.4;
  settings.floor = 0.01;
  const ContactRuleChoice given = choose_contact_rule(settings, kSensor, Known(set_, 1), &set_);
  EXPECT_EQ(given.rule, (ContactRule{0.4, 0.01}));
  EXPECT_EQ(given.frames, 0);
  EXPECT_EQ(choose_contact_rule({}, kSensor, Known(set_, 1), nullptr).rule, ContactRule{});
  settings.floor.reset();
  EXPECT_EQ(choose_contact_rule(settings, kSensor, Known(set_, 1), &set_).rule.threshold, 0.4);
}

TEST_F(ContactsOfSolvers, ASolverThatKnowsContactsHandsOverItsOwn) {
  const ScoreRequest request{{}, {}, ContactSettings{}.distances(kSensor), true};
  const ScoredFrames scored = score_set(Finder(set_, 1), set_, kSensor, request);
  for (const json& frame : scored.frames->at("readings")) {
    ASSERT_EQ(frame.at("contacts").size(), 1u) << "a contact that is nowhere is none";
    EXPECT_NEAR(frame.at("contacts").at(0).at(0).get<double>(), 25, 1e-9);
    EXPECT_NEAR(frame.at("contacts").at(0).at(1).get<double>(), -50, 1e-9);
  }
  std::vector<FrameMetrics> frames;
  const std::vector<Scene> scenes = set_.scenes(0, set_.size());
  double ospa = 0;
  for (const Scene& scene : scenes) {
    ospa += metrics_of(scene, {at(0.25, -0.5)})[Metric::ospa_mm].value();
  }
  EXPECT_NEAR(*scored.row.metrics[Metric::ospa_mm].mean, ospa / 20, 1e-9);
}

TEST_F(ContactsOfSolvers, ReadingsComeBackOutOfTheRecord) {
  const ScoreRequest request{{0}, {}, ContactSettings{}.distances(kSensor), true};
  ScoredFrames scored = score_set(Known(set_, 1), set_, kSensor, request);
  scored.row.label = scored.row.type = "known";
  scored.row.dataset = "test";
  json record = {{"rows", {to_json(scored.row)}},
                 {"frames", {{"test", *scored.frames}}},
                 {"figure_images", *scored.figure_images}};
  Experiment experiment;
  experiment.sensor = kSensor;
  const auto read = [&] {
    return accuracy_record_from_json(json::parse(record.dump()), experiment, "");
  };
  const ScoredSet set = read().sets.front();
  ASSERT_EQ(set.readings.size(), 20u);
  std::size_t contacts = 0;
  for (std::size_t f = 0; f < set.readings.size(); ++f) {
    const FrameReading& reading = set.readings[f];
    contacts += reading.contacts.size();
    const double found =
        set.frames[f][Metric::detected].value() + set.frames[f][Metric::false_positives].value();
    EXPECT_EQ(static_cast<double>(reading.contacts.size()), found);
    EXPECT_TRUE(reading.peak.has_value());
    EXPECT_TRUE(reading.sum.has_value());
  }
  EXPECT_GT(contacts, 20u);
  record["frames"]["test"]["readings"].erase(3);
  EXPECT_ANY_THROW(read()) << "a frame without a reading";
  record["frames"]["test"].erase("readings");
  EXPECT_TRUE(read().sets.front().readings.empty()) << "where the experiment keeps none";
}

TEST_F(ContactsOfSolvers, AFrameWithoutAnImageHasAReadingWithoutValues) {
  class Undefined : public Known {
   public:
    using Known::Known;
    void reconstruct(FramesView changes, ImagesView images,
                     std::span<FrameReport> reports) const override {
      Known::reconstruct(changes, images, reports);
      images.row(1).setConstant(std::nan(""));
      reports[2].status = FrameStatus::undefined;
    }
  };
  const ScoreRequest request{{}, {}, ContactSettings{}.distances(kSensor), true};
  const ScoredFrames scored = score_set(Undefined(set_, 1), set_, kSensor, request);
  const json& readings = scored.frames->at("readings");
  for (const std::size_t f : {1u, 2u}) {
    EXPECT_TRUE(readings.at(f).at("contacts").empty());
    EXPECT_TRUE(readings.at(f).at("peak").is_null());
    EXPECT_TRUE(scored.frames->at("ospa_mm").at(f).is_null());
  }
  EXPECT_FALSE(readings.at(3).at("peak").is_null());
  EXPECT_EQ(choose_contact_rule({}, kSensor, Undefined(set_, 1), &set_).frames, 18);
}

}  // namespace
}  // namespace ertbench
