#include "models/training/epoch_scenes.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/file_lock.h"
#include "core/hdf5_file.h"
#include "core/replace_file.h"
#include "forward/data/dataset_block.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

constexpr std::uint64_t scenes_of_a_block = 1024;

DatasetSpec drawable(const DatasetFile& file) {
  DatasetSpec spec = file.spec();
  if (std::holds_alternative<std::vector<Scene>>(spec.scenes) || spec.sequences() ||
      spec.measured()) {
    throw InputError(file.path().string() +
                     ": its scenes are listed, measured or move, so that \"new_scenes\" cannot "
                     "draw others; leave it out or give the training set a distribution");
  }
  return spec;
}

}  // namespace

EpochScenes::EpochScenes(const DatasetFile& file)
    : spec_(drawable(file)),
      size_(file.size()),
      folder_(std::filesystem::path(file.path()).replace_extension(".epochs")),
      checksum_(Hdf5File::open(file.path()).read_text("/", "checksum")),
      model_(spec_.sensor, spec_.model) {}

std::filesystem::path EpochScenes::file_of(std::uint64_t epoch, std::uint64_t block) const {
  return folder_ / std::to_string(epoch) / (std::to_string(block) + ".h5");
}

EpochScenes::Block EpochScenes::made(std::uint64_t epoch, std::uint64_t block) const {
  const std::uint64_t first = block * scenes_of_a_block;
  const DatasetBlock drawn = generate_block(spec_, model_, epoch * size_ + first,
                                            std::min(scenes_of_a_block, size_ - first));
  return {drawn.clean_voltages.cast<float>(),
          (1 - drawn.conductivity.array() / spec_.sensor.background).cast<float>()};
}

EpochScenes::Block EpochScenes::kept(const std::filesystem::path& file,
                                     std::uint64_t scenes) const {
  const Hdf5File in = Hdf5File::open(file);
  if (const std::string why = in.why_changed(); !why.empty()) {
    throw InputError(file.string() + ": " + why);
  }
  if (in.read_text("/", "dataset") != checksum_) {
    throw InputError(file.string() + ": is of another dataset");
  }
  in.require_shape("/clean", {scenes, static_cast<std::uint64_t>(spec_.sensor.channels())});
  in.require_shape("/change", {scenes, static_cast<std::uint64_t>(spec_.sensor.pixels())});
  return {in.read_rows("/clean", 0, scenes).cast<float>(),
          in.read_rows("/change", 0, scenes).cast<float>()};
}

void EpochScenes::keep(const Block& block, const std::filesystem::path& file) const {
  const auto write = [](Hdf5File& out, const char* name, const FloatRows& rows) {
    out.create_dataset(
        name, {static_cast<std::uint64_t>(rows.rows()), static_cast<std::uint64_t>(rows.cols())},
        Hdf5File::Number::real32);
    out.write_rows(name, 0, rows.cast<double>());
  };
  // What a killed training left is written over: the block's lock keeps all others away.
  replace_file(
      file,
      [&](const std::filesystem::path& aside) {
        Hdf5File out = Hdf5File::create(aside);
        out.write_text("/", "dataset", checksum_);
        write(out, "/clean", block.clean);
        write(out, "/change", block.change);
        out.write_checksum();
        out.close();
      },
      std::filesystem::path(file).replace_extension(".part"));
}

void EpochScenes::read(std::uint64_t epoch,
                       const std::function<void(std::uint64_t first, const Block& block)>& take) {
  std::vector<std::uint64_t> left((size_ + scenes_of_a_block - 1) / scenes_of_a_block);
  std::iota(left.begin(), left.end(), 0);
  // Trainings at the same time begin with different blocks, so that they seldom want the same one.
  std::shuffle(left.begin(), left.end(), std::minstd_rand(static_cast<unsigned>(::getpid())));
  for (const std::uint64_t b : left) {
    const std::uint64_t first = b * scenes_of_a_block;
    const std::uint64_t scenes = std::min(scenes_of_a_block, size_ - first);
    const std::filesystem::path file = file_of(epoch, b);
    if (!keeps_) {
      take(first, made(epoch, b));
      continue;
    }
    try {
      const FileLock lock(std::filesystem::path(file).replace_extension(".lock"),
                          MissingFolder::make);
      if (std::filesystem::exists(file)) {
        try {
          take(first, kept(file, scenes));
          continue;
        } catch (const InputError&) {  // made again
        }
      }
      const Block block = made(epoch, b);
      take(first, block);
      keep(block, file);
    } catch (const std::exception& error) {
      spdlog::warn("{}; scenes of epochs are not kept, each training makes its own", error.what());
      keeps_ = false;
      take(first, made(epoch, b));
    }
  }
}

}  // namespace ertbench
