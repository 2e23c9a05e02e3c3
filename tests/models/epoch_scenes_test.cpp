// Scenes of epochs: made once for all trainings on a set, and the set's own whatever lies there.

#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "core/errors.h"
#include "forward/data/dataset_file.h"
#include "models/training/training_set.h"
#include "tests/file_size_limit.h"
#include "tests/models/models_testing.h"

namespace ertbench {
namespace {

using namespace testing;
namespace fs = std::filesystem;

constexpr std::uint64_t count = 1100;  // a block and a part of one

/// All of an epoch.
struct Epoch {
  Epoch(EpochScenes& scenes, std::uint64_t epoch) : clean(count, 208), change(count, 576) {
    scenes.read(epoch, [&](std::uint64_t first, const EpochScenes::Block& block) {
      clean.middleRows(static_cast<Eigen::Index>(first), block.clean.rows()) = block.clean;
      change.middleRows(static_cast<Eigen::Index>(first), block.change.rows()) = block.change;
    });
  }
  bool operator==(const Epoch& other) const {
    return clean == other.clean && change == other.change;
  }
  FloatRows clean, change;
};

Epoch epoch_of(const DatasetFile& file, std::uint64_t epoch) {
  EpochScenes scenes(file);
  return {scenes, epoch};
}

std::map<fs::path, fs::file_time_type> blocks_of(const DatasetFile& file) {
  std::map<fs::path, fs::file_time_type> out;
  const fs::path folder = fs::path(file.path()).replace_extension(".epochs");
  if (!fs::exists(folder)) return out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".h5") out[entry.path()] = entry.last_write_time();
  }
  return out;
}

TEST(EpochScenes, GoOnWhereTheSetEndsAndAreMadeOnce) {
  const TrainingFiles files(count, 2);
  const DatasetFile& file = *files.input().training;
  const Epoch first = epoch_of(file, 2);
  const SceneModel model(file.sensor(), file.spec().model);
  const DatasetBlock drawn = generate_block(file.spec(), model, 2 * count, count);
  EXPECT_EQ(first.clean, drawn.clean_voltages.cast<float>());
  EXPECT_LE((file.sensor().background * (1 - first.change.cast<double>().array()) -
             drawn.conductivity.array())
                .abs()
                .maxCoeff(),
            1e-7 * file.sensor().background);  // of single precision
  const auto blocks = blocks_of(file);
  EXPECT_EQ(blocks.size(), 2u);
  EXPECT_EQ(epoch_of(file, 2), first);
  EXPECT_EQ(blocks_of(file), blocks);
  EXPECT_FALSE(epoch_of(file, 3) == first);
  EXPECT_EQ(blocks_of(file).size(), 4u);
}

TEST(EpochScenes, OfAnotherSetOrDamagedAreMadeAgain) {
  const TrainingFiles files(count, 2);
  const DatasetFile& file = *files.input().training;
  const Epoch whole = epoch_of(file, 1);
  const auto blocks = blocks_of(file);
  ASSERT_EQ(blocks.size(), 2u);
  {
    std::fstream damaged(blocks.begin()->first, std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(-100, std::ios::end);
    damaged.write("damaged", 7);
  }
  std::ofstream(blocks.rbegin()->first) << "no HDF5";
  const fs::path part = fs::path(blocks.rbegin()->first).replace_extension(".part");
  std::ofstream(part) << "of a training that was killed";
  EXPECT_EQ(epoch_of(file, 1), whole);
  EXPECT_FALSE(fs::exists(part));

  const fs::path other = files.folder() / "other.h5";
  DatasetSpec spec = file.spec();
  spec.seed += 1;
  generate_dataset(spec, other);
  fs::copy(fs::path(file.path()).replace_extension(".epochs"),
           fs::path(other).replace_extension(".epochs"), fs::copy_options::recursive);
  EXPECT_FALSE(epoch_of(DatasetFile(other), 1) == whole);
}

TEST(EpochScenes, AreUsedAlsoWhereTheyCannotBeKept) {
  const TrainingFiles files(count, 2);
  const DatasetFile& file = *files.input().training;
  const Epoch whole = epoch_of(file, 1);
  EpochScenes scenes(file);
  const FileSizeLimit full(1 << 16);
  const Epoch unkept(scenes, 4);
  EXPECT_TRUE(unkept == Epoch(scenes, 4));
  EXPECT_FALSE(unkept == whole);
  EXPECT_EQ(blocks_of(file).size(), 2u);
}

}  // namespace
}  // namespace ertbench
