#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/build_stamp.h"
#include "core/files.h"
#include "core/kept.h"
#include "core/probe.h"

namespace ertbench {
namespace {

Probe probe_of(const Eigen::VectorXd& values) {
  Probe probe;
  probe.add(values);
  return probe;
}

Eigen::VectorXd some_values() {
  Eigen::VectorXd values(40);
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = std::sin(1.7 * double(i)) + 0.1;
  return values;
}

TEST(Probes, LastDigitsDoNotCountAndAChangeDoes) {
  const Eigen::VectorXd values = some_values();
  const Probes now = {{"solver/x", probe_of(values)}};
  Eigen::VectorXd other_processor = values;
  for (Eigen::Index i = 0; i < values.size(); ++i) other_processor[i] *= 1 + 1e-9 * double(i % 3);
  EXPECT_EQ(probe_difference({{"solver/x", probe_of(other_processor)}}, now), "");

  // A sign, another order, a transposition and one value.
  std::vector<Eigen::VectorXd> changes = {-values, values.reverse(), values, values};
  Eigen::Map<Eigen::MatrixXd>(changes[2].data(), 5, 8) =
      Eigen::Map<const Eigen::MatrixXd>(values.data(), 8, 5).transpose().eval();
  changes[3][17] += 1e-3;
  for (const Eigen::VectorXd& change : changes) {
    const std::string why = probe_difference({{"solver/x", probe_of(change)}}, now);
    EXPECT_TRUE(why.starts_with("the probe solver/x differs by ")) << why;
  }
}

TEST(Probes, EachPartIsComparedWithItsOwnNorm) {
  Probe now = probe_of(1e6 * some_values());
  now.add(1e-6 * some_values());
  Probe made = probe_of(1e6 * some_values());
  made.add(-1e-6 * some_values());
  EXPECT_GT(difference(made, now), 0.1);
  EXPECT_EQ(difference(now, now), 0);
  made.numbers.pop_back();
  EXPECT_TRUE(std::isinf(difference(made, now)));
}

TEST(Probes, TheReasonNamesAllThatDiffer) {
  const Probes now = {{"a", probe_of(some_values())}, {"b", probe_of(some_values())}};
  EXPECT_EQ(probe_difference({{"a", now.at("a")}}, now), "the probe b was not recorded");
  EXPECT_EQ(probe_difference({{"a", now.at("a")}, {"b", {}}}, now),
            "the probe b has other numbers");
  EXPECT_EQ(probe_difference(now, {{"a", now.at("a")}}), "");  // others do not matter
}

TEST(Probes, AStampWithoutProbesIsOfTheLastRelease) {
  const auto stamp = build_stamp_from_json(
      {{"commit", "0123"}, {"dirty", false}, {"program", "p"}, {"code", "c"}});
  ASSERT_TRUE(stamp.has_value());
  ASSERT_TRUE(release_probes().contains("solver/tsvd"));
  Probes now = {{"solver/tsvd", release_probes().at("solver/tsvd")}};
  EXPECT_EQ(probe_difference(stamp->probes, now), "");
  now["solver/tsvd"].numbers[0] *= 2;
  EXPECT_NE(probe_difference(stamp->probes, now), "");
}

TEST(Probes, AStampFromBeforeTheFrontWasRecordedHasItsFirstNumbers) {
  const Probes made = {{"a", probe_of(some_values())}};
  Probes now = made;
  now["front"] = release_probes().at("front");
  EXPECT_EQ(probe_difference(made, now), "");
  EXPECT_EQ(probe_difference(now, now), "");
  now["front"].numbers[0] *= 2;
  EXPECT_TRUE(probe_difference(made, now).starts_with("the probe front differs by"));
}

TEST(Probes, AreComputedOnceAndKeptForTheProgram) {
  const TemporaryFolder folder("probes");
  ::setenv("ERTBENCH_CACHE", folder.path().c_str(), 1);
  int computed = 0;
  const auto compute = [&] {
    ++computed;
    return probe_of(some_values());
  };
  const Probe first = cached_probe("test/kept", compute);
  EXPECT_EQ(cached_probe("test/kept", compute).numbers, first.numbers);
  EXPECT_EQ(computed, 1);
  const auto file = folder.path() / "probes" / stamp_of_this_build().program / "test-kept.json";
  ASSERT_TRUE(std::filesystem::exists(file));

  // Another process reads it: under this name this one has none in memory.
  nlohmann::json content = nlohmann::json::parse(contents_of(file));
  EXPECT_EQ(content.at("numbers").get<std::vector<double>>(), first.numbers);
  std::ofstream(file.parent_path() / "test-damaged.json") << contents_of(file).substr(0, 40);
  EXPECT_FALSE(has_cached_probe("test/damaged"));
  EXPECT_EQ(cached_probe("test/damaged", compute).numbers, first.numbers);
  EXPECT_EQ(computed, 2);
  ::unsetenv("ERTBENCH_CACHE");
}

TEST(Kept, WhatTookLongIsReadTheNextTimeAndADamagedFileIsNot) {
  const TemporaryFolder folder("kept");
  ::setenv("ERTBENCH_CACHE", folder.path().c_str(), 1);
  int computed = 0;
  const auto slowly = [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    return Eigen::MatrixXd(Eigen::MatrixXd::Constant(2, 3, ++computed));
  };
  const auto another = [&] {
    kept_matrix("test", "another", [] { return Eigen::MatrixXd(1, 1); });
  };
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(kept_matrix("test", "recipe", slowly), Eigen::MatrixXd::Constant(2, 3, 1));
    another();  // takes the place in memory, and is too fast to be kept
  }
  const std::vector<std::filesystem::directory_entry> files(
      std::filesystem::directory_iterator(kept_folder()), {});
  ASSERT_EQ(files.size(), 1U);
  EXPECT_TRUE(is_kept_by_this_program(files.front()));
  std::filesystem::resize_file(files.front(), 600);
  EXPECT_EQ(kept_matrix("test", "recipe", slowly), Eigen::MatrixXd::Constant(2, 3, 2));
  another();
  // Those of other programs go.
  std::ofstream(files.front().path().string() + "0") << "x";
  EXPECT_FALSE(is_kept_by_this_program(files.front().path().string() + "0"));
  std::filesystem::remove(files.front());
  EXPECT_EQ(kept_matrix("test", "recipe", slowly), Eigen::MatrixXd::Constant(2, 3, 3));
  EXPECT_FALSE(std::filesystem::exists(files.front().path().string() + "0"));
  ::unsetenv("ERTBENCH_CACHE");
}

}  // namespace
}  // namespace ertbench
