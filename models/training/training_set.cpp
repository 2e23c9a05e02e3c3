#include "models/training/training_set.h"

#include <algorithm>
#include <numeric>

#include "forward/data/dataset_file.h"
#include "forward/data/noise.h"
#include "models/training/sheet_mask.h"

namespace ertbench {
namespace {

constexpr std::uint64_t scenes_at_a_time = 1024;

}  // namespace

TrainingSet::TrainingSet(const DatasetFile& file, const Standardisation& standardisation,
                         const TrainingSettings& settings)
    : spec_(file.spec()),
      standardisation_(standardisation),
      seed_(settings.seed),
      faults_(settings.faults),
      symmetries_(ertbench::symmetries(file.sensor())),
      reference_(file.reference_voltages()),
      clean_(file.size(), file.sensor().channels()),
      truths_(file.size(), file.sensor().pixels()),
      mask_(sheet_mask(file.sensor())) {
  if (!settings.symmetries) symmetries_.resize(1);
  if (settings.new_scenes) new_scenes_ = std::make_unique<EpochScenes>(file);
  for (std::uint64_t first = 0; first < size(); first += scenes_at_a_time) {
    const std::uint64_t count = std::min(scenes_at_a_time, size() - first);
    const auto row = static_cast<Eigen::Index>(first);
    const auto rows = static_cast<Eigen::Index>(count);
    clean_.middleRows(row, rows) = file.clean_voltages(first, count).cast<float>();
    truths_.middleRows(row, rows) =
        ((1 - file.conductivity(first, count).array() / spec_.sensor.background) /
         standardisation_.image)
            .cast<float>();
  }
}

void TrainingSet::begin_epoch(std::uint64_t epoch) {
  epoch_ = epoch;
  if (new_scenes_ && scenes_of_epoch_ != epoch) {
    const auto image = static_cast<float>(standardisation_.image);
    new_scenes_->read(epoch, [&](std::uint64_t first, const EpochScenes::Block& block) {
      const auto row = static_cast<Eigen::Index>(first);
      clean_.middleRows(row, block.clean.rows()) = block.clean;
      truths_.middleRows(row, block.change.rows()) = block.change / image;
    });
    scenes_of_epoch_ = epoch;
  }
  order_.resize(size());
  std::iota(order_.begin(), order_.end(), 0);
  RandomStream random(seed_, key_of("order"), epoch, Purpose::training);
  for (std::size_t i = order_.size(); i > 1; --i) {  // Fisher-Yates
    std::swap(order_[i - 1],
              order_[static_cast<std::size_t>(random.integer(0, static_cast<int>(i) - 1))]);
  }
}

TrainingBatch TrainingSet::batch(std::uint64_t first, std::uint64_t count) const {
  const auto rows = static_cast<std::int64_t>(count);
  TrainingBatch out{
      torch::empty({rows, clean_.cols()}),
      torch::empty({rows, 1, spec_.sensor.image_rows(), spec_.sensor.image_columns()})};
  float* frame = out.frames.data_ptr<float>();
  float* truth = out.truths.data_ptr<float>();
  Eigen::VectorXd voltages(clean_.cols());
  for (std::uint64_t i = 0; i < count; ++i, frame += clean_.cols(), truth += truths_.cols()) {
    RandomStream random(seed_, key_of("scene"), epoch_ * size() + first + i, Purpose::training);
    const auto row = static_cast<Eigen::Index>(order_[first + i]);
    const Symmetry& symmetry = symmetries_[static_cast<std::size_t>(
        random.integer(0, static_cast<int>(symmetries_.size()) - 1))];
    for (Eigen::Index c = 0; c < voltages.size(); ++c) {
      voltages[c] = clean_(row, symmetry.channels[static_cast<std::size_t>(c)]);
    }
    add_noise(spec_.noise, reference_, random, voltages);
    if (faults_) {
      RandomStream faulty(seed_, key_of("fault"), epoch_ * size() + first + i, Purpose::training);
      const Faults faults = faults_.draw(faulty);
      apply_faults(faults, spec_.sensor, reference_, faulty, voltages);
    }
    standardisation_.apply((voltages - reference_).transpose(), frame);
    for (Eigen::Index p = 0; p < truths_.cols(); ++p) {
      truth[p] = truths_(row, symmetry.pixels[static_cast<std::size_t>(p)]);
    }
  }
  return out;
}

}  // namespace ertbench
