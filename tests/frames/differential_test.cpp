// Frames whose right answer is known, changed by what users do wrong, alone and in pairs, through
// the program. A call may end in the right answer, in a flag, or be refused with the cause; a wrong
// answer without a flag is a failure, and so is a sound file that is flagged or refused.
//
// A sample runs here; ERTBENCH_DIFFERENTIAL=N runs N cases and prints what became of each, and
// ERTBENCH_DIFFERENTIAL_ONLY=TEXT only those of them whose names contain the text.

#include "tests/frames/differential.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/files.h"
#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "forward/sheet/sensor_json.h"
#include "forward/sheet/sheet_shapes.h"
#include "tests/bench/program.h"

namespace ertbench::differential {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Outcome;
using testing::run_program;

constexpr int sample = 160;
constexpr double near_mm = 8;
constexpr double near_strength = 1.35;  ///< factor
constexpr double ghost = 0.3;           ///< of the weakest contact's largest change
constexpr unsigned seed = 3;

enum class End { right, flagged, refused, wrong, crashed };
const char* const names_of_ends[] = {"right", "flagged", "refused", "WRONG", "CRASHED"};

struct Image {
  bool flagged = false;
  Eigen::Vector2d place;  ///< of what has half of the largest change or more, mm
  double strength = 0;    ///< sum of the change
  double peak = 0;
};

Image image_of(const Eigen::RowVectorXd& change, bool flagged) {
  Image out;
  out.flagged = flagged || !change.allFinite();
  if (out.flagged) return out;
  const PixelGrid pixels = Sensor{}.image();
  out.peak = change.cwiseAbs().maxCoeff();
  out.strength = change.sum();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  for (int p = 0; p < pixels.count(); ++p) {
    if (std::abs(change[p]) < out.peak / 2) continue;
    sum += std::abs(change[p]) * pixels.centre(p);
    weight += std::abs(change[p]);
  }
  out.place = 100 * sum / weight;
  return out;
}

/// The images of the sound recording; what a changed one is held against.
class Known {
 public:
  explicit Known(const std::vector<Image>& sound) : sound_(sound), places_(places_of(seed)) {
    for (std::size_t i = quiet_frames; i < sound.size(); ++i) {
      weakest_ = std::min(weakest_, sound[i].peak);
    }
  }
  double far_mm() const {
    double out = 0;
    for (std::size_t i = quiet_frames; i < sound_.size(); ++i) {
      out = std::max(out, (sound_[i].place - places_[i - quiet_frames]).norm());
    }
    return out;
  }
  bool is_right(const Image& image, int frame) const {
    if (frame < quiet_frames) return image.peak < ghost * weakest_;
    const auto i = static_cast<std::size_t>(frame);
    const double ratio = image.strength / sound_[i].strength;
    return ratio < near_strength && ratio > 1 / near_strength &&
           (image.place - places_[i - quiet_frames]).norm() < near_mm;
  }

 private:
  std::vector<Image> sound_;
  std::vector<Eigen::Vector2d> places_;
  double weakest_ = HUGE_VAL;
};

struct Result {
  End end = End::right;
  std::string said;
};

/// The end of a call of which `images` came; the last ones belong to the last frames.
/// A reference that is further from the model's than usual is said of all frames at once.
Result judged(const Known& known, const Recording& r, const std::vector<Image>& images,
              const std::string& said) {
  bool flagged = said.find("is it this sensor?") != std::string::npos;
  const End otherwise = flagged ? End::flagged : End::wrong;
  const auto more = std::ssize(images) - std::ssize(r.sound);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto frame = static_cast<std::ptrdiff_t>(i) - more;
    flagged = flagged || images[i].flagged;
    if (images[i].flagged) continue;
    if (frame < 0 || !known.is_right(images[i], r.sound[static_cast<std::size_t>(frame)])) {
      std::ostringstream what;
      what << "frame " << i << " at " << images[i].place.transpose() << " mm, strength "
           << images[i].strength << ", peak " << images[i].peak << "\n";
      return {otherwise, what.str() + said};
    }
  }
  return {flagged ? End::flagged : End::right, said};
}

Result not_done(const Outcome& outcome) {
  return {outcome.exit_code == 2 ? End::refused : End::crashed, outcome.output};
}

std::vector<Image> images_in(const fs::path& file) {
  const Hdf5File in = Hdf5File::open(file);
  const auto count = in.shape("/status")[0];
  const RowMajorMatrix status = in.read_rows("/status", 0, count);
  const RowMajorMatrix images = in.read_rows("/conductivity_change", 0, count, true);
  std::vector<Image> out;
  for (Eigen::Index i = 0; i < images.rows(); ++i) {
    out.push_back(image_of(images.row(i), status(i, 0) != 0));
  }
  return out;
}

void write_what_calls_need(const fs::path& folder) {
  std::ofstream(folder / "gn.json")
      << R"({"type": "one-step-gn", "prior": "noser", "lambda": 0.1})";
  std::ofstream(folder / "disc.json") << R"({"shape": "disc", "electrode_count": 16})";
  std::ofstream(folder / "turned.json") << R"({"electrode_offset": 0.1})";
  std::ofstream(folder / "bright.json") << R"({"background": 0.6})";
  std::ofstream(folder / "live.sh")
      << "#!/bin/sh\nexec '" ERTBENCH_PROGRAM "' \"$@\" < frames.csv\n";
  fs::permissions(folder / "live.sh", fs::perms::owner_all);
}

Result reconstruct(const Known& known, const Recording& r, const fs::path& folder) {
  const Outcome outcome =
      run_program(folder, "reconstruct --solver gn.json --output images.h5 --input " +
                              write(r, folder) + r.options);
  if (outcome.exit_code != 0) return not_done(outcome);
  return judged(known, r, images_in(folder / "images.h5"), outcome.output);
}

/// The options of the other commands that stand for those of `reconstruct`.
std::string with(const std::string& options, const std::string& from, const std::string& to) {
  std::string out = options;
  if (const auto at = out.find(from); at != std::string::npos) out.replace(at, from.size(), to);
  return out;
}

std::optional<Result> live(const Known& known, const Recording& r, const fs::path& folder) {
  const std::string options = with(r.options, "--background 0-19", "--background 20");
  const bool has_other = options.find("--transposed") != std::string::npos ||
                         options.find("--background 0") != std::string::npos ||
                         options.find("-2") != std::string::npos;
  if (r.reader == Reader::eit || has_other) return std::nullopt;
  write(r, folder);
  const bool text = r.reader == Reader::text;
  const Outcome outcome =
      run_program(folder,
                  std::string("live --solver gn.json --images --lossless --input ") +
                      (text ? "-" : "replay:frames.h5") + options,
                  text ? fs::path("./live.sh") : fs::path(ERTBENCH_PROGRAM));
  if (outcome.exit_code != 0) return not_done(outcome);
  std::vector<Image> images;
  bool damaged = false;
  std::istringstream lines(outcome.output);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("{")) continue;
    const json said = json::parse(line);
    if (said.contains("damaged")) {
      for (const auto& [why, count] : said.at("damaged").items()) damaged = damaged || count != 0;
    }
    if (!said.contains("image")) continue;
    Eigen::RowVectorXd image(Sensor{}.pixels());
    for (Eigen::Index p = 0; p < image.size(); ++p) {
      const json& value = said.at("image").at(static_cast<std::size_t>(p));
      image[p] = value.is_null() ? std::nan("") : value.get<double>();
    }
    images.push_back(image_of(image, said.at("status") != "ok"));
  }
  std::string rest = outcome.output.substr(0, 2000);
  if (damaged) return Result{End::flagged, rest};
  return judged(known, r, images, rest);
}

json calibration_of(const fs::path& file) { return json::parse(contents_of(file)); }

Result calibrate(const json& sound, const Recording& r, const fs::path& folder) {
  const Outcome outcome =
      run_program(folder, "calibrate " + write(r, folder) + " --out c.json --rows 0-19" +
                              with(r.options, " --background 0-19", ""));
  if (outcome.exit_code != 0) return not_done(outcome);
  const json found = calibration_of(folder / "c.json");
  const auto ratio = found.at("background").get<double>() / sound.at("background").get<double>();
  const auto more_db = found.at("snr_db").at("absolute").get<double>() -
                       sound.at("snr_db").at("absolute").get<double>();
  const std::string& said = outcome.output;
  for (const char* word : {"warning", "likely:", "note:"}) {
    if (said.find(word) != std::string::npos) return {End::flagged, said};
  }
  if (!found.at("dead_electrodes").empty()) return {End::flagged, said};
  // Voltages that are all a quarter off are those of another background, which is the answer.
  const bool right = ratio < 1.26 && ratio > 1 / 1.26 && std::abs(more_db) < 4;
  return {right ? End::right : End::wrong, said};
}

/// What is to be done with one recording.
struct Case {
  std::string command;
  Reader reader;
  std::vector<std::size_t> mistakes;
};

std::vector<Case> all_cases(std::size_t count) {
  std::vector<Case> single, pairs;
  const std::pair<const char*, Reader> calls[] = {
      {"reconstruct", Reader::text}, {"reconstruct", Reader::hdf5}, {"reconstruct", Reader::eit},
      {"live", Reader::text},        {"live", Reader::hdf5},        {"calibrate", Reader::text},
      {"calibrate", Reader::hdf5}};
  for (const auto& [command, reader] : calls) {
    for (std::size_t a = 0; a < mistakes().size(); ++a) {
      single.push_back({command, reader, {a}});
      for (std::size_t b = 0; b < mistakes().size(); ++b) {
        if (a != b) pairs.push_back({command, reader, {a, b}});
      }
    }
  }
  Random random(seed);
  std::shuffle(pairs.begin(), pairs.end(), random);
  if (count < 2 * single.size()) std::shuffle(single.begin(), single.end(), random);
  const std::size_t alone = std::min(single.size(), count / 2);
  single.resize(alone);
  pairs.resize(std::min(pairs.size(), count - alone));
  single.insert(single.end(), pairs.begin(), pairs.end());
  return single;
}

TEST(Differential, NoMistakeIsAnsweredWronglyWithoutAFlag) {
  const char* const wanted = std::getenv("ERTBENCH_DIFFERENTIAL");
  const char* const only = std::getenv("ERTBENCH_DIFFERENTIAL_ONLY");
  const TemporaryFolder folder("differential");
  write_what_calls_need(folder.path());
  const Recording text = sound_recording(Reader::text, seed);
  const std::string frames = write(text, folder.path());
  ASSERT_EQ(run_program(folder.path(), "reconstruct --solver gn.json --output images.h5 --input " +
                                           frames + text.options)
                .exit_code,
            0);
  const Known known(images_in(folder / "images.h5"));
  ASSERT_LT(known.far_mm(), near_mm / 2);
  ASSERT_EQ(
      run_program(folder.path(), "calibrate " + frames + " --out c.json --rows 0-19").exit_code, 0);
  const json calibration = calibration_of(folder / "c.json");

  std::map<std::string, std::map<End, int>> counts;
  int harmless = 0;
  int falsely = 0;
  for (const Case& one : all_cases(wanted ? std::stoul(wanted) : sample)) {
    const TemporaryFolder place("case");
    write_what_calls_need(place.path());
    Recording recording = sound_recording(one.reader, seed);
    Random random(seed);
    std::string name = one.command + std::string(one.reader == Reader::text   ? " text"
                                                 : one.reader == Reader::hdf5 ? " HDF5"
                                                                              : " eit");
    const std::string call = name;
    bool sound = true;
    bool can = true;
    for (const std::size_t number : one.mistakes) {
      const Mistake& mistake = mistakes()[number];
      name += ": " + mistake.name;
      sound = sound && mistake.harmless;
      can = can && mistake.make(recording, random);
    }
    if (!can || (only && name.find(only) == std::string::npos)) continue;
    std::optional<Result> result;
    if (one.command == "reconstruct") result = reconstruct(known, recording, place.path());
    if (one.command == "live") result = live(known, recording, place.path());
    if (one.command == "calibrate") result = calibrate(calibration, recording, place.path());
    if (!result) continue;
    ++counts[call][result->end];
    // Two harmless changes may contradict each other, such as a unit that is declared twice, and a
    // replay takes arrays of two dimensions alone.
    const bool taken = one.command != "live" || one.reader == Reader::text;
    if (sound && taken && one.mistakes.size() == 1) {
      ++harmless;
      falsely += result->end != End::right;
      EXPECT_EQ(result->end, End::right) << name << "\n" << result->said;
    }
    EXPECT_LT(result->end, End::wrong) << name << "\n" << result->said;
    if (wanted) std::printf("%s: %s\n", names_of_ends[static_cast<int>(result->end)], name.c_str());
  }
  for (const auto& [call, ends] : counts) {
    std::printf("%-18s", call.c_str());
    for (const auto& [end, count] : ends) {
      std::printf("  %s %d", names_of_ends[static_cast<int>(end)], count);
    }
    std::printf("\n");
  }
  std::printf("sound files %d, falsely refused or flagged %d\n", harmless, falsely);
}

/// What `score` gets.
struct Scored {
  Images images;  ///< changes, S/m
  Images truths;  ///< S/m
  RowMajorMatrix status;
  Sensor sensor;  ///< of the images
  std::string name = "/conductivity_change";
};

Scored sound_images() {
  const Sensor sensor;
  const PixelGrid pixels = sensor.image();
  Scored out;
  out.truths.resize(touched_frames, sensor.pixels());
  for (Eigen::Index i = 0; i < touched_frames; ++i) {
    const Eigen::Vector2d place = places_of(seed)[static_cast<std::size_t>(i)] / 100;
    for (int p = 0; p < pixels.count(); ++p) {
      const bool inside = (pixels.centre(p) - place).norm() < 0.25;
      out.truths(i, p) = sensor.background * (inside ? 0.4 : 1);
    }
  }
  Random random(seed);
  std::normal_distribution<double> noise(0, 0.02 * sensor.background);
  out.images = 0.8 * (out.truths.array() - sensor.background);
  for (double& v : out.images.reshaped()) v += noise(random);
  out.status = RowMajorMatrix::Zero(touched_frames, 1);
  return out;
}

Outcome score(const Scored& scored, const fs::path& folder) {
  const auto frames = static_cast<std::uint64_t>(scored.images.rows());
  Hdf5File images = Hdf5File::create(folder / "images.h5");
  images.create_dataset(scored.name, {frames, 24, 24});
  images.write_rows(scored.name, 0, scored.images);
  images.create_dataset("/status", {frames});
  images.write_rows("/status", 0, scored.status);
  images.write_text("/", "sensor", to_json(scored.sensor).dump());
  images.close();
  Hdf5File truths = Hdf5File::create(folder / "truth.h5");
  truths.create_dataset("/conductivity",
                        {static_cast<std::uint64_t>(scored.truths.rows()), 24, 24});
  truths.write_rows("/conductivity", 0, scored.truths);
  truths.write_text("/", "sensor", to_json(Sensor{}).dump());
  truths.close();
  return run_program(folder, "score images.h5 truth.h5");
}

TEST(Differential, ImagesThatAreNotTheTruthsAreScoredWithAWarningOrNotAtAll) {
  const TemporaryFolder folder("score");
  const Outcome sound = score(sound_images(), folder.path());
  EXPECT_EQ(sound.exit_code, 0) << sound.output;
  EXPECT_EQ(sound.output.find("warning"), std::string::npos) << sound.output;

  const auto turned = [](const std::function<RowMajorMatrix(const RowMajorMatrix&)>& turn) {
    return [turn](Scored& s) {
      for (Eigen::Index i = 0; i < s.images.rows(); ++i) {
        const RowMajorMatrix image = s.images.row(i).reshaped<Eigen::RowMajor>(24, 24);
        s.images.row(i) = turn(image).reshaped<Eigen::RowMajor>().transpose();
      }
    };
  };
  using Image = const RowMajorMatrix&;
  const std::pair<const char*, std::function<void(Scored&)>> wrong[] = {
      {"negated", [](Scored& s) { s.images *= -1; }},
      {"mS/m", [](Scored& s) { s.images *= 1e3; }},
      {"kS/m", [](Scored& s) { s.images *= 1e-3; }},
      {"one in mS/m", [](Scored& s) { s.images.row(2) *= 1e3; }},
      {"rows turned", turned([](Image i) { return RowMajorMatrix(i.colwise().reverse()); })},
      {"columns turned", turned([](Image i) { return RowMajorMatrix(i.rowwise().reverse()); })},
      {"transposed", turned([](Image i) { return RowMajorMatrix(i.transpose()); })},
      {"absolute", [](Scored& s) { s.images.array() += s.sensor.background; }},
      {"changes as conductivities", [](Scored& s) { s.name = "/conductivity"; }},
      {"truths in mS/m", [](Scored& s) { s.truths *= 1e3; }},
      {"truths as changes", [](Scored& s) { s.truths.array() -= s.sensor.background; }},
      {"truths negated", [](Scored& s) { s.truths *= -1; }},
      {"a frame less",
       [](Scored& s) {
         s.images = Images(s.images.topRows(5));
         s.status = RowMajorMatrix(s.status.topRows(5));
       }},
      {"a status of 9", [](Scored& s) { s.status(1, 0) = 9; }},
      {"another side", [](Scored& s) { s.sensor.sheet = std::make_shared<const SquareSheet>(50); }},
      {"another background", [](Scored& s) { s.sensor.background = 0.6; }},
      {"other electrodes", [](Scored& s) { s.sensor.electrode_offset = 0.1; }},
  };
  for (const auto& [name, change] : wrong) {
    Scored scored = sound_images();
    change(scored);
    const Outcome outcome = score(scored, folder.path());
    const bool warned =
        outcome.exit_code == 0 && outcome.output.find("warning") != std::string::npos;
    EXPECT_TRUE(warned || outcome.exit_code == 2) << name << "\n" << outcome.output;
  }
}

}  // namespace
}  // namespace ertbench::differential
