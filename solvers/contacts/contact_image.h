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

  /// `image` [pixels] S/m from the covered area of each pixel, exact.
  void most_likely(std::span<const EllipticContact> contacts,
                   Eigen::Ref<Eigen::RowVectorXd> image) const;
  /// `image` [pixels] S/m with the least expected squared error: the mean over the posterior in
  /// Laplace's approximation, over the two best numbers of contacts. Covered areas are accurate to
  /// some per cent of a pixel, which averages out.
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

/// Number of frames, from the first of the validation set on, that noise and misfits come from.
inline constexpr std::uint64_t judged_frames = 400;

/// Standard deviation of the noise of one channel, V, from the differences between the two channels
/// of reciprocal pairs, without pairs of the `masked` electrodes. Simulated frames without such
/// pairs use their clean voltages instead. No value for measured frames without such pairs.
std::optional<double> noise_of_channel(const DatasetFile& set, ElectrodeSet masked);

/// Returns those of the first `count` frames whose contacts all have a conductivity ratio in
/// `ratio`, since the misfit of other contacts says nothing about such frames. All frames if few
/// do, or without `ratio`.
std::vector<Eigen::Index> frames_like(const DatasetFile& set, std::uint64_t count,
                                      const std::optional<std::pair<double, double>>& ratio);

}  // namespace ertbench
