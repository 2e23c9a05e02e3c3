#include "models/training/training_set.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/process.h"
#include "forward/data/dataset_file.h"
#include "forward/data/faults.h"
#include "forward/data/fresh_scenes.h"
#include "models/training/objective.h"
#include "solvers/nuisances.h"

namespace ertbench {
namespace {

constexpr std::uint64_t scenes_of_a_block = 1024;

}  // namespace

EpochScenes::EpochScenes(const DatasetFile& file)
    : spec_(continued_spec(file)),
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
  // Overwrites the remains of a killed training; the block's lock excludes all others.
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
  // Concurrent trainings start at different blocks, so that they seldom need the same one.
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

namespace {

constexpr std::uint64_t scenes_at_a_time = 1024;

}  // namespace

TrainingSet::TrainingSet(const DatasetFile& file, const Standardisation& standardisation,
                         const TrainingSettings& settings, const Front* front)
    : spec_(file.spec()),
      standardisation_(standardisation),
      seed_(settings.seed),
      faults_(settings.faults),
      front_(front),
      told_(front ? Front::told(file.sensor()) : 0),
      symmetries_(ertbench::symmetries(file.sensor())),
      reference_(file.reference_voltages()),
      clean_(file.size(), file.sensor().channels()),
      truths_(file.size(), file.sensor().pixels()),
      mask_(sheet_mask(file.sensor())) {
  if (!settings.symmetries) symmetries_.resize(1);
  if (faults_.snr_db) spec_.noise.basis = SnrBasis::absolute;
  if (faults_.of_sheet()) {
    responses_ = Nuisances{.gradient = 1, .electrodes = 1}.responses(spec_.sensor);
  }
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

void TrainingSet::change_sheet(const Faults& faults, RandomStream& random,
                               Eigen::VectorXd& voltages) const {
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  const double slope = faults.background_gradient / spec_.sensor.sheet->radius();
  Eigen::VectorXd sizes(responses_.cols());
  sizes.head<2>() << slope * std::cos(angle), slope * std::sin(angle);
  sizes.tail(spec_.sensor.electrode_count) = displacements(faults, spec_.sensor, random);
  voltages += responses_ * sizes;
  voltages /= 1 + faults.background_change;
}

void TrainingSet::draw(std::uint64_t place, Eigen::VectorXd& voltages, float* frame,
                       float* truth) const {
  RandomStream random(seed_, key_of("scene"), epoch_ * size() + place, Purpose::training);
  const auto row = static_cast<Eigen::Index>(order_[place]);
  const Symmetry& symmetry = symmetries_[static_cast<std::size_t>(
      random.integer(0, static_cast<int>(symmetries_.size()) - 1))];
  for (Eigen::Index c = 0; c < voltages.size(); ++c) {
    voltages[c] = clean_(row, symmetry.channels[static_cast<std::size_t>(c)]);
  }
  RandomStream faulty(seed_, key_of("fault"), epoch_ * size() + place, Purpose::training);
  const Faults faults = faults_ ? faults_.draw(faulty) : Faults{};
  if (faults_.of_sheet()) change_sheet(faults, faulty, voltages);
  Noise noise = spec_.noise;
  if (faults_.snr_db) noise.snr_db = faulty.uniform(faults_.snr_db->first, faults_.snr_db->second);
  add_noise(noise, reference_, random, voltages);
  apply_faults(faults, spec_.sensor, reference_, faulty, voltages);
  voltages -= reference_;
  if (front_) front_->prepare(voltages.data(), frame + clean_.cols());
  standardisation_.apply(voltages.transpose(), frame);
  for (Eigen::Index p = 0; p < truths_.cols(); ++p) {
    truth[p] = truths_(row, symmetry.pixels[static_cast<std::size_t>(p)]);
  }
}

TrainingBatch TrainingSet::batch(std::uint64_t first, std::uint64_t count, int threads) const {
  const auto rows = static_cast<std::int64_t>(count);
  TrainingBatch out{
      torch::empty({rows, clean_.cols() + told_}),
      torch::empty({rows, 1, spec_.sensor.image_rows(), spec_.sensor.image_columns()})};
  const auto inputs = static_cast<std::size_t>(clean_.cols() + told_);
  const auto pixels = static_cast<std::size_t>(truths_.cols());
  float* const frames = out.frames.data_ptr<float>();
  float* const truths = out.truths.data_ptr<float>();
  parallel_for(count, threads, [&](std::size_t begin, std::size_t end) {
    Eigen::VectorXd voltages(clean_.cols());
    for (std::size_t i = begin; i < end; ++i) {
      draw(first + i, voltages, frames + i * inputs, truths + i * pixels);
    }
  });
  return out;
}

namespace {

constexpr std::int64_t batch = 250;

}  // namespace

ValidationSet::ValidationSet(const DatasetFile& file, const Standardisation& standardisation,
                             const Front* front) {
  Frames changes = file.voltages(0, file.size()).rowwise() - file.reference_voltages().transpose();
  const Images y = (1 - file.conductivity(0, file.size()).array() / file.sensor().background) /
                   standardisation.image;
  std::vector<Eigen::Index> touched;
  for (Eigen::Index f = 0; f < y.rows(); ++f) {
    // Rounding of the conductivities in the file does not count as a contact.
    if (y.row(f).cwiseAbs().maxCoeff() > 1e-12) touched.push_back(f);
  }
  if (touched.empty()) {
    throw InputError(file.path().string() +
                     ": a network is chosen by its error on frames with contacts, and the "
                     "validation set has none; add scenes with contacts");
  }
  torch::Tensor told = torch::empty(
      {static_cast<std::int64_t>(touched.size()), front ? Front::told(file.sensor()) : 0});
  float* to = told.data_ptr<float>();
  for (std::size_t i = 0; front && i < touched.size(); ++i, to += told.size(1)) {
    front->prepare(changes.row(touched[i]).data(), to);
  }
  frames_ = torch::cat({standardisation.apply(changes(touched, Eigen::all)), told}, 1);
  mask_ = sheet_mask(file.sensor());
  truths_ = torch::empty({static_cast<std::int64_t>(touched.size()), 1, file.sensor().image_rows(),
                          file.sensor().image_columns()});
  Eigen::Map<FloatRows>(truths_.data_ptr<float>(), static_cast<Eigen::Index>(touched.size()),
                        y.cols()) = y(touched, Eigen::all).cast<float>();
}

ValidationSet::Score ValidationSet::score(Network& network, torch::Device device) const {
  const torch::NoGradGuard no_gradients;
  network.eval();
  Score score;
  double sum = 0;
  torch::Tensor least;
  torch::Tensor most;
  for (std::int64_t first = 0; first < frames_.size(0); first += batch) {
    const std::int64_t last = std::min(first + batch, frames_.size(0));
    const torch::Tensor images =
        masked(network.forward(frames_.slice(0, first, last).to(device)), on_device(mask_, device))
            .flatten(1);
    const torch::Tensor truths = truths_.slice(0, first, last).to(device).flatten(1);
    sum += ((images - truths).norm(2, 1) / truths.norm(2, 1)).sum(torch::kFloat64).item<double>();
    const torch::Tensor low = images.amin(0);
    const torch::Tensor high = images.amax(0);
    least = least.defined() ? torch::minimum(least, low) : low;
    most = most.defined() ? torch::maximum(most, high) : high;
  }
  score.error = sum / static_cast<double>(frames_.size(0));
  score.spread = (most - least).max().item<double>();
  return score;
}

}  // namespace ertbench
