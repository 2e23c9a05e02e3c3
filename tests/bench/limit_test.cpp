// What is made of posteriors: estimates, records, rows.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/record/limit_file.h"
#include "bench/record/record_file.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "limit/frame_limit.h"
#include "limit/limit_run.h"
#include "solvers/registry/registry.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

WeightedSamples normal_samples(int count, int length, std::uint64_t seed) {
  RandomStream random(seed, key_of("estimators"), 0, Purpose::scene);
  WeightedSamples out;
  out.values.resize(count, length);
  for (Eigen::Index i = 0; i < out.values.size(); ++i) out.values.data()[i] = random.normal();
  out.weights = Eigen::VectorXd::Ones(count);
  out.islands.assign(static_cast<std::size_t>(count), 0);
  return out;
}

TEST(Estimators, MedianPointIsTheWeightedMedianOnALine) {
  WeightedSamples samples;
  samples.values.resize(5, 1);
  samples.values << 0, 1, 2, 10, 50;
  samples.weights.resize(5);
  samples.weights << 1, 1, 1, 1, 1;
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(5);
  EXPECT_NEAR(weighted_median_point(samples, scales)[0], 2, 0.01);
  scales << 10, 1, 1, 1, 1;
  EXPECT_NEAR(weighted_median_point(samples, scales)[0], 0, 0.01);
}

TEST(Estimators, MedianPointIsBetterThanItsNeighboursAndTheMean) {
  WeightedSamples samples = normal_samples(200, 3, 1);
  RandomStream random(2, key_of("estimators"), 0, Purpose::scene);
  Eigen::VectorXd scales(200);
  for (double& scale : scales) scale = std::exp(random.normal());
  for (double& weight : samples.weights) weight = random.uniform();
  const Eigen::RowVectorXd best = weighted_median_point(samples, scales);
  const double least = expected_distance(samples, scales, best);
  EXPECT_LT(least, expected_distance(samples, scales, posterior_mean(samples)));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-0.02, 0.02}) {
      Eigen::RowVectorXd moved = best;
      moved[axis] += step;
      EXPECT_LT(least, expected_distance(samples, scales, moved));
    }
  }
}

TEST(Estimators, IslandsThatDisagreeAreWorthFewSamples) {
  WeightedSamples samples = normal_samples(400, 50, 3);
  for (std::size_t i = 0; i < 400; ++i) samples.islands[i] = static_cast<int>(i % 4);
  // Independent samples are worth about as many as they are: 50 entries tell within a third.
  EXPECT_NEAR(effective_samples(samples), 400, 133);
  for (Eigen::Index i = 0; i < 400; i += 4) samples.values.row(i).array() += 1;
  EXPECT_LT(effective_samples(samples), 40);
  // The island that is off counts by its weight.
  const double off_by_a_quarter = effective_samples(samples);
  for (Eigen::Index i = 0; i < 400; i += 4) samples.weights[i] = 1e-3;
  EXPECT_GT(effective_samples(samples), 4 * off_by_a_quarter);
}

// In the linear regime the noise on the sphere cuts from the posterior around its mean m the shell
// |x - m| = |truth - m| and leaves the mean: what makes the Gaussian's estimate the best there,
// too.
TEST(SphereWeights, KeepTheMeanAndKnowTheDistance) {
  constexpr int channels = 208;
  constexpr double off = 2.2;  // of the truth, in standard deviations
  const WeightedSamples samples = normal_samples(40000, 3, 4);
  std::vector<double> chi_squares;
  // The truth has chi square 208; the samples differ from it by their own distances.
  for (Eigen::Index i = 0; i < samples.values.rows(); ++i) {
    chi_squares.push_back(channels - off * off + samples.values.row(i).squaredNorm());
  }
  WeightedSamples on_sphere = samples;
  on_sphere.weights = sphere_weights(chi_squares, channels, 0.3);
  EXPECT_LT(posterior_mean(on_sphere).norm(), 0.1);
  EXPECT_NEAR(total_variance(on_sphere), off * off, 0.15);
  EXPECT_NEAR(total_variance(samples), 3, 0.1);
}

Experiment read(const fs::path& folder, const nlohmann::json& json) {
  write_file_atomically(folder / "small.json", json.dump());
  SolverRegistry registry;
  return read_experiment(folder / "small.json", registry, {}, SolverCheck::none);
}

LimitSets sets_of(const Experiment& experiment) {
  return {experiment.tests, experiment.training ? &*experiment.training : nullptr};
}

nlohmann::json one_disc() {
  nlohmann::json json = testing::small_experiment();
  json["datasets"]["test"]["rasterisation"] = "centre";
  json["datasets"]["test"]["grid"] = 24;
  json["datasets"]["train"] = json["datasets"]["test"];
  json["datasets"]["train"]["seed"] = 9;
  return json;
}

/// Of discs of one size and strength the sum and the number are the same in all samples: what
/// shares out the ties is no rank.
TEST(Limit, TiesOfAllSamplesAreNoRanks) {
  std::vector<FrameLimit> frames(40);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double share = (static_cast<double>(i) + 0.5) / 40;
    frames[i].ranks = {share, 1 - share, share / 2, share * share, share};
  }
  const LimitCalibration calibration = calibration_of(frames);
  for (std::size_t r = 0; r < limit_ranks.size(); ++r) {
    const bool tied = r == 0 || r == 4;
    EXPECT_EQ(is_ranked(frames, r), !tied) << limit_ranks[r];
    EXPECT_EQ(calibration.p_values[r].has_value(), !tied) << limit_ranks[r];
  }
}

TEST(Limit, OfADiscIsReadAgainAndMakesRows) {
  const TemporaryFolder folder("limit");
  const Experiment experiment = read(folder.path(), one_disc());
  LimitOptions options;
  options.frames = 12;
  options.records = folder.path() / "limit";
  const std::vector<SetLimit> limits = compute_limits(experiment, options);
  ASSERT_EQ(limits.size(), 2u);  // the training set has the same scenes
  EXPECT_EQ(limits[0].prior, "oracle");
  EXPECT_EQ(limits[1].prior, "fair");
  ASSERT_EQ(limits[0].frames.size(), 12u);
  for (const FrameLimit& frame : limits[0].frames) {
    EXPECT_TRUE(frame.resolved);
    EXPECT_EQ(frame.sampler, "enumeration");
    EXPECT_LT(*frame.metrics.at("relative_error").error, 0.6);
  }

  // A second call goes on from the records: what stands in them comes out, numbers and all.
  const fs::path record = options.records / "test_oracle" / "000003.json";
  nlohmann::json changed = read_json_file(record);
  changed["limit"]["seconds"] = 1234.5;
  write_record(record, {{"limit", changed["limit"]}}, changed["key"],
               *build_stamp_from_json(changed["build"]));
  fs::remove(options.records / "test_oracle" / "000005.json");
  // What was changed by hand, or made by a program with other probes, is computed again.
  const fs::path touched = options.records / "test_oracle" / "000006.json";
  nlohmann::json by_hand = read_json_file(touched);
  by_hand["limit"]["squared_error"] = 77;
  write_file_atomically(touched, by_hand.dump());
  const fs::path older = options.records / "test_oracle" / "000007.json";
  nlohmann::json old = read_json_file(older);
  BuildStamp other_probes = *build_stamp_from_json(old["build"]);
  other_probes.probes["limit"].numbers[0] += 1;
  old["limit"]["squared_error"] = 77;
  write_record(older, {{"limit", old["limit"]}}, old["key"], other_probes);
  const std::vector<SetLimit> again = compute_limits(experiment, options);
  EXPECT_EQ(again[0].frames[3].seconds, 1234.5);
  EXPECT_EQ(again[0].frames[6].squared_error, limits[0].frames[6].squared_error);
  EXPECT_EQ(again[0].frames[7].squared_error, limits[0].frames[7].squared_error);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(again[0].frames[i].metrics.at("RIE").error,
              limits[0].frames[i].metrics.at("RIE").error);
  }

  write_file_atomically(folder.path() / limit_file, limit_json("small", limits).dump());
  std::vector<ResultRow> rows(3);
  rows[0].type = "truth";
  rows[1].type = "no-contact";
  rows[2].type = rows[2].label = "tsvd";
  for (ResultRow& row : rows) row.dataset = "test";
  add_limit_rows(folder.path(), sets_of(experiment), Reuse::same_code, rows);
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[2].label, limit_oracle);
  EXPECT_EQ(rows[3].label, limit_fair);
  const double least = *rows[2].metrics[Metric::RIE].mean;
  EXPECT_GT(least, 0);

  // Two trainings with three times the limit's error in the mean, on the limit's frames; what is
  // beyond these does not count.
  FramesOfSeeds trials(2, std::vector<FrameMetrics>(20));
  for (std::size_t f = 0; f < 20; ++f) {
    const double limit = f < 12 ? *limits[0].frames[f].metrics.at("relative_error").error : 1000;
    trials[0][f][Metric::relative_error] = 2 * limit;
    trials[1][f][Metric::relative_error] = 4 * limit;
  }
  const std::vector<ScoredLabels> scored = {{"test", {"tsvd"}, {trials}}};
  compare_with_limits(folder.path(), scored, rows);
  ASSERT_TRUE(rows[4].over_limit);
  EXPECT_NEAR(rows[4].over_limit->ratio, 3, 1e-12);
  EXPECT_NEAR(rows[4].over_limit->ci95.low, 3, 1e-12);
  EXPECT_NEAR(rows[4].over_limit->ci95.high, 3, 1e-12);
  EXPECT_EQ(rows[4].over_limit->frames, 12);
  EXPECT_FALSE(rows[0].over_limit);
  EXPECT_FALSE(rows[2].over_limit);
  const nlohmann::json written = to_json(rows[4]);
  EXPECT_NEAR(result_row_from_json(JsonObject(written, "row", "")).over_limit->ratio, 3, 1e-12);

  // What an earlier call said of another set, or of a prior that was not asked for now, stays.
  const nlohmann::json both = limit_json("small", limits);
  nlohmann::json oracle = limit_json("small", std::span(limits).first(1));
  EXPECT_EQ(with_others(oracle, both).at("rows").size(), 2u);
  EXPECT_EQ(with_others(oracle, both).at("sets").size(), 2u);
  EXPECT_EQ(with_others(both, oracle), both);
  oracle["rows"][0]["frames"] = 1;
  EXPECT_EQ(with_others(oracle, both)["rows"][0]["frames"], 1);
  EXPECT_THROW(with_others(both, {{"rows", nlohmann::json::array()}}), nlohmann::json::exception);

  // A file that has all that is asked for need not be made again.
  const std::vector<ResultRow> finished = finished_limits(folder.path(), experiment, options);
  ASSERT_EQ(finished.size(), 2u);
  EXPECT_EQ(finished[0].label, limit_oracle);
  EXPECT_EQ(finished[1].label, limit_fair);
  EXPECT_EQ(*finished[0].metrics[Metric::RIE].mean, least);
  LimitOptions more = options;
  more.frames = 13;
  EXPECT_TRUE(finished_limits(folder.path(), experiment, more).empty());
  more.frames = 12;
  more.sampler = SamplerKind::importance;
  EXPECT_TRUE(finished_limits(folder.path(), experiment, more).empty());
  write_file_atomically(folder.path() / limit_file,
                        limit_json("small", std::span(limits).first(1)).dump());
  EXPECT_TRUE(finished_limits(folder.path(), experiment, options).empty());
  more = options;
  more.fair = false;
  EXPECT_EQ(finished_limits(folder.path(), experiment, more).size(), 1u);
  write_file_atomically(folder.path() / limit_file, both.dump());

  // Of another set nothing is taken.
  nlohmann::json other = one_disc();
  other["datasets"]["test"]["snr_db"] = 40;
  rows.erase(rows.begin() + 2, rows.begin() + 4);
  const Experiment another = read(folder.path(), other);
  EXPECT_TRUE(finished_limits(folder.path(), another, options).empty());
  add_limit_rows(folder.path(), sets_of(another), Reuse::same_code, rows);
  EXPECT_EQ(rows.size(), 3u);
  // Of another prior only the oracle's is, and of other probes none.
  other = one_disc();
  other["datasets"]["train"]["scenes"]["radius"] = {0.1, 0.3};
  const Experiment taught = read(folder.path(), other);
  add_limit_rows(folder.path(), sets_of(taught), Reuse::same_code, rows);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[2].label, limit_oracle);
  rows.erase(rows.begin() + 2);
  std::vector<SetLimit> of_other_probes = limits;
  for (SetLimit& set : of_other_probes) {
    for (FrameLimit& frame : set.frames) frame.build.probes["limit"].numbers[0] += 1;
  }
  write_file_atomically(folder.path() / limit_file, limit_json("small", of_other_probes).dump());
  add_limit_rows(folder.path(), sets_of(experiment), Reuse::same_code, rows);
  EXPECT_EQ(rows.size(), 3u);
  EXPECT_TRUE(finished_limits(folder.path(), experiment, options).empty());
}

// The enumerated posteriors of one disc are exact: chains from the truths come near their expected
// error from below.
TEST(Limit, LowerBoundIsBelowTheExactOneAndNearIt) {
  const TemporaryFolder folder("limit");
  nlohmann::json json = one_disc();
  json["datasets"]["test"]["snr_db"] = 40;
  const Experiment experiment = read(folder.path(), json);
  LimitOptions options;
  options.frames = 20;
  options.fair = false;
  options.records = folder.path() / "limit";
  const SetLimit exact = compute_limits(experiment, options).at(0);
  options.lower = true;
  const std::vector<SetLimit> lower = compute_limits(experiment, options);
  ASSERT_EQ(lower.size(), 1u);
  double ratio_of_errors = 0;
  double ratio_of_squares = 0;
  double errors = 0;
  double squares = 0;
  for (std::size_t i = 0; i < exact.frames.size(); ++i) {
    const FrameLimit& low = lower[0].frames[i];
    EXPECT_LT(low.relative_error_of_mean, 0.6);  // the chains are about this frame's scene
    EXPECT_EQ(low.energy, exact.frames[i].energy);
    EXPECT_EQ(low.metrics.count("PE"), 0u);
    ratio_of_errors += *low.metrics.at("relative_error").error;
    errors += *exact.frames[i].metrics.at("relative_error").expected;
    ratio_of_squares += low.variance;
    squares += exact.frames[i].variance;
  }
  // Other noise than in the set's own frames is drawn, and 20 frames are few.
  EXPECT_LT(ratio_of_errors / errors, 1.25);
  EXPECT_GT(ratio_of_errors / errors, 0.6);
  EXPECT_LT(ratio_of_squares / squares, 1.5);
  EXPECT_GT(ratio_of_squares / squares, 0.4);

  std::vector<ResultRow> rows(1);
  rows[0].type = "truth";
  rows[0].dataset = "test";
  write_file_atomically(folder.path() / limit_file, limit_json("small", lower).dump());
  add_limit_rows(folder.path(), sets_of(experiment), Reuse::same_code, rows);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1].label, limit_lower);
  EXPECT_EQ(finished_limits(folder.path(), experiment, options).size(), 1u);

  json["datasets"]["test"]["scenes"]["blank_fraction"] = 0.1;
  try {
    compute_limits(read(folder.path(), json), options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("scenes without contact"), std::string::npos);
  }
}

TEST(Limit, OfTheOracleAloneLeavesTheTrainingSetsPriorOut) {
  const TemporaryFolder folder("limit");
  nlohmann::json json = one_disc();
  json["datasets"]["train"]["scenes"]["contacts"] = {1, 3};
  const Experiment experiment = read(folder.path(), json);
  LimitOptions options;
  options.frames = 2;
  options.fair = false;
  options.records = folder.path() / "limit";
  const std::vector<SetLimit> limits = compute_limits(experiment, options);
  ASSERT_EQ(limits.size(), 1u);
  EXPECT_EQ(limits[0].prior, "oracle");
  EXPECT_FALSE(fs::exists(options.records / "test_fair"));
  std::vector<ResultRow> rows(1);
  rows[0].type = "truth";
  rows[0].dataset = "test";
  write_file_atomically(folder.path() / limit_file, limit_json("small", limits).dump());
  add_limit_rows(folder.path(), sets_of(experiment), Reuse::same_code, rows);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1].label, limit_oracle);
  // So it is where the training set has the test set's prior, and the two limits are one.
  json["datasets"]["train"]["scenes"] = json["datasets"]["test"]["scenes"];
  options.records = folder.path() / "same";
  const Experiment same = read(folder.path(), json);
  EXPECT_EQ(compute_limits(same, options).size(), 1u);
  options.fair = true;
  EXPECT_EQ(compute_limits(same, options).size(), 2u);
}

TEST(Limit, IsUnresolvedForAReasonAndWorthMoreWorkForSome) {
  FrameLimit limit;
  limit.sampler = "annealing";
  limit.quantities = 12;
  limit.chi_square = 208;
  const auto judged = [&](double effective) {
    limit.effective = effective;
    judge(208, limit);
    return std::pair(limit.resolved, deserves_more(208, limit));
  };
  EXPECT_EQ(judged(150), std::pair(true, false));
  EXPECT_EQ(judged(50), std::pair(false, false));
  EXPECT_EQ(limit.remark, "effective samples 50 < 100");
  EXPECT_EQ(judged(10), std::pair(false, true));
  // What one sampler alone has found is not made sure by its own samples.
  limit.alone = true;
  EXPECT_EQ(judged(150), std::pair(false, true));
  EXPECT_NE(limit.remark.find("only one"), std::string::npos) << limit.remark;
  limit.alone = false;
  // Three standard deviations of the chi square of 12 quantities: 208 + 14.7.
  limit.chi_square = 222;
  EXPECT_EQ(judged(150), std::pair(true, false));
  limit.chi_square = 223;
  EXPECT_EQ(judged(150), std::pair(false, true));
}

TEST(Limit, SaysWhichSetsHaveNone) {
  const TemporaryFolder folder("limit");
  nlohmann::json json = testing::small_experiment();
  json["datasets"]["test"]["snr_db"] = nullptr;
  LimitOptions options;
  options.records = folder.path() / "limit";
  try {
    compute_limits(read(folder.path(), json), options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("it has no noise"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ertbench
