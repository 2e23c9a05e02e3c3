// The check of reference voltages: eight mistakes of those who connect instrument and program, none
// of which may be imaged, and sound references, none of which may be refused.

#include "frames/reference_check.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/json.h"
#include "frames/channels.h"
#include "tests/forward/disc_sheet.h"
#include "tests/frames/frames_testing.h"

namespace ertbench {
namespace {

using testing::reference_with_gains;
using State = ReferenceVerdict::State;

std::string causes_of(const ReferenceVerdict& verdict) {
  std::string text;
  for (const std::string& cause : verdict.causes) text += cause + "\n";
  return text;
}

std::string unseen_of(const ReferenceVerdict& verdict) {
  std::string text;
  for (const std::string& what : verdict.unseen) text += what + "\n";
  return text;
}

Eigen::VectorXd mended(const ReferenceVerdict& verdict, const Eigen::VectorXd& given) {
  return given(verdict.from).cwiseProduct(verdict.factor);
}

/// The values of `sensor`'s channels as an instrument lists them whose electrode i is the sensor's
/// `at(i)` (all mod L), and whose pair k is its electrodes k and k+1. Written anew, by electrodes.
template <typename At>
Eigen::VectorXd listed_by(const Sensor& sensor, const Eigen::VectorXd& truth, At&& at) {
  const int count = sensor.electrode_count;
  const std::vector<Channel> channels = channels_of(sensor);
  const auto wrap = [count](int e) { return ((e % count) + count) % count; };
  // The sensor's pair that joins the same electrodes, and the sign of its difference.
  const auto pair_of = [&](int k) {
    const int first = wrap(at(k));
    const int second = wrap(at(k + 1));
    return wrap(first + 1) == second ? std::pair(first, 1.0) : std::pair(second, -1.0);
  };
  Eigen::VectorXd out(truth.size());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto [drive, drive_sign] = pair_of(channels[c].drive);
    const auto [measurement, sign] = pair_of(channels[c].measurement);
    for (std::size_t t = 0; t < channels.size(); ++t) {
      if (channels[t].drive == drive && channels[t].measurement == measurement) {
        out[static_cast<Eigen::Index>(c)] = drive_sign * sign * truth[static_cast<Eigen::Index>(t)];
      }
    }
  }
  return out;
}

Eigen::VectorXd listed_in_order(const Sensor& sensor, const Eigen::VectorXd& truth,
                                const std::string& order) {
  Eigen::VectorXd out(truth.size());
  const std::vector<int> places = places_in_order(sensor, order);
  for (std::size_t c = 0; c < places.size(); ++c) {
    out[places[c]] = truth[static_cast<Eigen::Index>(c)];
  }
  return out;
}

struct Mistake {
  const char* name;
  Eigen::VectorXd given;
  const char* cause;  ///< in the verdict
  /// Of the mended reference over the truth: what a wrong current leaves is its own level.
  double level = 1;
};

TEST(ReferenceCheck, NamesAndMendsTheMistakes) {
  const Sensor sensor;
  std::mt19937 random(17);
  const Eigen::VectorXd truth = reference_with_gains(sensor, random);
  const Mistake mistakes[] = {
      {"millivolts for volts", 1e3 * truth, "millivolts for volts"},
      {"a current of 10 mA for 25", 0.4 * truth, "\"drive_current\""},
      {"the sign", -truth, "the sign is turned round"},
      {"electrodes counted from the next", listed_by(sensor, truth, [](int e) { return e + 1; }),
       "its electrode 0 is the sensor's electrode 1"},
      {"electrodes counted from the third before",
       listed_by(sensor, truth, [](int e) { return e - 3; }),
       "its electrode 0 is the sensor's electrode 1"},
      {"measurements from the drive on", listed_in_order(sensor, truth, "rotating"),
       "order rotating; --channels rotating"},
      {"declared as such and not so", truth(places_in_order(sensor, "rotating")),
       "order drive-major"},
      {"backwards, in millivolts, and the sign",
       -1e3 * listed_by(sensor, truth, [](int e) { return 2 - e; }), "millivolts for volts"},
  };
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.name);
    const ReferenceVerdict verdict = check_reference(sensor, mistake.given, {});
    EXPECT_EQ(verdict.state, State::mendable) << verdict.text();
    EXPECT_NE(causes_of(verdict).find(mistake.cause), std::string::npos) << verdict.text();
    // Two references of other gains of one per cent, at symmetric places, differ by no more.
    EXPECT_LT((mended(verdict, mistake.given) - truth).norm(), 0.03 * truth.norm());
  }
  // The eighth: nothing that is known.
  std::vector<int> shuffled(static_cast<std::size_t>(truth.size()));
  std::iota(shuffled.begin(), shuffled.end(), 0);
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  const ReferenceVerdict hopeless = check_reference(sensor, truth(shuffled), {});
  EXPECT_EQ(hopeless.state, State::beyond_help) << hopeless.text();
}

/// On the square the middle lines between electrodes are axes of symmetry, so that a count the
/// other way round is a shift as well; where the electrodes lie off them, it is nothing else.
TEST(ReferenceCheck, TellsACountTheOtherWayRoundWhereItCanBeSeen) {
  const Sensor symmetric;
  std::mt19937 random(18);
  const auto backwards = [](int e) { return -e; };
  const Eigen::VectorXd truth = reference_with_gains(symmetric, random);
  const Eigen::VectorXd given = listed_by(symmetric, truth, backwards);
  const ReferenceVerdict both = check_reference(symmetric, given, {});
  EXPECT_EQ(both.state, State::mendable);
  EXPECT_NE(causes_of(both).find("its electrode 0 is the sensor's electrode 3"), std::string::npos);
  EXPECT_NE(unseen_of(both).find("the other way round (from the sensor's electrode 0)"),
            std::string::npos)
      << both.text();
  EXPECT_LT((mended(both, given) - truth).norm(), 0.03 * truth.norm());

  Sensor skew;
  skew.electrode_offset = 0.1;
  const Eigen::VectorXd of_skew = reference_with_gains(skew, random);
  const Eigen::VectorXd listed = listed_by(skew, of_skew, backwards);
  const ReferenceVerdict one = check_reference(skew, listed, {});
  EXPECT_EQ(one.state, State::mendable);
  EXPECT_NE(causes_of(one).find("counts its electrodes the other way round"), std::string::npos)
      << one.text();
  EXPECT_LT((mended(one, listed) - of_skew).norm(), 0.03 * of_skew.norm());
}

/// By reciprocity a list by measurements is a list by drives: nothing to see, and no harm done.
TEST(ReferenceCheck, SaysThatDriveAndMeasurementCannotBeToldApart) {
  const Sensor sensor;
  const Eigen::VectorXd truth = BorderModel(sensor).reference_voltages();
  const Eigen::VectorXd exchanged = listed_in_order(sensor, truth, "measure-major");
  EXPECT_LT((exchanged - truth).norm(), 1e-10 * truth.norm());
  const ReferenceVerdict verdict = check_reference(sensor, exchanged, {});
  EXPECT_EQ(verdict.state, State::sound);
  EXPECT_NE(unseen_of(verdict).find("drive and measurement exchanged"), std::string::npos);
}

TEST(ReferenceCheck, ClaimsNothingThatTheSymmetryHides) {
  const Sensor square;
  const Eigen::VectorXd truth = BorderModel(square).reference_voltages();
  const auto turned = listed_by(square, truth, [](int e) { return e + 4; });
  const ReferenceVerdict on_square = check_reference(square, turned, {});
  EXPECT_EQ(on_square.state, State::sound);
  EXPECT_NE(unseen_of(on_square).find("a turn by 4, 8, 12 electrodes"), std::string::npos)
      << on_square.text();
  EXPECT_NE(unseen_of(on_square).find("the other way round"), std::string::npos);

  const Sensor disc = testing::disc_sensor();
  const ReferenceVerdict on_disc =
      check_reference(disc, BorderModel(disc).reference_voltages(), {});
  EXPECT_EQ(on_disc.state, State::sound);
  EXPECT_NE(unseen_of(on_disc).find("a turn by any number"), std::string::npos) << on_disc.text();
}

TEST(ReferenceCheck, RaisesNoFalseAlarm) {
  std::mt19937 random(2);
  const Sensor square;
  const Sensor disc = testing::disc_sensor();
  const Eigen::VectorXd references[] = {BorderModel(square).reference_voltages(),
                                        BorderModel(disc).reference_voltages()};
  std::normal_distribution<double> gain(1, 0.01);
  int alarms = 0;
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXd reference = references[i % 2];
    for (double& v : reference) v *= gain(random);
    alarms += check_reference(i % 2 ? disc : square, reference, {}).state != State::sound;
  }
  EXPECT_EQ(alarms, 0);
}

/// On a disc the voltages depend on the distance between drive and measurement alone, so that
/// measurements that run back from the drive look like those that run on; a contact does not.
TEST(ReferenceCheck, FramesWithAContactShowWhatTheReferenceHides) {
  const Sensor sensor = testing::disc_sensor();
  const Eigen::VectorXd truth = BorderModel(sensor).reference_voltages();
  const Eigen::VectorXd given = listed_in_order(sensor, truth, "rotating-back");
  EXPECT_LT((given - listed_in_order(sensor, truth, "rotating")).norm(), 1e-10 * truth.norm());

  const RowMajorMatrix changes = testing::changes_by_discs(sensor, {{0.4, 0.3}, {-0.5, 0.1}});
  Frames listed(changes.rows(), changes.cols());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    listed.row(f) =
        listed_in_order(sensor, changes.row(f).transpose(), "rotating-back").transpose();
  }
  const ReferenceVerdict blind = check_reference(sensor, given, {});
  EXPECT_EQ(blind.state, State::mendable);
  EXPECT_NE(unseen_of(blind).find("another order"), std::string::npos) << blind.text();

  const ReferenceVerdict verdict = check_reference(sensor, given, listed);
  EXPECT_EQ(verdict.state, State::mendable);
  EXPECT_NE(causes_of(verdict).find("order rotating-back"), std::string::npos) << verdict.text();
  EXPECT_GT(verdict.mended_explained, 0.9);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const Eigen::VectorXd frame = listed.row(f).transpose();
    EXPECT_LT((mended(verdict, frame).transpose() - changes.row(f)).norm(),
              1e-10 * changes.row(f).norm());
  }
}

TEST(ReferenceCheck, DeadElectrodesAreNamedAndNoReasonToStop) {
  const Sensor sensor;
  Eigen::VectorXd reference = BorderModel(sensor).reference_voltages();
  const std::vector<Channel> channels = channels_of(sensor);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    for (const int pair : {channels[c].drive, channels[c].measurement}) {
      if (pair == 6 || pair == 5) reference[static_cast<Eigen::Index>(c)] = 0;
    }
  }
  const ReferenceVerdict verdict = check_reference(sensor, reference, {});
  EXPECT_EQ(verdict.state, State::sound) << verdict.text();
  ASSERT_EQ(verdict.notes.size(), 1u) << verdict.text();
  EXPECT_EQ(verdict.notes[0], "electrode 6 reads zero");
}

TEST(ReferenceCheck, DeadChannelsAndUnexplainedChangesAreNoted) {
  const Sensor sensor;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1e-6);
  Eigen::VectorXd reference = reference_with_gains(sensor, random);
  const Eigen::RowVectorXd disc = testing::changes_by_discs(sensor, {{0.4, 0.2}}).row(0);
  Frames changes(20, sensor.channels());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    changes.row(f) = f < 10 ? 0 * disc : disc;
    for (double& v : changes.row(f)) v += noise(random);
  }
  EXPECT_TRUE(check_reference(sensor, reference, changes).notes.empty());

  Frames dead = changes;
  dead.col(40).setZero();
  const std::string text = check_reference(sensor, reference, dead).text();
  EXPECT_NE(text.find("note: channel 40 (drive 3, measurement "), std::string::npos) << text;
  reference[40] = 0;
  EXPECT_NE(check_reference(sensor, reference, {}).text().find("is dead"), std::string::npos);

  // The same changes in channels of no known order.
  Frames shuffled = changes;
  std::vector<int> order(static_cast<std::size_t>(changes.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), random);
  shuffled = changes(Eigen::all, order);
  EXPECT_NE(check_reference(sensor, reference, shuffled).text().find("contacts explain only"),
            std::string::npos);
}

TEST(TwinPlaces, OppositeDriveAndMeasurementShowEachContactTwice) {
  const auto sensor_with = [](const char* drive, const char* measurement) {
    const nlohmann::json json = {{"shape", "disc"},
                                 {"diameter_mm", 300},
                                 {"electrode_count", 16},
                                 {"drive", drive},
                                 {"measurement", measurement}};
    return sensor_from_json(JsonObject(json, "test", ""));
  };
  const Sensor opposite = sensor_with("opposite", "opposite");
  const auto twins = twin_symmetries(opposite);
  ASSERT_EQ(twins.size(), 1u);
  EXPECT_EQ(twins[0], -Eigen::Matrix2d::Identity());
  // By the model with whole contacts, whose borders are resolved to half a per cent.
  const RowMajorMatrix two = testing::changes_by_discs(opposite, {{0.4, 0.2}, {-0.4, -0.2}});
  EXPECT_LT((two.row(0) - two.row(1)).norm(), 0.01 * two.row(0).norm());
  const ReferenceVerdict verdict =
      check_reference(opposite, BorderModel(opposite).reference_voltages(), {});
  EXPECT_NE(verdict.text().find("(x, y) and (-x, -y) from the sheet's centre give the same"),
            std::string::npos)
      << verdict.text();
  for (const Sensor& other : {Sensor{}, testing::disc_sensor(), sensor_with("opposite", "adjacent"),
                              sensor_with("adjacent", "adjacent")}) {
    EXPECT_TRUE(twin_symmetries(other).empty());
  }
}

TEST(ContactSpan, HoldsContactsAndHardlyAnythingElse) {
  const Sensor sensor;
  const ContactSpan span(sensor);
  EXPECT_LT(span.directions(), sensor.channels() / 3);
  EXPECT_GT(span.share(testing::changes_by_discs(sensor, {{0.3, -0.2}, {-0.5, 0.4}})), 0.95);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Frames noise(50, sensor.channels());
  for (double& v : noise.reshaped()) v = normal(random);
  // White noise has as much of its squares in a span as that has of all directions.
  EXPECT_NEAR(span.share(noise), static_cast<double>(span.directions()) / sensor.channels(), 0.03);
}

}  // namespace
}  // namespace ertbench
