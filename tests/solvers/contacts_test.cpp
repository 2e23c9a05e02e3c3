// The solver whose unknowns are the contacts, held against scenes that the border model made.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "forward/border/border_model.h"
#include "forward/data/sheet_model.h"
#include "forward/sheet/rasterise.h"
#include "solvers/channel_mask.h"
#include "solvers/contacts/contact_fit.h"
#include "solvers/contacts/contact_image.h"
#include "solvers/contacts/contact_prior.h"
#include "tests/solvers/contact_testing.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;

std::unique_ptr<Solver> solver_for(double snr_db, const json& more = json::object()) {
  json spec = {{"type", "contacts"}, {"prior_weight", 1}, {"noise", noise_at(snr_db)}};
  spec.update(more);
  return fitted(spec);
}

std::vector<FoundContact> found_in(const Solver& solver, const Frames& frame) {
  std::vector<std::vector<FoundContact>> out(1);
  solver.contact_finder()->find_contacts(frame, out);
  return out.front();
}

TEST(Contacts, OfALowNoiseFrameAreWhatTheyAre) {
  const auto solver = solver_for(90);
  const std::vector<FoundContact> one =
      found_in(*solver, frame_of({{ellipse(0.3, -0.2, 0.25, 0.15, 0.6, 0.5)}}, 90, 1));
  ASSERT_EQ(one.size(), 1U);
  EXPECT_LT((one[0].place - Eigen::Vector2d(0.3, -0.2)).norm(), 1e-3);
  EXPECT_NEAR(one[0].area, std::numbers::pi * 0.25 * 0.15, 0.005);
  EXPECT_NEAR(one[0].peak, 0.5 * Sensor{}.background, 0.002);

  const std::vector<FoundContact> two =
      found_in(*solver, frame_of({{disc(-0.5, 0.4, 0.2, 0.6), disc(0.4, -0.3, 0.25, 2)}}, 90, 1));
  ASSERT_EQ(two.size(), 2U);  // a better conductor, and the stronger of the two
  EXPECT_LT((two[0].place - Eigen::Vector2d(0.4, -0.3)).norm(), 1e-3);
  EXPECT_LT((two[1].place - Eigen::Vector2d(-0.5, 0.4)).norm(), 1e-3);
}

/// Standard deviations mean what they say: chi^2 of the places over many noises.
TEST(Contacts, StandardDeviationsAreThoseOfTheErrors) {
  const auto solver = solver_for(60, {{"shape", "disc"}, {"model_error", 0}});
  const Frames clean = frame_of({{disc(0.2, 0.35, 0.2, 0.6)}}, 60, 0);
  constexpr int count = 120;
  double square = 0;
  for (int f = 0; f < count; ++f) {
    RandomStream random(11, key_of("deviations"), static_cast<std::uint64_t>(f), Purpose::noise);
    Frames noisy = clean;
    for (Index c = 0; c < noisy.cols(); ++c) noisy(0, c) += noise_at(60) * random.normal();
    const std::vector<FoundContact> found = found_in(*solver, noisy);
    ASSERT_EQ(found.size(), 1U);
    square += (found[0].place - Eigen::Vector2d(0.2, 0.35))
                  .cwiseQuotient(found[0].place_deviation)
                  .squaredNorm();
  }
  // Chi^2 of 2 * 120 numbers: 1 +- 4 sqrt(2 / 240).
  EXPECT_NEAR(square / (2 * count), 1, 0.37);
}

TEST(Contacts, NoiseAloneHasNone) {
  const auto solver = solver_for(50);
  int contacts = 0;
  for (std::uint64_t f = 1; f <= 50; ++f) {
    contacts += static_cast<int>(found_in(*solver, frame_of({}, 50, f)).size());
  }
  EXPECT_LE(contacts, 2);
}

/// Of two strong discs far apart one may explain a frame worse than none: both are found all the
/// same.
TEST(Contacts, OfTwoFarApartAreNeverNone) {
  const auto solver = solver_for(60);
  int both = 0;
  for (std::uint64_t f = 1; f <= 60; ++f) {
    RandomStream random(21, key_of("far apart"), f, Purpose::scene);
    const auto side = [&] { return random.uniform(0.5, 0.8); };
    const Scene scene{{disc(-side(), random.uniform(-0.7, 0.7), 0.18, 0.5),
                       disc(side(), random.uniform(-0.7, 0.7), 0.16, 0.5)}};
    const std::size_t found = found_in(*solver, frame_of(scene, 60, f)).size();
    EXPECT_GE(found, 1U) << f;
    both += found == 2;
  }
  EXPECT_GE(both, 48);
}

TEST(Contacts, AreFoundWithoutTheDeadElectrodes) {
  const Scene scene{{disc(0.3, -0.2, 0.25, 0.5)}};
  const Frames clean = frame_of(scene, 70, 1);
  const std::vector<ElectrodeSet> electrodes = electrodes_of_pairs(Sensor{});
  const auto pairs = reciprocal_pairs(Sensor{});

  // Some that read zero are found out and told.
  Frames zero = clean;
  const Eigen::VectorXd reference = uniform_reference(Sensor{});
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if ((electrodes[p] & (1U << 4 | 1U << 5)) == 0) continue;
    for (const int channel : pairs[p]) zero(0, channel) = -reference[channel];
  }
  const auto detecting = solver_for(70, {{"channel_mask", "detect"}});
  const std::vector<FoundContact> told = found_in(*detecting, zero);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_LT((told[0].place - Eigen::Vector2d(0.3, -0.2)).norm(), 0.01);

  // What a listed one reads may be anything.
  Frames nan = clean;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if ((electrodes[p] & 1U << 4) == 0) continue;
    for (const int channel : pairs[p]) nan(0, channel) = std::numeric_limits<double>::quiet_NaN();
  }
  const auto masking = solver_for(70, {{"channel_mask", {4}}});
  const std::vector<FoundContact> found = found_in(*masking, nan);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT((found[0].place - Eigen::Vector2d(0.3, -0.2)).norm(), 0.01);
}

/// What the channels of a dead electrode read has no effect, also where the nuisances' covariance
/// joins all pairs, and the likelihood is that of the frame without these pairs.
TEST(Contacts, AreFoundWithoutTheDeadElectrodesOnAnotherLevel) {
  const Scene scene{{disc(0.3, -0.2, 0.25, 0.5), disc(-0.4, 0.3, 0.2, 0.6)}};
  const VectorXd reference = BorderModel{Sensor{}}.reference_voltages();
  const Frames frame =
      (frame_of(scene, 70, 1) + reference.transpose()) / 1.1 - Frames(reference.transpose());
  const auto solver =
      solver_for(70, {{"channel_mask", {4}},
                      {"nuisances", {{"level", 0.2}, {"gradient", 0.1}, {"electrodes", 0.01}}}});
  const std::vector<ElectrodeSet> electrodes = electrodes_of_pairs(Sensor{});
  const auto pairs = reciprocal_pairs(Sensor{});
  std::vector<Images> images;
  for (const double reading : {0.0, 1.0}) {
    Frames dead = frame;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if ((electrodes[p] & 1U << 4) == 0) continue;
      for (const int channel : pairs[p]) dead(0, channel) = reading;
    }
    const std::vector<FoundContact> found = found_in(*solver, dead);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_LT((found[0].place - Eigen::Vector2d(0.3, -0.2)).norm(), 0.03);
    EXPECT_LT((found[1].place - Eigen::Vector2d(-0.4, 0.3)).norm(), 0.03);
    const Reconstruction out = reconstruct(*solver, dead);
    EXPECT_NEAR(out.reports[0].level, 0.1, 0.01);
    images.push_back(out.images);
  }
  EXPECT_LT((images[1] - images[0]).norm(), 1e-3 * images[0].norm());
}

/// One wrong channel differs from its reciprocal one, and is no contact beside those there are.
TEST(Contacts, OfStudentsNoiseAreNotOneWrongChannel) {
  const Scene scene{{disc(0.3, -0.2, 0.25, 0.5)}};
  const Frames sound = frame_of(scene, 60, 1);
  const auto normal = solver_for(60);
  const auto student = solver_for(60, {{"likelihood", "student"}});
  int normal_more = 0;
  for (const int channel : {5, 40, 77, 111, 150, 203}) {
    Frames wrong = sound;
    wrong(0, channel) += 100 * noise_at(60);
    const std::vector<FoundContact> found = found_in(*student, wrong);
    ASSERT_EQ(found.size(), 1U) << channel;
    EXPECT_LT((found[0].place - Eigen::Vector2d(0.3, -0.2)).norm(), 0.02) << channel;
    const std::vector<FoundContact> taken_in = found_in(*normal, wrong);
    normal_more +=
        taken_in.size() != 1 || (taken_in[0].place - Eigen::Vector2d(0.3, -0.2)).norm() > 0.02;
  }
  EXPECT_GE(normal_more, 3);
}

/// Where one contact has to stand for several, the image shows the one that is listed, though none
/// would have more evidence.
TEST(Contacts, ThatAreListedAreInTheImage) {
  const auto solver = solver_for(60, {{"most_contacts", 1}});
  int listed = 0;
  for (std::uint64_t f = 1; f <= 100; ++f) {
    RandomStream random(22, key_of("one for two"), f, Purpose::scene);
    Scene scene;
    for (std::uint64_t k = 0; k < 2 + f % 4; ++k) {
      const bool falls = random.uniform() < 0.5;
      const double ratio = falls ? random.uniform(0.1, 0.9) : random.uniform(1.2, 8);
      const double radius = random.uniform(0.05, 0.19);
      const double y = random.uniform(-0.8, 0.8);
      const double x = random.uniform(-0.8, 0.8);
      scene.contacts.push_back(disc(x, y, radius, ratio));
    }
    const Frames frame = frame_of(scene, 60, f);
    const std::vector<FoundContact> found = found_in(*solver, frame);
    if (found.empty()) continue;
    ++listed;
    // A pixel's area is 1/144 of a square unit.
    const double shown = reconstruct(*solver, frame).images.cwiseAbs().sum() / 144;
    EXPECT_GT(shown, 0.3 * found[0].strength) << f;
  }
  EXPECT_GT(listed, 90);
}

TEST(Contacts, ExplainAFrameToItsNoiseAndNotWhatIsNoContact) {
  const auto solver = solver_for(50);
  const auto reasons = [&](const Frames& frame) {
    return reconstruct(*solver, frame).reports[0].reasons;
  };
  const Frames good = frame_of({{disc(0.3, 0.3, 0.25, 0.5), disc(-0.4, -0.2, 0.2, 0.3)}}, 50, 3);
  EXPECT_EQ(reasons(good) & unexplained, 0);
  // A stale reference: all voltages 3 % larger. And the same with that as a further unknown.
  const VectorXd reference = BorderModel{Sensor{}}.reference_voltages();
  const Frames stale = good + 0.03 * reference.transpose();
  EXPECT_EQ(reasons(stale) & unexplained, unexplained);
  const auto tolerant = solver_for(50, {{"nuisances", {{"gain", 0.05}}}});
  const Reconstruction out = reconstruct(*tolerant, stale);
  EXPECT_EQ(out.reports[0].reasons & unexplained, 0);
  const Images as_good = reconstruct(*tolerant, good).images;
  EXPECT_LT((out.images - as_good).norm(), 0.1 * as_good.norm());
}

/// A sheet whose conductivity is another all over has the voltages of the usual one over its level,
/// whatever is on it.
TEST(Contacts, TellTheLevelOfTheSheet) {
  const auto solver = solver_for(60, {{"nuisances", {{"level", 0.3}}}});
  const Scene scene{{disc(0.3, 0.3, 0.25, 0.5), disc(-0.4, -0.2, 0.2, 2)}};
  const Frames usual = frame_of(scene, 60, 3);
  const VectorXd reference = BorderModel{Sensor{}}.reference_voltages();
  const Images as_usual = reconstruct(*solver, usual).images;
  for (const double level : {-0.2, 0.0, 0.02, 0.4}) {
    const Frames frame =
        (usual + reference.transpose()) / (1 + level) - Frames(reference.transpose());
    const Reconstruction out = reconstruct(*solver, frame);
    EXPECT_NEAR(out.reports[0].level, level, 2e-3 * (1 + level));
    EXPECT_EQ(out.reports[0].reasons & unexplained, 0) << level;
    EXPECT_LT((out.images - as_usual).norm(), 0.05 * as_usual.norm()) << level;
    EXPECT_EQ(found_in(*solver, frame).size(), 2U) << level;
    // The same factor, where only a gain is expected, is no level.
    const auto gain = solver_for(60, {{"nuisances", {{"gain", 0.3}}}});
    EXPECT_EQ(reconstruct(*gain, frame).reports[0].level, 0);
  }
}

// A small insulator and a larger one that insulates less are nearly the same to the voltages.
TEST(Contacts, AKnownRatioTellsTheSize) {
  const double radius = 0.12;
  const auto knows = solver_for(
      50, {{"shape", "disc"}, {"most_contacts", 1}, {"conductivity_ratio", {0.04, 0.06}}});
  const auto guesses = solver_for(50, {{"shape", "disc"}, {"most_contacts", 1}});
  double known = 0;
  double guessed = 0;
  constexpr int frames = 20;
  for (int f = 0; f < frames; ++f) {
    const Scene scene{{disc(0.25, -0.15, radius, 0.05)}};
    const Frames frame = frame_of(scene, 50, static_cast<std::uint64_t>(f) + 1);
    const auto radius_error = [&](const Solver& solver) {
      const std::vector<FoundContact> found = found_in(solver, frame);
      return std::sqrt(found.at(0).area / std::numbers::pi) / radius - 1;
    };
    known += std::pow(radius_error(*knows), 2) / frames;
    guessed += std::pow(radius_error(*guesses), 2) / frames;
  }
  // The strength is told to a few per cent by the voltages, the size half as well.
  EXPECT_LT(std::sqrt(known), 0.05);
  EXPECT_GT(std::sqrt(guessed), 2 * std::sqrt(known));
  for (const json& wrong : {json{0.5, 0.2}, json{0.5, 2}, json{1, 2}}) {
    EXPECT_THROW(solver_for(50, {{"conductivity_ratio", wrong}}), InputError) << wrong;
  }
}

TEST(Contacts, ImagesHaveTheScenesConductivity) {
  const Scene scene{{disc(0.1, -0.3, 0.25, 0.5)}};
  const Sensor sensor;
  VectorXd ratio(sensor.pixels());
  rasterise(scene, sensor.image(), Rasterisation::area, ratio);
  const Images truth = sensor.background * (ratio.array() - 1).matrix().transpose();
  for (const char* image : {"mean", "most-likely"}) {
    const auto solver = solver_for(80, {{"image", image}});
    const Images found = reconstruct(*solver, frame_of(scene, 80, 1)).images;
    EXPECT_LT((found - truth).norm(), 0.06 * truth.norm()) << image;
  }
}

/// Gain and gradient of the whitening against the covariance it stands for.
TEST(Nuisances, WhitenTheirOwnCovariance) {
  const Sensor sensor;
  Nuisances nuisances;
  nuisances.gain = 0.02;
  nuisances.electrodes = 0.01;
  const double noise = 1e-4;
  const MatrixXd w = whitening_of(sensor, noise, nuisances);
  const BorderModel model(sensor);
  const auto pairs = reciprocal_pairs(sensor);
  VectorXd gain(static_cast<Index>(pairs.size()));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    gain[static_cast<Index>(p)] = model.reference_voltages()[pairs[p][0]];
  }
  // Along what is unknown a deviation counts as one, across it a pair's noise does.
  EXPECT_LE((w * gain * nuisances.gain).norm(), 1);
  EXPECT_GT((w * gain * nuisances.gain).norm(), 0.5);
  const MatrixXd none = whitening_of(sensor, noise, {});
  EXPECT_NEAR(none(0, 0), std::numbers::sqrt2 / noise, 1e-6 * none(0, 0));
}

TEST(Contacts, AreFollowedFromTheLastFrame) {
  const Sensor sensor;
  const ContactFit fit(sensor, ContactPrior{}, whitening_of(sensor, noise_at(60), {}),
                       ContactFit::Options{});
  const auto pairs = reciprocal_pairs(sensor);
  ContactFit::Workspace workspace;
  ContactFit::Found found;
  for (int step = 0; step < 8; ++step) {
    const double x = -0.4 + 0.05 * step;
    const Frames frame =
        frame_of({{disc(x, 0.2, 0.2, 0.5)}}, 60, static_cast<std::uint64_t>(step) + 1);
    VectorXd means(static_cast<Index>(pairs.size()));
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      means[static_cast<Index>(p)] = (frame(0, pairs[p][0]) + frame(0, pairs[p][1])) / 2;
    }
    fit.follow(means, found.best, workspace, found);
    ASSERT_EQ(found.best.contacts.size(), 1U) << step;
    EXPECT_NEAR(found.best.contacts[0].centre.x(), x, 0.02) << step;
    if (step > 0) {
      EXPECT_LE(found.iterations, 8) << step;
    }
  }
}

/// A contact that lifts off is gone from the next frame on, one that comes down is there.
TEST(Contacts, ThatAreFollowedComeAndGo) {
  const auto solver = solver_for(60);
  const auto stream = solver->open_stream();
  const Contact first = disc(-0.4, 0.2, 0.2, 0.5);
  const Contact second = disc(0.5, -0.3, 0.25, 0.4);
  const std::vector<Scene> scenes = {{{first}}, {{first, second}}, {{first, second}}, {{second}},
                                     {},        {{second}}};
  for (std::size_t f = 0; f < scenes.size(); ++f) {
    Images image(1, Sensor{}.pixels());
    std::vector<FrameReport> report(1);
    stream->reconstruct(frame_of(scenes[f], 60, f + 1), image, report);
    EXPECT_EQ(stream->contacts()->size(), scenes[f].contacts.size()) << f;
    EXPECT_EQ(report[0].reasons & unexplained, 0) << f;
  }
}

/// One that presses in so slowly that no frame is much worse explained than the one before.
TEST(Contacts, ThatPressInSlowlyAreFound) {
  const auto solver = solver_for(50);
  const auto stream = solver->open_stream();
  const Contact resting = disc(-0.4, 0.2, 0.2, 0.5);
  constexpr int frames = 200;
  for (int f = 0; f < frames; ++f) {
    const double pressed = static_cast<double>(f) / (frames - 1);
    const Scene scene{{resting, disc(0.5, -0.3, 0.2, 1 - 0.5 * pressed)}};
    Images image(1, Sensor{}.pixels());
    std::vector<FrameReport> report(1);
    stream->reconstruct(frame_of(scene, 50, 100 + static_cast<std::uint64_t>(f)), image, report);
  }
  EXPECT_EQ(stream->contacts()->size(), 2U);
}

/// Electrodes that are left out leave as many numbers less to be explained by noise.
TEST(Contacts, OfFewerPairsAreLookedForAsThoroughly) {
  const auto solver = solver_for(50, {{"channel_mask", {2, 7, 12}}});
  const Frames frame = frame_of({{disc(0.3, 0.3, 0.25, 0.5), disc(-0.4, -0.2, 0.2, 0.3)}}, 50, 3);
  const VectorXd reference = BorderModel{Sensor{}}.reference_voltages();
  const auto reasons = [&](const Frames& one) {
    return reconstruct(*solver, one).reports[0].reasons;
  };
  EXPECT_EQ(reasons(frame) & unexplained, 0);
  EXPECT_EQ(reasons(frame + 0.03 * reference.transpose()) & unexplained, unexplained);
}

}  // namespace
}  // namespace ertbench
