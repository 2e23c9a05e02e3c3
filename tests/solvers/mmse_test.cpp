#include "solvers/linear/mmse.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "core/errors.h"
#include "core/random.h"
#include "forward/border/border_model.h"
#include "forward/data/generate.h"
#include "forward/fem/forward_model.h"
#include "solvers/linear/mixture.h"
#include "tests/solvers/fault_frames.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

TEST(MmseMatrix, IsThePosteriorMeanOfALinearModelWithAGaussianPrior) {
  // In the form that inverts the covariance of the image: (H^T H / s^2 + C^-1)^-1 H^T / s^2.
  const Eigen::MatrixXd model = random_matrix(7, 12, 1);
  const Eigen::MatrixXd root = random_matrix(12, 12, 2);
  const Eigen::MatrixXd prior = root * root.transpose() + Eigen::MatrixXd::Identity(12, 12);
  const double noise = 0.3;
  const Eigen::MatrixXd expected = (model.transpose() * model / (noise * noise) + prior.inverse())
                                       .partialPivLu()
                                       .solve(Eigen::MatrixXd(model.transpose() / (noise * noise)));
  Eigen::MatrixXd changes = model * prior * model.transpose();
  const double added = noise * noise;
  EXPECT_LT(relative_difference(mmse_matrix(changes, prior * model.transpose(), added), expected),
            1e-12);
  changes.diagonal().array() += noise * noise;
  EXPECT_LT(relative_difference(mmse_matrix(changes, prior * model.transpose(), 0), expected),
            1e-12);
}

TEST(MmseMatrix, IsTikhonovsForAWhitePrior) {
  const double lambda = 0.02;
  const Sensor sensor;
  const Reciprocity reciprocity(sensor);
  const Eigen::MatrixXd jacobian = reciprocity.reduce_rows(ForwardModel(sensor, 24).jacobian());
  Eigen::MatrixXd changes = jacobian * jacobian.transpose();
  changes.diagonal().array() += lambda * lambda;
  const Eigen::MatrixXd matrix = mmse_matrix(changes, jacobian.transpose(), 0);
  const Frames frames = random_changes(3);
  const Images images =
      reconstruct(*fitted({{"type", "one-step-gn"}, {"prior", "tikhonov"}, {"lambda", lambda}}),
                  frames)
          .images;
  for (Eigen::Index f = 0; f < 3; ++f) {
    const Eigen::VectorXd image = matrix * reciprocity.reduce(frames.row(f));
    EXPECT_LT(relative_difference(image.transpose(), images.row(f)), 1e-8);
  }
}

/// Training and validation sets of random contacts.
class Sets {
 public:
  static const Sets& get() {
    static const Sets sets;
    return sets;
  }
  FitInput input() const {
    FitInput input;
    input.training = &training_;
    input.validation = &validation_;
    return input;
  }
  std::unique_ptr<Solver> fit(const json& spec) const {
    std::unique_ptr<Solver> solver = make_solver(spec);
    solver->fit(input());
    return solver;
  }

 private:
  static DatasetFile write(const std::filesystem::path& file, const std::string& name,
                           std::uint64_t count) {
    DatasetSpec spec = random_contacts(count, {}, 0.05);
    spec.name = name;
    generate_dataset(spec, file);
    return DatasetFile(file);
  }
  TemporaryFolder folder_;
  DatasetFile training_ = write(folder_ / "training.h5", "training", 3000);
  DatasetFile validation_ = write(folder_ / "validation.h5", "validation", 300);
};

TEST(Lmmse, IsTheRegressionOfTheTrainingImagesOnTheirChanges) {
  // Least squares by QR over all scenes, the ridge as further rows.
  const double ridge = 1e-5;
  const FitInput input = Sets::get().input();
  const DatasetFile& set = *input.training;
  const Reciprocity reciprocity(input.sensor);
  const Frames voltages = set.voltages(0, set.size());
  const auto scenes = voltages.rows();
  const Eigen::Index pairs = reciprocity.pairs();
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(scenes + pairs, pairs);
  Eigen::MatrixXd images = Eigen::MatrixXd::Zero(scenes + pairs, input.sensor.pixels());
  images.topRows(scenes) = set.conductivity(0, set.size()).array() - input.sensor.background;
  for (Eigen::Index f = 0; f < scenes; ++f) {
    design.row(f) =
        reciprocity.reduce(voltages.row(f) - set.reference_voltages().transpose()).transpose();
  }
  const double square = design.squaredNorm() / static_cast<double>(pairs);
  design.bottomRows(pairs).diagonal().setConstant(std::sqrt(ridge * square));
  const Eigen::MatrixXd matrix = design.householderQr().solve(images).transpose();

  const auto solver = Sets::get().fit({{"type", "lmmse"}, {"ridge", ridge}, {"symmetries", false}});
  const Frames changes = fresh_changes(4);
  const Images ours = reconstruct(*solver, changes).images;
  for (Eigen::Index f = 0; f < 4; ++f) {
    const Eigen::VectorXd expected = matrix * reciprocity.reduce(changes.row(f));
    // Images are learned from in single precision.
    EXPECT_LT(relative_difference(ours.row(f), expected.transpose()), 1e-5);
  }
}

TEST(Lmmse, TurnsItsImageWithTheFrame) {
  const auto solver = Sets::get().fit({{"type", "lmmse"}, {"ridge", 1e-5}});
  const Frames changes = fresh_changes(3);
  const Images images = reconstruct(*solver, changes).images;
  for (const Symmetry& turn : symmetries(Sensor{})) {
    const Frames turned = changes(Eigen::all, turn.channels);
    const Images expected = images(Eigen::all, turn.pixels);
    EXPECT_LT(relative_difference(reconstruct(*solver, turned).images, expected), 1e-8);
  }
}

TEST(Lmmse, SeesContactsBesideNuisancesOfItsCovariance) {
  // A sheet of 10 % less conductivity, and one electrode moved by 5 mm of 200 since the reference,
  // both exact. Without the nuisances they are the image.
  const FitInput input = Sets::get().input();
  const DatasetFile& set = *input.validation;
  const Frames sound = set.voltages(0, set.size());
  const Images truth = set.conductivity(0, set.size()).array() - input.sensor.background;
  const Eigen::RowVectorXd reference = set.reference_voltages().transpose();
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(16);
  moved[5] = 0.05;
  const Eigen::RowVectorXd by_move = (BorderModel(input.sensor, moved).reference_voltages() -
                                      BorderModel(input.sensor).reference_voltages())
                                         .transpose();
  const Frames level = (sound / 0.9).rowwise() - reference;
  const Frames displaced = sound.rowwise() - (reference - by_move);
  const Frames clean = sound.rowwise() - reference;
  const json deviations = {{"level", 0.1}, {"electrodes", 0.03}};
  for (const int components : {1, 4}) {
    const json spec = {{"type", "lmmse"}, {"ridge", 1e-5}, {"components", components}};
    json with = spec;
    with["nuisances"] = deviations;
    const auto plain = Sets::get().fit(spec);
    const auto rugged = Sets::get().fit(with);
    const auto error = [&](const Solver& solver, const Frames& frames) {
      return (reconstruct(solver, frames).images - truth).norm() / truth.norm();
    };
    const double usual = error(*plain, clean);
    EXPECT_LT(error(*rugged, clean), 1.25 * usual);
    for (const Frames* frames : {&level, &displaced}) {
      EXPECT_GT(error(*plain, *frames), 1.05 * usual);
      EXPECT_LT(error(*rugged, *frames), 1.1 * error(*rugged, clean));
    }
    EXPECT_EQ(rugged->parameters().at("nuisances").at("level"), 0.1);
  }
}

TEST(Lmmse, MasksByTheMomentsOfWhatIsLeft) {
  constexpr ElectrodeSet masked = 1u << 2 | 1u << 7;
  const double ridge = 1e-4;
  const FitInput input = Sets::get().input();
  const JointMoments moments = moments_of(TrainingScenes(input, "test", true), {}, true);
  const std::vector<Eigen::Index> kept = pairs_without({}, masked);
  const Eigen::MatrixXd matrix =
      mmse_matrix(moments.changes(kept, kept), moments.cross(Eigen::all, kept),
                  ridge * moments.changes.diagonal().mean());
  Frames changes = fresh_changes(3);
  const Reciprocity reciprocity{Sensor{}};
  for (const json& mask : {json{2, 7}, json("detect")}) {
    const auto solver =
        Sets::get().fit({{"type", "lmmse"}, {"ridge", ridge}, {"channel_mask", mask}});
    for (Eigen::Index f = 0; f < 3; ++f) {
      read_zero(changes.row(f), masked);
      const Eigen::VectorXd expected = matrix * reciprocity.reduce(changes.row(f))(kept);
      EXPECT_LT(
          relative_difference(reconstruct(*solver, changes.row(f)).images, expected.transpose()),
          1e-8);
    }
  }
}

/// Mean relative error on frames like those of the training, at this noise.
double error_at(const Solver& solver, double snr_db) {
  DatasetSpec spec = random_contacts(200);
  spec.seed = 9;
  spec.noise.snr_db = snr_db;
  const DatasetBlock block = generate_block(spec, SceneModel(Sensor{}, GridSheet{24}), 0, 200);
  const Frames changes =
      block.voltages.rowwise() - ForwardModel(Sensor{}, 24).reference_voltages().transpose();
  const RowMajorMatrix truth = block.conductivity.array() - Sensor{}.background;
  const Images images = reconstruct(solver, changes).images;
  return ((images - truth).rowwise().norm().array() / truth.rowwise().norm().array()).mean();
}

TEST(Lmmse, FollowsTheNoiseOfItsFrames) {
  const json spec = {{"type", "lmmse"}, {"ridge", 1e-3}};
  json follows = spec;
  follows["inference_noise"] = "frame";
  const auto fixed = Sets::get().fit(spec);
  const auto following = Sets::get().fit(follows);
  EXPECT_EQ(following->parameters().at("inference_noise"), "frame");
  EXPECT_LT(error_at(*following, 30), 0.8 * error_at(*fixed, 30));
  EXPECT_LT(error_at(*following, 40), 0.99 * error_at(*fixed, 40));
  EXPECT_NEAR(error_at(*following, 50), error_at(*fixed, 50), 0.01);
  EXPECT_LT(error_at(*following, 60), error_at(*fixed, 60));
  // Channels that are ignored tell no noise.
  Frames frame = fresh_changes(1);
  follows["channel_mask"] = {2, 7};
  const Images listed = reconstruct(*Sets::get().fit(follows), frame).images;
  follows["channel_mask"] = "detect";
  read_zero(frame.row(0), 1u << 2 | 1u << 7);
  const Images detected = reconstruct(*Sets::get().fit(follows), frame).images;
  EXPECT_LT(relative_difference(detected, listed), 1e-10);
}

double error_of(const Solver& solver) {
  const ValidationFrames frames = read_validation_frames(Sets::get().input(), "test");
  return mean_relative_error(solver, frames, 1);
}

TEST(Lmmse, IsMoreAccurateThanOneStepGaussNewtonAndWithComponentsMoreSo) {
  const double gauss_newton = error_of(*Sets::get().fit({{"type", "one-step-gn"}}));
  const auto linear = Sets::get().fit({{"type", "lmmse"}});
  const auto mixture = Sets::get().fit({{"type", "lmmse"}, {"components", 8}});
  EXPECT_GT(linear->parameters()["ridge"].get<double>(), 0);
  EXPECT_LT(error_of(*linear), 0.95 * gauss_newton);
  EXPECT_LT(error_of(*mixture), 0.97 * error_of(*linear));
}

TEST(Lmmse, NeedsATrainingSet) {
  for (const int components : {1, 2}) {
    const auto solver = make_solver({{"type", "lmmse"}, {"components", components}});
    EXPECT_TRUE(solver->needs_training());
    EXPECT_EQ(message_of<InputError>([&] {
                solver->fit(FitInput{});
              }).find("lmmse: needs a training set"),
              0u);
  }
}

TEST(KMeans, FindsGroupsThatLieApart) {
  Eigen::MatrixXf points(300, 2);
  RandomStream random(5, 0, 0, Purpose::scene);
  for (Eigen::Index i = 0; i < 300; ++i) {
    const auto group = static_cast<float>(i % 3);
    points.row(i) << 10 * group + static_cast<float>(random.normal()),
        static_cast<float>(random.normal());
  }
  const auto groups = k_means(points, 3);
  ASSERT_EQ(groups.size(), 3u);
  for (const auto& group : groups) {
    ASSERT_EQ(group.size(), 100u);
    for (const Eigen::Index i : group) EXPECT_EQ(i % 3, group.front() % 3);
  }
}

TEST(KMeans, LeavesOutGroupsThatWouldBeEmpty) {
  EXPECT_EQ(k_means(Eigen::MatrixXf::Ones(5, 3), 4).size(), 1u);
}

/// A mixture whose posterior mean can be computed by its definition.
TEST(MixtureMean, IsThePosteriorMeanByBayesRule) {
  const Eigen::Index pairs = 10;
  const Eigen::Index pixels = 5;
  GaussianMixture mixture;
  for (std::uint64_t k = 0; k < 3; ++k) {
    const Eigen::MatrixXd root = random_matrix(pairs, pairs, 10 + k);
    GaussianMixture::Component c;
    c.weight = 0.2 + 0.1 * static_cast<double>(k);
    c.change_mean = random_matrix(pairs, 1, 20 + k);
    c.image_mean = random_matrix(pixels, 1, 30 + k);
    c.changes = root * root.transpose() + Eigen::MatrixXd::Identity(pairs, pairs);
    c.cross = random_matrix(pixels, pairs, 40 + k);  // times the directions, which are set below
    mixture.components.push_back(c);
  }
  // Any orthogonal basis will do where it is complete.
  mixture.directions =
      Eigen::MatrixXd(random_matrix(pairs, pairs, 50).householderQr().householderQ());
  std::vector<Eigen::MatrixXd> cross;
  for (GaussianMixture::Component& c : mixture.components) {
    cross.push_back(c.cross);
    c.cross = (c.cross * mixture.directions).eval();
  }
  for (const std::vector<Eigen::Index>& kept :
       {std::vector<Eigen::Index>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9},
        std::vector<Eigen::Index>{0, 2, 3, 5, 9}}) {
    const MixtureMean mean(mixture, kept, 0);
    for (std::uint64_t frame = 0; frame < 5; ++frame) {
      const Eigen::VectorXd d = random_matrix(pairs, 1, 60 + frame);
      Eigen::VectorXd expected = Eigen::VectorXd::Zero(pixels);
      double total = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const GaussianMixture::Component& c = mixture.components[k];
        const Eigen::MatrixXd covariance = c.changes(kept, kept);
        const Eigen::VectorXd off = d(kept) - c.change_mean(kept);
        const Eigen::VectorXd solved = covariance.partialPivLu().solve(off);
        const double density =
            c.weight * std::exp(-0.5 * off.dot(solved)) / std::sqrt(covariance.determinant());
        total += density;
        expected += density * (c.image_mean + cross[k](Eigen::all, kept) * solved);
      }
      expected /= total;
      Eigen::RowVectorXd image(pixels);
      mean.estimate(d * std::sqrt(2.0), image);
      // Components of less than a thousandth are left out; single precision.
      EXPECT_LT((image.transpose() - expected).norm(), 5e-3 * expected.norm() + 1e-4);
    }
  }
}

}  // namespace
}  // namespace ertbench
