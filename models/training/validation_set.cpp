#include "models/training/validation_set.h"

#include <algorithm>
#include <vector>

#include "core/errors.h"
#include "forward/data/dataset_file.h"
#include "models/training/sheet_mask.h"

namespace ertbench {
namespace {

constexpr std::int64_t batch = 250;

}  // namespace

ValidationSet::ValidationSet(const DatasetFile& file, const Standardisation& standardisation) {
  const Frames changes =
      file.voltages(0, file.size()).rowwise() - file.reference_voltages().transpose();
  const Images y = (1 - file.conductivity(0, file.size()).array() / file.sensor().background) /
                   standardisation.image;
  std::vector<Eigen::Index> touched;
  for (Eigen::Index f = 0; f < y.rows(); ++f) {
    // Rounding in the file's conductivities is no contact.
    if (y.row(f).cwiseAbs().maxCoeff() > 1e-12) touched.push_back(f);
  }
  if (touched.empty()) {
    throw InputError(file.path().string() +
                     ": a network is chosen by its error on frames with contacts, and the "
                     "validation set has none; add scenes with contacts");
  }
  frames_ = standardisation.apply(changes(touched, Eigen::all));
  mask_ = sheet_mask(file.sensor());
  truths_ = torch::empty({static_cast<std::int64_t>(touched.size()), 1, file.sensor().image_rows(),
                          file.sensor().image_columns()});
  Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      truths_.data_ptr<float>(), static_cast<Eigen::Index>(touched.size()), y.cols()) =
      y(touched, Eigen::all).cast<float>();
}

ValidationSet::Score ValidationSet::score(Network& network) const {
  const torch::NoGradGuard no_gradients;
  network.eval();
  Score score;
  double sum = 0;
  torch::Tensor least;
  torch::Tensor most;
  for (std::int64_t first = 0; first < frames_.size(0); first += batch) {
    const std::int64_t last = std::min(first + batch, frames_.size(0));
    const torch::Tensor images =
        masked(network.forward(frames_.slice(0, first, last)), mask_).flatten(1);
    const torch::Tensor truths = truths_.slice(0, first, last).flatten(1);
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
