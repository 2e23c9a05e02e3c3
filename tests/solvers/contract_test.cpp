// What every solver promises (solvers/solver.h), for each of the classical ones and one of a
// plugin, as the registry makes them.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <thread>

#include "core/errors.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"
#include "tests/solvers/fault_frames.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// Fitted; solvers that learn on the validation set's scenes.
std::unique_ptr<Solver> taught(const json& spec, const FitInput& with = {}) {
  static const ValidationFile scenes(1000);
  std::unique_ptr<Solver> solver = make_solver(spec);
  FitInput input = with;
  if (solver->needs_training()) input.training = scenes.input().validation;
  solver->fit(input);
  return solver;
}

class SolverContract : public ::testing::TestWithParam<json> {
 protected:
  /// Twelve frames: blank, noise alone, contacts, a large one.
  static Frames frames() {
    Frames changes = random_changes(12);
    changes.row(0).setZero();
    changes.row(1) = 1e-3 * (changes.row(2) - changes.row(3));
    changes.row(5) *= 100;
    return changes;
  }
  static bool linear() {
    return GetParam()["type"] != "pdipm" && GetParam()["type"] != "gauss-newton" &&
           GetParam()["type"] != "contacts" && GetParam()["type"] != "kernel-ridge";
  }
  static bool is_mixture() { return GetParam().value("components", 1) > 1; }

  std::unique_ptr<Solver> solver_ = taught(GetParam());
};

TEST_P(SolverContract, ABatchIsTheSameAsItsFrames) {
  const Frames changes = frames();
  const Reconstruction batch = reconstruct(*solver_, changes);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const Reconstruction single = reconstruct(*solver_, changes.row(f));
    EXPECT_EQ(single.reports[0].status, batch.reports[static_cast<std::size_t>(f)].status);
    if (linear()) {
      // Sums of 104 products, in another order.
      EXPECT_LE((single.images - batch.images.row(f)).norm(), 1e-13 * single.images.norm());
    } else {
      EXPECT_EQ(single.images.row(0), batch.images.row(f));
    }
  }
}

/// Twelve steps of a disc across the sheet.
Frames sequence() {
  const BorderModel model(Sensor{});
  Frames changes(12, Sensor{}.channels());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    Contact disc;
    disc.centre = {-0.4 + 0.06 * static_cast<double>(f), 0.2};
    disc.half_size = {0.25, 0.25};
    disc.conductivity_ratio = 0.5;
    changes.row(f) = model.solve({{disc}}, 1e-6).change.transpose();
  }
  return changes;
}

TEST_P(SolverContract, AStreamIsItsFramesInTheirOrder) {
  const Frames changes = sequence();
  const Reconstruction alone = reconstruct(*solver_, changes);
  const auto stream = solver_->open_stream();
  ASSERT_NE(stream, nullptr);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    Images image(1, Sensor{}.pixels());
    std::vector<FrameReport> report(1);
    stream->reconstruct(changes.row(f), image, report);
    EXPECT_EQ(report[0].status, alone.reports[static_cast<std::size_t>(f)].status);
    if (GetParam()["type"] == "contacts") {
      // From another start, to the same contacts as far as the frame knows them.
      EXPECT_LT((image.row(0) - alone.images.row(f)).norm(), 0.2 * alone.images.row(f).norm()) << f;
      ASSERT_NE(stream->contacts(), nullptr);
      ASSERT_EQ(stream->contacts()->size(), 1U) << f;
    } else {
      EXPECT_LE((image.row(0) - alone.images.row(f)).norm(),
                linear() ? 1e-13 * alone.images.row(f).norm() : 0)
          << f;
      EXPECT_EQ(stream->contacts(), nullptr);
    }
  }
}

TEST_P(SolverContract, AStreamForgetsAFrameThatIsNotFinite) {
  Frames changes = sequence();
  changes(5, 3) = std::numeric_limits<double>::quiet_NaN();
  const auto stream = solver_->open_stream();
  Images images(changes.rows(), Sensor{}.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(changes.rows()));
  stream->reconstruct(changes, images, reports);
  const Reconstruction alone = reconstruct(*solver_, changes);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    EXPECT_EQ(reports[static_cast<std::size_t>(f)].status,
              alone.reports[static_cast<std::size_t>(f)].status);
    if (f == 5) continue;
    EXPECT_LE((images.row(f) - alone.images.row(f)).norm(), 0.2 * alone.images.row(f).norm()) << f;
  }
}

TEST_P(SolverContract, TwoThreadsMayShareASolver) {
  const Frames changes = frames();
  const Reconstruction alone = reconstruct(*solver_, changes);
  Reconstruction first;
  Reconstruction second;
  std::thread a([&] { first = reconstruct(*solver_, changes); });
  std::thread b([&] { second = reconstruct(*solver_, changes); });
  a.join();
  b.join();
  EXPECT_EQ(first.images, alone.images);
  EXPECT_EQ(second.images, alone.images);
}

TEST_P(SolverContract, ReadsFramesAndWritesImagesInsideLargerArrays) {
  const Frames changes = frames();
  Frames wide = Frames::Constant(changes.rows(), changes.cols() + 5, 7.0);
  wide.middleCols(2, changes.cols()) = changes;
  const Sensor sensor;
  Images around = Images::Constant(changes.rows(), sensor.pixels() + 4, -3.0);
  std::vector<FrameReport> reports(static_cast<std::size_t>(changes.rows()));
  solver_->reconstruct(wide.middleCols(2, changes.cols()), around.middleCols(1, sensor.pixels()),
                       reports);
  EXPECT_EQ(Images(around.middleCols(1, sensor.pixels())), reconstruct(*solver_, changes).images);
  EXPECT_TRUE((around.leftCols(1).array() == -3).all());
  EXPECT_TRUE((around.rightCols(3).array() == -3).all());
}

TEST_P(SolverContract, ASavedSolverIsTheSameAgain) {
  const TemporaryFolder folder;
  solver_->save(folder / "solver.h5");
  json other = GetParam();
  other.erase("rank");
  other.erase("lambda");
  other.erase("alpha");
  other.erase("prior");
  const std::unique_ptr<Solver> loaded = make_solver(other);
  loaded->load(folder / "solver.h5", Sensor{});
  EXPECT_EQ(loaded->parameters(), solver_->parameters());
  const Frames changes = frames();
  EXPECT_EQ(reconstruct(*loaded, changes).images, reconstruct(*solver_, changes).images);
}

TEST_P(SolverContract, RefusesTheFileOfAnotherSensor) {
  const TemporaryFolder folder;
  solver_->save(folder / "solver.h5");
  Sensor other;
  other.background = 0.05;
  const std::string message =
      message_of<InputError>([&] { make_solver(GetParam())->load(folder / "solver.h5", other); });
  EXPECT_NE(message.find("solver.h5"), std::string::npos) << message;
  EXPECT_NE(message.find("sensor"), std::string::npos) << message;
}

TEST_P(SolverContract, RefusesTheFileOfAnotherSolver) {
  const TemporaryFolder folder;
  solver_->save(folder / "solver.h5");
  const json other = linear() && GetParam()["type"] != "one-step-gn"
                         ? json{{"type", "one-step-gn"}, {"lambda", 1}}
                         : json{{"type", "tsvd"}, {"rank", 3}};
  const std::string message =
      message_of<InputError>([&] { make_solver(other)->load(folder / "solver.h5", Sensor{}); });
  EXPECT_NE(message.find(GetParam()["type"].get<std::string>()), std::string::npos) << message;
}

TEST_P(SolverContract, RefusesAFileThatIsNotThere) {
  const std::string message = message_of<InputError>(
      [&] { make_solver(GetParam())->load("/nowhere/solver.h5", Sensor{}); });
  EXPECT_EQ(message, "/nowhere/solver.h5: there is no such file");
}

TEST_P(SolverContract, ItsParametersMakeItAgain) {
  json spec = solver_->parameters();
  spec["type"] = GetParam()["type"];
  const std::unique_ptr<Solver> again = taught(spec);
  EXPECT_EQ(again->parameters(), solver_->parameters());
  const Frames changes = frames();
  EXPECT_EQ(reconstruct(*again, changes).images, reconstruct(*solver_, changes).images);
}

TEST_P(SolverContract, AZeroFrameGivesAZeroImage) {
  if (is_mixture()) GTEST_SKIP() << "the prior of a mixture has a mean";
  const Reconstruction blank = reconstruct(*solver_, Frames::Zero(1, Sensor{}.channels()));
  EXPECT_TRUE((blank.images.array() == 0).all());
  EXPECT_EQ(blank.reports[0].status, FrameStatus::ok);
}

TEST_P(SolverContract, AFrameThatIsNotFiniteIsUndefinedAndAloneInThat) {
  Frames changes = frames();
  const Reconstruction before = reconstruct(*solver_, changes);
  changes(3, 17) = std::numeric_limits<double>::quiet_NaN();
  changes(7, 0) = std::numeric_limits<double>::infinity();
  const Reconstruction after = reconstruct(*solver_, changes);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const bool broken = f == 3 || f == 7;
    const FrameReport& report = after.reports[static_cast<std::size_t>(f)];
    EXPECT_EQ(report.status == FrameStatus::undefined, broken) << f;
    if (!broken) {
      EXPECT_EQ(after.images.row(f), before.images.row(f)) << f;
    }
  }
  EXPECT_EQ(reconstruct(*solver_, changes.row(3)).reports[0].status, FrameStatus::undefined);
}

/// What is asked only of the solvers that invert the model and have a file format of ours.
class ClassicalContract : public SolverContract {};

TEST_P(ClassicalContract, RefusesAFileThatIsNoSolver) {
  EXPECT_THROW(make_solver(GetParam())->load(ERTBENCH_TEST_DATA "/eidors_d2s.h5", Sensor{}),
               InputError);
}

TEST_P(ClassicalContract, SeesAContactWhereItIs) {
  // The scenes of EIDORS's with weak contacts (0.6 of the background), which J describes.
  const Images truths = eidors().read_rows("/scenes/conductivity", 0, 3).array() - 0.06;
  const Images images = reconstruct(*solver_, eidors_changes().topRows(3)).images;
  for (Eigen::Index f = 0; f < truths.rows(); ++f) {
    const double cosine =
        images.row(f).dot(truths.row(f)) / images.row(f).norm() / truths.row(f).norm();
    EXPECT_GT(cosine, 0.5) << f;  // about 0 for an image that has nothing to do with the truth
  }
}

TEST_P(SolverContract, RefusesUseBeforeItIsFitted) {
  const std::unique_ptr<Solver> raw = make_solver(GetParam());
  const TemporaryFolder folder;
  EXPECT_THROW(reconstruct(*raw, frames()), std::logic_error);
  EXPECT_THROW(raw->save(folder / "solver.h5"), std::logic_error);
}

TEST_P(SolverContract, RefusesAnUnknownParameter) {
  json spec = GetParam();
  spec["lamda"] = 1;
  const std::string message = message_of<InputError>([&] { make_solver(spec); });
  EXPECT_EQ(message.find("spec.json: /lamda: unknown key"), 0u) << message;
}

/// With the check of frames fitted, on 300 validation frames.
class FramesNotToBeTrusted : public SolverContract {
 protected:
  static std::unique_ptr<Solver> validated(const json& more = json::object()) {
    static const ValidationFile validation(300);
    json spec = GetParam();
    spec.update(more);
    return taught(spec, validation.input());
  }
  /// Iterations take their time.
  static std::uint64_t count() { return linear() ? 2000 : 400; }
  static bool too_slow() {
#ifdef __SANITIZE_ADDRESS__
    return !linear();
#else
    return false;
#endif
  }
  static double share(const Reconstruction& out, FrameStatus status, int reasons) {
    const auto is_one = [&](const FrameReport& report) {
      return report.status == status && (report.reasons & reasons) == reasons;
    };
    return static_cast<double>(std::count_if(out.reports.begin(), out.reports.end(), is_one)) /
           static_cast<double>(out.reports.size());
  }
};

TEST_P(FramesNotToBeTrusted, AreFewAmongGoodOnes) {
  if (too_slow()) GTEST_SKIP() << "hundreds of iterated frames under the sanitizers";
  const Reconstruction out = reconstruct(*validated(), fresh_changes(count()));
  EXPECT_LE(share(out, FrameStatus::suspect, 0), 0.01);
}

TEST_P(FramesNotToBeTrusted, HaveDeadElectrodes) {
  if (too_slow()) GTEST_SKIP() << "hundreds of iterated frames under the sanitizers";
  const auto solver = validated();
  RandomStream random(1, 0, 0, Purpose::scene);
  for (const bool zero : {true, false}) {
    Frames changes = fresh_changes(count());
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const ElectrodeSet dead = random_electrodes(1 + static_cast<int>(f % 4), random);
      zero ? read_zero(changes.row(f), dead) : read_noise(changes.row(f), dead, random);
    }
    EXPECT_GE(share(reconstruct(*solver, changes), FrameStatus::suspect, dead_electrode), 0.99);
  }
}

TEST_P(FramesNotToBeTrusted, HaveMoreNoiseThanTheSolverWasFittedFor) {
  if (too_slow()) GTEST_SKIP() << "hundreds of iterated frames under the sanitizers";
  const Reconstruction out = reconstruct(*validated(), fresh_changes(count(), 30));
  EXPECT_GE(share(out, FrameStatus::suspect, noise), 0.99);
}

TEST_P(FramesNotToBeTrusted, AreNotLookedForWhereThatIsOff) {
  const Frames changes = fresh_changes(20, 30);
  const Reconstruction on = reconstruct(*validated(), changes);
  const Reconstruction off = reconstruct(*validated({{"inference_check", false}}), changes);
  EXPECT_EQ(off.images, on.images);
  EXPECT_EQ(share(off, FrameStatus::ok, 0), 1);
}

TEST_P(FramesNotToBeTrusted, AreTheSameToASavedSolver) {
  const auto solver = validated();
  const TemporaryFolder folder;
  solver->save(folder / "solver.h5");
  const auto loaded = make_solver(GetParam());
  loaded->load(folder / "solver.h5", Sensor{});
  Frames changes = fresh_changes(40);
  read_zero(changes.row(1), 1u << 4);
  changes.row(2) *= 20;
  changes.middleRows(3, 10) = fresh_changes(10, 40);
  const Reconstruction before = reconstruct(*solver, changes);
  const Reconstruction after = reconstruct(*loaded, changes);
  EXPECT_EQ(before.reports[1].reasons & ~unexplained, dead_electrode);
  for (std::size_t f = 0; f < before.reports.size(); ++f) {
    EXPECT_EQ(after.reports[f].status, before.reports[f].status);
    EXPECT_EQ(after.reports[f].reasons, before.reports[f].reasons);
  }
}

/// Of solvers with a "channel_mask".
class MaskedFrames : public FramesNotToBeTrusted {};

TEST_P(MaskedFrames, AreImagedWithoutTheirDeadElectrodes) {
  const auto solver = validated({{"channel_mask", "detect"}});
  Frames changes = fresh_changes(6);
  const Reconstruction good = reconstruct(*solver, changes);
  EXPECT_EQ(good.images, reconstruct(*validated(), changes).images);
  for (const Eigen::Index f : {1, 2, 3}) read_zero(changes.row(f), 1u << 2 | 1u << 7);
  read_zero(changes.row(4), 0x1249);  // 0, 3, 6, 9 and 12
  const Reconstruction masked = reconstruct(*solver, changes);
  for (const std::size_t f : {1, 2, 3}) {
    EXPECT_EQ(masked.reports[f].status, FrameStatus::ok);
    EXPECT_EQ(masked.reports[f].reasons, dead_electrode);
  }
  EXPECT_EQ(masked.reports[4].status, FrameStatus::suspect);
  EXPECT_LE((masked.images.row(0) - good.images.row(0)).norm(), 1e-13 * good.images.row(0).norm());

  // The dead channels' values do not matter, and a mask that is given does the same.
  const auto listed = validated({{"channel_mask", {2, 7}}});
  for (const Eigen::Index f : {1, 2, 3}) {
    const Reconstruction one = reconstruct(*solver, changes.row(f));
    EXPECT_EQ(one.images.row(0), masked.images.row(f));
    // It may keep another number of values; it groups the scenes by other channels.
    if (GetParam()["type"] == "tsvd" || is_mixture()) continue;
    EXPECT_LE(relative_difference(reconstruct(*listed, changes.row(f)).images, one.images),
              linear() ? 1e-8 : 1e-2);
  }
  const Reconstruction zeros = reconstruct(*listed, changes.row(1));
  Frames without_numbers = changes.row(1);
  for_dead_channels(without_numbers.row(0), 1u << 2 | 1u << 7, [](double& change, double) {
    change = std::numeric_limits<double>::quiet_NaN();
  });
  const Reconstruction of_nan = reconstruct(*listed, without_numbers);
  EXPECT_EQ(of_nan.images, zeros.images);
  EXPECT_EQ(of_nan.reports[0].status, zeros.reports[0].status);
}

TEST_P(MaskedFrames, MayHaveNoLiveElectrode) {
  const auto solver = validated({{"channel_mask", "detect"}});
  const Frames dead = -ForwardModel(Sensor{}, 24).reference_voltages().transpose();
  const Reconstruction out = reconstruct(*solver, dead);
  EXPECT_EQ(out.reports[0].status, FrameStatus::suspect);
  EXPECT_EQ(out.reports[0].reasons, dead_electrode);
  EXPECT_TRUE((out.images.array() == 0).all());
}

TEST_P(MaskedFrames, RefusesAMaskThatIsNone) {
  const auto message = [](const json& mask) {
    json spec = GetParam();
    spec["channel_mask"] = mask;
    return message_of<InputError>([&] { make_solver(spec)->check(Sensor{}); });
  };
  EXPECT_EQ(message("detect"), "");
  EXPECT_EQ(message("all").find("spec.json: /channel_mask: must be"), 0u);
  EXPECT_EQ(message(3).find("spec.json: /channel_mask: must be"), 0u);
  EXPECT_EQ(message({3, 16}).find("spec.json: /channel_mask: names an electrode"), 0u);
  EXPECT_EQ(
      message({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}).find("spec.json: /channel_mask: must leave"),
      0u);
  Sensor one_drive;
  one_drive.drive = {PairPattern::Kind::listed, 0, {{0, 1}}};
  json spec = GetParam();
  spec["channel_mask"] = {1};
  EXPECT_EQ(message_of<InputError>([&] {
              make_solver(spec)->check(one_drive);
            }).find("spec.json: /channel_mask: leaves no channel"),
            0u);
}

const json back_projection = {{"type", "back-projection"}};
const auto classical = ::testing::Values(
    json{{"type", "one-step-gn"}, {"prior", "tikhonov"}, {"lambda", 0.02}},
    json{{"type", "one-step-gn"}, {"prior", "noser"}, {"lambda", 0.1}},
    json{{"type", "one-step-gn"}, {"prior", "laplace"}, {"lambda", 0.02}},
    json{{"type", "tsvd"}, {"rank", 45}}, json{{"type", "tsvd"}, {"threshold", 0.02}},
    json{{"type", "lmmse"}, {"ridge", 1e-5}},
    json{{"type", "lmmse"}, {"components", 4}, {"ridge", 1e-5}},
    json{{"type", "pdipm"}, {"alpha", 1e-5}},
    json{{"type", "gauss-newton"}, {"lambda", 0.3}, {"tolerance", 0.1}},
    json{{"type", "gauss-newton"}, {"prior", "laplace"}, {"lambda", 0.1}, {"tolerance", 0.1}},
    json{{"type", "gauss-newton"},
         {"prior", "total-variation"},
         {"lambda", 1e-4},
         {"tolerance", 0.1}},
    json{{"type", "gauss-newton"}, {"prior", "training"}, {"lambda", 1e-3}, {"tolerance", 0.1}},
    json{{"type", "contacts"}, {"prior_weight", 1}, {"noise", 1e-4}});

std::string name_of_spec(const ::testing::TestParamInfo<json>& instance) {
  std::string name;
  for (const char* key : {"type", "prior", "threshold", "components", "input"}) {
    if (instance.param.contains(key)) {
      name += instance.param[key].is_string() ? instance.param[key].template get<std::string>()
                                              : std::string(key);
    }
  }
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Classical, SolverContract, classical, name_of_spec);
INSTANTIATE_TEST_SUITE_P(Classical, ClassicalContract, classical, name_of_spec);
INSTANTIATE_TEST_SUITE_P(Classical, FramesNotToBeTrusted, classical, name_of_spec);
INSTANTIATE_TEST_SUITE_P(Classical, MaskedFrames, classical, name_of_spec);
const auto regressed =
    ::testing::Values(json{{"type", "kernel-ridge"},
                           {"width", 1},
                           {"lambda", 1e-3},
                           {"norm_weight", 0.1},
                           {"strength", {{"width", 1}, {"lambda", 1e-3}, {"norm_weight", 0.5}}}},
                      json{{"type", "kernel-ridge"}, {"input", "raw"}, {"most_frames", 100}});

INSTANTIATE_TEST_SUITE_P(Kernel, SolverContract, regressed, name_of_spec);
INSTANTIATE_TEST_SUITE_P(Kernel, FramesNotToBeTrusted, regressed, name_of_spec);
INSTANTIATE_TEST_SUITE_P(Plugin, SolverContract, ::testing::Values(back_projection), name_of_spec);
const json command = {{"type", "command"},
                      {"command", {"python3", ERTBENCH_TEST_DATA "/programs/child.py", "plain"}}};
INSTANTIATE_TEST_SUITE_P(Program, SolverContract, ::testing::Values(command), name_of_spec);
INSTANTIATE_TEST_SUITE_P(Plugin, FramesNotToBeTrusted, ::testing::Values(back_projection),
                         name_of_spec);

}  // namespace
}  // namespace ertbench
