#include "solvers/linear/training_scenes.h"

#include <algorithm>

#include "core/errors.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

constexpr std::uint64_t read_at_once = 1000;
constexpr Eigen::Index scenes_at_once = 512;  ///< scenes of one matrix product

/// For each pair the one that a symmetry takes it from: both channels of a pair come from the two
/// of another.
std::vector<Eigen::Index> turned_pairs(const Reciprocity& reciprocity, const Symmetry& symmetry) {
  std::vector<Eigen::Index> pair_of(symmetry.channels.size());
  for (Eigen::Index p = 0; p < reciprocity.pairs(); ++p) {
    for (const int channel : reciprocity.pair(p)) pair_of[static_cast<std::size_t>(channel)] = p;
  }
  std::vector<Eigen::Index> from;
  for (Eigen::Index p = 0; p < reciprocity.pairs(); ++p) {
    const auto channel = static_cast<std::size_t>(reciprocity.pair(p)[0]);
    from.push_back(pair_of[static_cast<std::size_t>(symmetry.channels[channel])]);
  }
  return from;
}

}  // namespace

TrainingScenes::TrainingScenes(const FitInput& input, const std::string& place, bool symmetries) {
  if (!input.training) {
    throw InputError(place + ": needs a training set; add \"train\" to the datasets");
  }
  const DatasetFile& set = *input.training;
  if (set.sensor() != input.sensor) {
    throw InputError(place + ": the training set " + set.path().string() +
                     " is of another sensor; generate it for this one");
  }
  const Reciprocity reciprocity(input.sensor);
  changes_.resize(static_cast<Eigen::Index>(set.size()), reciprocity.pairs());
  images_.resize(static_cast<Eigen::Index>(set.size()), input.sensor.pixels());
  for (std::uint64_t first = 0; first < set.size(); first += read_at_once) {
    const std::uint64_t count = std::min(read_at_once, set.size() - first);
    const auto row = static_cast<Eigen::Index>(first);
    const Frames voltages = set.voltages(first, count);
    images_.middleRows(row, static_cast<Eigen::Index>(count)) =
        (set.conductivity(first, count).array() - input.sensor.background).cast<float>();
    for (Eigen::Index f = 0; f < voltages.rows(); ++f) {
      changes_.row(row + f) =
          reciprocity.reduce(voltages.row(f) - set.reference_voltages().transpose()).transpose();
    }
  }
  // Rounding in the file's conductivities is no contact.
  const auto rounding = static_cast<float>(1e-6 * input.sensor.background);
  if (images_.size() == 0 || images_.cwiseAbs().maxCoeff() <= rounding) {
    throw InputError(place + ": needs a training set with contacts; " + set.path().string() +
                     " has none");
  }
  for (const Symmetry& symmetry : ertbench::symmetries(input.sensor)) {
    turns_.push_back(
        {turned_pairs(reciprocity, symmetry), {symmetry.pixels.begin(), symmetry.pixels.end()}});
    if (!symmetries) break;
  }
}

void TrainingScenes::change(Eigen::Index index, Eigen::Ref<Eigen::RowVectorXd> out) const {
  const Turn& turn = turns_[static_cast<std::size_t>(index / changes_.rows())];
  const double* const row = changes_.row(index % changes_.rows()).data();
  for (Eigen::Index p = 0; p < out.size(); ++p)
    out[p] = row[turn.pairs[static_cast<std::size_t>(p)]];
}

void TrainingScenes::image(Eigen::Index index, Eigen::Ref<Eigen::RowVectorXd> out) const {
  const Turn& turn = turns_[static_cast<std::size_t>(index / images_.rows())];
  const float* const row = images_.row(index % images_.rows()).data();
  for (Eigen::Index p = 0; p < out.size(); ++p) {
    out[p] = static_cast<double>(row[turn.pixels[static_cast<std::size_t>(p)]]);
  }
}

JointMoments moments_of(const TrainingScenes& scenes, const std::vector<Eigen::Index>& which,
                        bool about_zero) {
  const Eigen::Index count =
      which.empty() ? scenes.count() : static_cast<Eigen::Index>(which.size());
  JointMoments out{static_cast<double>(count), Eigen::VectorXd::Zero(scenes.pairs()),
                   Eigen::VectorXd::Zero(scenes.pixels()),
                   Eigen::MatrixXd::Zero(scenes.pairs(), scenes.pairs()),
                   Eigen::MatrixXd::Zero(scenes.pixels(), scenes.pairs())};
  RowMajorMatrix changes(scenes_at_once, scenes.pairs());
  RowMajorMatrix images(scenes_at_once, scenes.pixels());
  for (Eigen::Index first = 0; first < count; first += scenes_at_once) {
    const Eigen::Index size = std::min(scenes_at_once, count - first);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index index =
          which.empty() ? first + i : which[static_cast<std::size_t>(first + i)];
      scenes.change(index, changes.row(i));
      scenes.image(index, images.row(i));
    }
    const auto d = changes.topRows(size);
    const auto x = images.topRows(size);
    out.changes.noalias() += d.transpose() * d;
    out.cross.noalias() += x.transpose() * d;
    out.change_mean += d.colwise().sum().transpose();
    out.image_mean += x.colwise().sum().transpose();
  }
  out.changes /= out.scenes;
  out.cross /= out.scenes;
  out.change_mean /= out.scenes;
  out.image_mean /= out.scenes;
  if (about_zero) {
    out.change_mean.setZero();
    out.image_mean.setZero();
  } else {
    out.changes -= out.change_mean * out.change_mean.transpose();
    out.cross -= out.image_mean * out.change_mean.transpose();
  }
  return out;
}

}  // namespace ertbench
