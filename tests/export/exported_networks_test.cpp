// Networks with a front, networks of every kind of layer, and ONNX, held against the program.

#include <gtest/gtest.h>

#include <tuple>

#include "solvers/channel_mask.h"
#include "tests/export/export_testing.h"

namespace ertbench::testing {
namespace {

TEST_F(Export, TheFrontIsTheProgramsOnDamagedFrames) {
  // The rugged network has a front anyway. The code has the moments of what is imputed in floats.
  for (const auto& [solver, more] :
       {std::pair{"lean-net-8-rugged", ""}, {"tsvd", " --front"}, {"lean-net-8", " --front"}}) {
    SCOPED_TRACE(solver);
    const Eigen::MatrixXd own = images(solver, "faults");
    expect_equal(answers(exported(solver, "float32", "gcc", more), "faults").leftCols(pixels), own,
                 2e-6);
    expect_equal(runtime_images(solver, "faults", more), own, 2e-6);
  }
  // Without it the channels of dead electrodes are as they are.
  const FloatRows plain = answers(exported("tsvd", "float32"), "faults").leftCols(pixels);
  EXPECT_GT(relative_difference(plain.cast<double>(), images("tsvd", "faults")), 1);
}

// A robot may boot with a broken electrode: nothing of it changes then.
TEST_F(Export, AnElectrodeThatIsDeadInTheReferenceIsReplaced) {
  FloatRows given = floats_of(path() / "frames.bin", 208);
  const std::vector<ElectrodeSet> users = electrode_sets_of_channels(Sensor{});
  for (const auto& [name, first] : {std::pair{"dead_later", 1}, std::pair{"dead_before", 0}}) {
    for (Eigen::Index c = 0; c < 208; ++c) {
      const bool uses = users[static_cast<std::size_t>(c)] >> 5 & 1;
      if (uses) given.col(c).tail(given.rows() - first).setZero();
    }
    std::ofstream(path() / (std::string(name) + ".bin"), std::ios::binary)
        .write(reinterpret_cast<const char*>(given.data()),
               static_cast<std::streamsize>(sizeof(float)) * given.size());
  }
  const std::string solver = "lean-net-8-rugged";
  const fs::path code = exported(solver, "float32");
  const Eigen::MatrixXd later = answers(code, "dead_later").leftCols(pixels).cast<double>();
  ASSERT_GT(later.norm(), 0);
  expect_equal(answers(code, "dead_before").leftCols(pixels), later, 1e-6);
  expect_equal(runtime_images(solver, "dead_before"), later, 1e-5);
}

TEST_F(Export, CoarseWeightsOfARuggedNetworkCostLittle) {
  const Eigen::MatrixXd own = images("lean-net-8-rugged", "faults");
  for (const auto& [precision, most] : {std::pair{"float16", 0.004}, std::pair{"int8", 0.1}}) {
    const FloatRows found = answers(exported("lean-net-8-rugged", precision), "faults");
    ASSERT_EQ(found.rows(), frames);
    EXPECT_LE(relative_difference(found.leftCols(pixels).cast<double>(), own), most) << precision;
  }
}

TEST_F(Export, NetworksThatAreTrainedHereAreExported) {
  for (const std::string& solver : small_networks()) {
    SCOPED_TRACE(solver);
    const Eigen::MatrixXd own = images(solver);
    expect_equal(answers(exported(solver, "float32")).leftCols(pixels), own, 1e-6);
    expect_equal(runtime_images(solver, "frames"), own, 1e-6);
    for (const auto& [precision, most] : {std::pair{"float16", 0.004}, std::pair{"int8", 0.05}}) {
      const FloatRows found = answers(exported(solver, precision));
      EXPECT_LE(relative_difference(found.leftCols(pixels).cast<double>(), own), most) << precision;
    }
  }
}

TEST_F(Export, OnnxIsValidAndGivesTheProgramsImages) {
  std::vector<std::string> solvers = methods();
  solvers.insert(solvers.end(), small_networks().begin(), small_networks().end());
  bool checked = false;
  bool ran = false;
  for (const std::string& solver : solvers) {
    SCOPED_TRACE(solver);
    const Outcome written = run_program(path(), "export " + solver + " --to onnx --out onnx");
    ASSERT_EQ(written.exit_code, 0) << written.output;
    const std::string name = "onnx/" + stem(solver) + ".onnx";
    const Outcome checker = shell(
        path(), "/usr/bin/python3 " ERTBENCH_SOURCE_DIR "/tests/export/check_onnx.py " + name);
    checked = checked || checker.exit_code == 0;
    EXPECT_TRUE(checker.exit_code == 0 || checker.exit_code == 77) << checker.output;
    const Outcome node = shell(path(), "node " ERTBENCH_SOURCE_DIR "/tests/export/run_onnx.js " +
                                           name + " < frames.bin > images.bin");
    if (node.exit_code == 77 || node.exit_code == 127) continue;
    ASSERT_EQ(node.exit_code, 0) << node.output;
    ran = true;
    expect_equal(floats_of(path() / "images.bin", pixels), images(solver), 1e-5);
  }
  if (!ran) GTEST_SKIP() << "no ONNX runtime in NODE_PATH; " << (checked ? "" : "no python3-onnx");
}

}  // namespace
}  // namespace ertbench::testing
