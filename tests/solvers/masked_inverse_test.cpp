#include "solvers/linear/masked_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/sensor_json.h"
#include "solvers/decompositions.h"
#include "tests/solvers/fault_frames.h"
#include "tests/solvers/prior_matrix.h"
#include "tests/solvers/total_variation_reference.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

constexpr ElectrodeSet masked = 1u << 2 | 1u << 7 | 1u << 8;

/// J without the rows of the channels that use a masked electrode, and the frames without them.
struct Kept {
  explicit Kept(const Frames& frames) {
    const Eigen::MatrixXd whole = ForwardModel(Sensor{}, 24).jacobian();
    const auto pairs = reciprocal_pairs(Sensor{});
    std::vector<int> channels;
    for (const Eigen::Index p : pairs_without({}, masked)) {
      for (const int channel : pairs[static_cast<std::size_t>(p)]) channels.push_back(channel);
    }
    jacobian = whole(channels, Eigen::all);
    changes = frames(Eigen::all, channels);
  }
  Eigen::MatrixXd jacobian;
  Frames changes;
};

Images images_of(json spec, const json& mask, Frames changes) {
  spec["channel_mask"] = mask;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) read_zero(changes.row(f), masked);
  return reconstruct(*fitted(spec), changes).images;
}

class MaskedPrior : public ::testing::TestWithParam<Prior> {};

TEST_P(MaskedPrior, IsTheDenseSolutionWithoutTheseRows) {
  const Frames changes = random_changes(3);
  const Kept kept(changes);
  const Eigen::MatrixXd prior = prior_matrix(GetParam(), ForwardModel(Sensor{}, 24).jacobian());
  for (const double lambda : {0.01, 0.1, 1.0}) {
    const Eigen::MatrixXd matrix =
        kept.jacobian.transpose() * kept.jacobian + lambda * lambda * prior;
    const Images expected = matrix.partialPivLu()
                                .solve(kept.jacobian.transpose() * kept.changes.transpose())
                                .transpose();
    const json spec = {{"type", "one-step-gn"}, {"prior", name_of(GetParam())}, {"lambda", lambda}};
    EXPECT_LT(relative_difference(images_of(spec, "detect", changes), expected), 1e-8) << lambda;
    EXPECT_LT(relative_difference(images_of(spec, {2, 7, 8}, changes), expected), 1e-8) << lambda;
  }
}

TEST(MaskedGaussNewton, IsThatOfTheSensorWithoutTheseChannels) {
  const Frames changes = random_changes(2);
  const auto electrodes = electrode_sets_of_channels({});
  std::vector<int> kept;
  std::vector<ChannelElectrodes> channels;
  for (int c = 0; c < changes.cols(); ++c) {
    if (electrodes[static_cast<std::size_t>(c)] & masked) continue;
    kept.push_back(c);
    channels.push_back(electrodes_of_channels({})[static_cast<std::size_t>(c)]);
  }
  const json spec = {{"type", "one-step-gn"}, {"prior", "tikhonov"}, {"lambda", 0.03}};
  FitInput smaller;
  smaller.sensor = with_channels({}, channels);
  const auto anew = make_solver(spec);
  anew->fit(smaller);
  EXPECT_LT(relative_difference(images_of(spec, "detect", changes),
                                reconstruct(*anew, changes(Eigen::all, kept)).images),
            1e-8);
}

INSTANTIATE_TEST_SUITE_P(All, MaskedPrior,
                         ::testing::Values(Prior::tikhonov, Prior::noser, Prior::laplace),
                         [](const auto& instance) { return name_of(instance.param); });

TEST(MaskedTsvd, IsThePseudoinverseOfTheTruncatedRest) {
  const Frames changes = random_changes(3);
  const Kept kept(changes);
  const DenseSvd svd = dense_svd(kept.jacobian);
  const Eigen::VectorXd whole = dense_svd(ForwardModel(Sensor{}, 24).jacobian()).values;
  const auto expected = [&](Eigen::Index rank) -> Images {
    return (svd.right.leftCols(rank) *
            (svd.values.head(rank).cwiseInverse().asDiagonal() *
             (svd.left.leftCols(rank).transpose() * kept.changes.transpose())))
        .transpose();
  };
  for (const int rank : {6, 20, 45}) {
    const json spec = {{"type", "tsvd"}, {"rank", rank}};
    // Values down to the smallest that is kept of the whole: by interlacing, rank of them or fewer.
    const Eigen::Index same_cut = (svd.values.array() >= whole[rank - 1] * (1 - 1e-9)).count();
    EXPECT_LE(same_cut, rank);
    EXPECT_LT(relative_difference(images_of(spec, "detect", changes), expected(same_cut)), 1e-8);
    EXPECT_LT(relative_difference(images_of(spec, {2, 7, 8}, changes), expected(rank)), 1e-8);
  }
}

TEST(MaskedTsvd, RefusesARankAboveWhatIsLeft) {
  const json spec = {{"type", "tsvd"}, {"rank", 70}, {"channel_mask", {2, 7, 8}}};
  const auto pairs = pairs_without({}, masked).size();
  const std::string message =
      message_of<std::exception>([&] { make_solver(spec)->check(Sensor{}); });
  EXPECT_NE(message.find("must be <= " + std::to_string(pairs)), std::string::npos) << message;
}

TEST(MaskedPdipm, ReachesTheMinimumThatASlowMethodFinds) {
  Sensor sensor;
  sensor.image_grid = 8;
  const double alpha = 1e-6;
  const DenseTotalVariation reference(sensor, alpha, masked);
  const Eigen::VectorXd voltages = ForwardModel(sensor, 8).reference_voltages();
  Frames seen = random_changes(2, sensor);  // zero where nothing is seen
  Frames measured = seen;
  const auto electrodes = electrodes_of_pairs(sensor);
  const auto pairs = reciprocal_pairs(sensor);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (!(electrodes[p] & masked)) continue;
    for (const int channel : pairs[p]) {
      seen.col(channel).setZero();
      measured.col(channel).setConstant(-voltages[channel]);
    }
  }
  for (const json& mask : {json{2, 7, 8}, json("detect")}) {
    const json spec = {{"type", "pdipm"}, {"alpha", alpha}, {"channel_mask", mask}};
    const Reconstruction out = reconstruct(*fitted(spec, sensor), measured, sensor);
    for (Eigen::Index f = 0; f < seen.rows(); ++f) {
      const Eigen::VectorXd d = seen.row(f);
      const double slow = reference.objective(reference.admm(d, 20000), d);
      const double ours = reference.objective(out.images.row(f), d);
      EXPECT_EQ(out.reports[static_cast<std::size_t>(f)].status, FrameStatus::ok);
      EXPECT_LE(ours, slow * (1 + 1e-4)) << mask;
      EXPECT_LE(slow, ours * (1 + 1e-3)) << mask;
    }
  }
}

TEST(Reciprocity, OfAPartOfTheChannelsKeepsTheNormalEquations) {
  const nlohmann::json description = {
      {"shape", "disc"},
      {"diameter_mm", 200},
      {"channels",
       {{0, 1, 2, 3}, {5, 9, 2, 3}, {2, 3, 0, 1}, {4, 5, 6, 7}, {7, 6, 5, 4}, {6, 7, 8, 9}}},
      {"count_from", 0}};
  const Sensor sensor = sensor_from_json(JsonObject(description, "test", ""));
  const RowMajorMatrix jacobian = border_jacobian(sensor);
  const Reciprocity reciprocity(sensor);
  EXPECT_EQ(reciprocity.pairs(), 4);
  EXPECT_EQ(reciprocity.channels(), 6);
  const Eigen::MatrixXd reduced = reciprocity.reduce_rows(jacobian);
  const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
  EXPECT_LT((reduced.transpose() * reduced - normal).norm(), 1e-10 * normal.norm());
  const Eigen::RowVectorXd frame = Eigen::RowVectorXd::LinSpaced(6, 1, 2);
  const Eigen::VectorXd right = jacobian.transpose() * frame.transpose();
  EXPECT_LT((reduced.transpose() * reciprocity.reduce(frame) - right).norm(), 1e-10 * right.norm());
  Eigen::VectorXd sums(reciprocity.pairs());
  reciprocity.sum(frame.data(), sums.data());
  EXPECT_LT((sums / std::numbers::sqrt2 - reciprocity.reduce(frame)).norm(), 1e-12);
}

}  // namespace
}  // namespace ertbench
