// Frames that move reach a solver as streams, those that stand alone all at once.

#include <gtest/gtest.h>

#include <deque>
#include <nlohmann/json.hpp>

#include "bench/run/accuracy_stage.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/sheet/scene.h"
#include "solvers/solver.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Counts the frames of each of its streams, and says of the n-th that one contact lies at n mm.
class Counting final : public Solver {
 public:
  json parameters() const override { return json::object(); }
  void fit(const FitInput&) override {}
  void reconstruct(FramesView, ImagesView images, std::span<FrameReport>) const override {
    images.setZero();
    ++calls;
  }
  std::unique_ptr<FrameStream> open_stream() const override {
    frames.push_back(0);
    return std::make_unique<Stream>(frames.back());
  }
  void save(const std::filesystem::path&) const override {}
  void load(const std::filesystem::path&, const Sensor&) override {}

  mutable int calls = 0;
  mutable std::deque<int> frames;  ///< of each stream

 private:
  class Stream final : public FrameStream {
   public:
    explicit Stream(int& count) : count_(count) {}
    void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport>) override {
      images.setZero();
      count_ += static_cast<int>(changes.rows());
      contacts_ = {{.place = {0.01 * count_, 0}, .strength = 1, .peak = 1, .area = 1}};
    }
    const std::vector<FoundContact>* contacts() const override { return &contacts_; }

   private:
    int& count_;
    std::vector<FoundContact> contacts_;
  };
};

json scored(const char* dataset, const Counting& solver, Eigen::VectorXd& sequences) {
  const TemporaryFolder folder("score_set");
  const json given = json::parse(dataset);
  Sensor sensor;
  sensor.skin = Skin{};
  const DatasetSpec spec = dataset_spec_from_json(JsonObject(given, "test", ""), sensor, "test");
  generate_dataset(spec, folder / "set.h5");
  const DatasetFile set(folder / "set.h5");
  sequences = set.sequences(0, set.size());
  ScoreRequest request;
  request.keep_contacts = true;
  return *score_set(solver, set, set.sensor(), request).frames;
}

TEST(ScoreSet, FollowsEachSequenceFrameByFrame) {
  const Counting solver;
  Eigen::VectorXd sequences;
  const json frames = scored(R"({"grid": 24, "snr_db": 50, "snr_basis": "absolute",
      "scenes": {"sequence": "write", "characters": "L7", "speed_mm_s": 200}})",
                             solver, sequences);
  const int first = static_cast<int>((sequences.array() == 0).count());
  const int second = static_cast<int>((sequences.array() == 1).count());
  EXPECT_GT(first + second, 256);  // more than are scored at a time
  EXPECT_EQ(solver.calls, 0);
  EXPECT_EQ(solver.frames, (std::deque<int>{first, second}));
  const json& readings = frames.at("readings");
  // The first frame of each sequence has what its own stream says.
  for (const int frame : {0, first}) {
    EXPECT_EQ(readings.at(static_cast<std::size_t>(frame)).at("contacts").size(), 1u) << frame;
  }
  EXPECT_EQ(readings.at(0), readings.at(static_cast<std::size_t>(first)));
  EXPECT_NE(readings.at(0), readings.at(1));
}

TEST(ScoreSet, AsksForFramesThatStandAloneAtOnce) {
  const Counting solver;
  Eigen::VectorXd sequences;
  scored(R"({"count": 10, "grid": 24, "snr_db": 50, "snr_basis": "absolute",
             "scenes": {"contacts": 1, "radius": 0.2, "conductivity_ratio": 0.5}})",
         solver, sequences);
  EXPECT_EQ(sequences.size(), 0);
  EXPECT_EQ(solver.calls, 1);
  EXPECT_TRUE(solver.frames.empty());
}

TEST(ScoreSet, FlagsFramesOfFilesThatTheSheetCannotGive) {
  const TemporaryFolder folder("score_set");
  const json given = json::parse(R"({"count": 4, "grid": 24, "snr_db": 50, "snr_basis": "absolute",
      "scenes": {"contacts": 1, "radius": 0.2, "conductivity_ratio": 0.5}})");
  generate_dataset(dataset_spec_from_json(JsonObject(given, "test", ""), {}, "test"),
                   folder / "set.h5");
  {
    Hdf5File file = Hdf5File::open_writable(folder / "set.h5");
    file.write_rows("/voltages", 2, 1000 * file.read_rows("/voltages", 2, 1));
    file.write_checksum();
    file.close();
  }
  const DatasetFile set(folder / "set.h5");
  ScoreRequest request;
  const Counting solver;
  EXPECT_EQ(score_set(solver, set, set.sensor(), request).frames->at("status"), json({0, 0, 0, 0}));
  request.judge_frames = true;
  const ScoredFrames scored = score_set(solver, set, set.sensor(), request);
  EXPECT_EQ(scored.frames->at("status"), json({0, 0, 3, 0}));
  EXPECT_EQ(scored.frames->at("reasons"), json({0, 0, 32, 0}));
  EXPECT_EQ(scored.row.suspect_frames, 1);
}

}  // namespace
}  // namespace ertbench
