#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/arrays.h"
#include "forward/data/dataset_file.h"
#include "forward/sheet/sensor.h"
#include "solvers/contacts/contact_fit.h"
#include "solvers/solver.h"

namespace ertbench {

/// Images of fitted contacts.
class ContactImage {
 public:
  explicit ContactImage(const Sensor& sensor);

  /// `image` [pixels] S/m: by the covered area of each pixel, exactly.
  void most_likely(std::span<const EllipticContact> contacts,
                   Eigen::Ref<Eigen::RowVectorXd> image) const;
  /// The mean over the posterior (Laplace's approximation of it, and the two best numbers of
  /// contacts by their evidence): the image of least expected squared error. Its covered areas are
  /// good to some per cent of a pixel, which the mean evens out.
  void posterior_mean(const ContactFit::Found& found, Eigen::Ref<Eigen::RowVectorXd> image) const;

 private:
  void add_mean(const ContactFit::Result& result, double weight,
                Eigen::Ref<Eigen::RowVectorXd> image) const;
  /// Adds `weight` times the change of these contacts, in units of the background.
  void add_sample(std::span<const EllipticContact> contacts, double weight,
                  Eigen::Ref<Eigen::RowVectorXd> image) const;

  PixelGrid pixels_;
  double background_ = 0;
  Eigen::MatrixXd samples_;  ///< [parameters of the most contacts, samples] standard normal
};

/// Frames of a validation set that noise and misfits are taken from, the first.
inline constexpr std::uint64_t judged_frames = 400;

/// Standard deviation of one channel, V, from what the two channels of a reciprocal pair differ by,
/// pairs of the `masked` electrodes left out; of simulated frames without such pairs from their
/// clean voltages. Nothing where no frame tells: measured ones whose channels are all different.
std::optional<double> noise_of_channel(const DatasetFile& set, ElectrodeSet masked);

/// Of the first `count` frames those whose contacts all have a conductivity ratio in `ratio`, or
/// all where few do or none is given: what another contact leaves when it is fitted as one of this
/// ratio says nothing of a frame.
std::vector<Eigen::Index> frames_like(const DatasetFile& set, std::uint64_t count,
                                      const std::optional<std::pair<double, double>>& ratio);

}  // namespace ertbench
