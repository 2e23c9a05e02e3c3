#pragma once

#include <torch/types.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "forward/sheet/sensor.h"
#include "models/networks/dd_ert_generator.h"
#include "models/networks/tensor_file.h"
#include "models/training/adam.h"

namespace ertbench {

/// Mask [1, 1, rows, columns]: 1 for pixels on the sheet, else 0. Undefined if the sheet fills its
/// image.
torch::Tensor sheet_mask(const Sensor& sensor);

/// Sets pixels off the sheet to zero; unchanged if `mask` is undefined.
inline torch::Tensor masked(const torch::Tensor& images, const torch::Tensor& mask) {
  return mask.defined() ? images * mask : images;
}

/// An undefined tensor stays undefined.
inline torch::Tensor on_device(const torch::Tensor& tensor, torch::Device device) {
  return tensor.defined() ? tensor.to(device) : tensor;
}

/// How discriminator and generator oppose each other.
enum class AdversarialForm {
  minimax,         ///< both on log D(truth) + log(1 - D(image)), as (B4) is written
  non_saturating,  ///< the generator maximises log D(image) instead (Goodfellow et al. 2014)
  least_squares,   ///< squared distances to 1 and 0 (Mao et al. 2017)
};

/// Loss of the discriminator; `odds_of_truths`, `odds_of_images`: its log-odds, any shape. With
/// one-sided label smoothing s (Salimans et al. 2016) the target for truths is 1 - s, which keeps
/// it from becoming overconfident; the target for images stays 0.
torch::Tensor discriminator_loss(AdversarialForm form, const torch::Tensor& odds_of_truths,
                                 const torch::Tensor& odds_of_images, double label_smoothing = 0);
/// Share of log-odds of truths (or of images) that classify correctly.
double share_judged_right(AdversarialForm form, const torch::Tensor& odds, bool of_truths);
/// Adversarial loss of the generator, the part of L_adv in (B7) that depends on it.
torch::Tensor generator_loss(AdversarialForm form, const torch::Tensor& odds_of_images);

/// Mask loss (B5): the cross entropy of images and truths, both y in [0, 1] and of one shape,
/// inside the true contacts (truth >= `threshold`), summed and divided by the number of all pixels.
torch::Tensor mask_loss(const torch::Tensor& images, const torch::Tensor& truths, double threshold);

/// Objective of the training of a network, with its opponent if it has one.
class Objective {
 public:
  virtual ~Objective() = default;

  /// Moves it to the device of the network, before the first step.
  virtual void to(torch::Device) {}

  /// Names of the parts of the loss, the columns of the log.
  virtual std::vector<std::string> terms() const { return {}; }

  /// Loss of one batch of `images` of the network and `truths`, both [frames, 1, grid, grid].
  /// Trains the opponent first, if there is one. Writes the parts to `terms` [terms().size()].
  virtual torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                             std::vector<double>& terms) = 0;

  /// Called before the loss of each step with its index in the whole training, from 0.
  virtual void begin_step(std::uint64_t /*step*/, std::uint64_t /*steps*/) {}
  virtual void set_learning_rate(double) {}
  /// Called after an epoch: a problem for the status, or no value.
  virtual std::optional<std::string> collapse() { return std::nullopt; }

  /// State on which the next step depends.
  virtual NamedTensors state() const { return {}; }
  /// Restores the result of `state`, with the same names in the same order.
  virtual void set_state(const NamedTensors&) {}
};

/// Smoothed relative error of the change of the conductivity, the metric of the tables,
///
///     mean over the frames of sqrt(|y - y_true|^2 + a^2) / sqrt(|y_true|^2 + b^2),
///
/// with a = .01 for a gradient at 0, and b = .55, the norm of a small weak contact (two pixels at
/// y = .4), so that frames with little or no contact do not outweigh the others.
class RelativeError final : public Objective {
 public:
  torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                     std::vector<double>& terms) override;
};

/// Mean squared error; |y - S y_true|^2 with a blur S.
class SquaredError final : public Objective {
 public:
  SquaredError() = default;
  /// `blur` [pixels, pixels].
  explicit SquaredError(const torch::Tensor& blur) : blur_(blur) {}
  torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                     std::vector<double>& terms) override;

  void to(torch::Device device) override { blur_ = on_device(blur_, device); }

 private:
  torch::Tensor blur_;
};

/// Gaussian noise on the discriminator's inputs, truths and images alike, so that it cannot
/// separate them by details that a generator cannot reproduce (Sønderby et al. 2017). It decreases
/// linearly to 0 over the training. The noise of a step depends only on (seed, step).
class InstanceNoise {
 public:
  /// `deviation`: standard deviation at the first step, in units of y; 0 draws nothing.
  InstanceNoise(double deviation, std::uint64_t seed) : largest_(deviation), seed_(seed) {}

  /// Steps count from 0; the last, `steps` - 1, has no noise. A training of one step has full
  /// noise.
  void begin_step(std::uint64_t step, std::uint64_t steps);
  /// Standard deviation in this step.
  double deviation() const { return deviation_; }
  /// Each call within a step draws new noise.
  torch::Tensor add_to(const torch::Tensor& images);

 private:
  double largest_;
  std::uint64_t seed_;
  double deviation_ = 0;
  torch::Generator generator_;
};

/// The content loss of DD-ERT: mean absolute error (B3), mean squared error (B6) or RelativeError.
enum class ContentLoss { l1, mse, relative };

/// The terms of DD-ERT's loss (B7): content + alpha adversarial + beta mask.
struct AdversarialSettings {
  ContentLoss content = ContentLoss::l1;
  double alpha = 1e-3;  ///< 0: no discriminator
  double beta = 0.1;
  AdversarialForm form = AdversarialForm::minimax;
  std::array<int, 2> discriminator_widths{64, 128};
  double discriminator_rate = 0.1;  ///< its learning rate over the generator's
  bool spectral_norm = false;       ///< of its convolutions, in place of batch normalisation
  double instance_noise = 0;        ///< y; standard deviation at the first step (InstanceNoise)
  double label_smoothing = 0;       ///< one-sided: truths are labelled 1 - this, below 0.5
  std::uint64_t seed = 1;           ///< of the instance noise
  /// The game is played in every such step, its term then with this times alpha (lazy, as the
  /// regularisation of Karras et al. 2020): it costs more than all of the generator.
  int every = 1;
  double mask_threshold = 0.05;  ///< y from which a pixel belongs to a contact
  bool bfloat16 = false;         ///< the discriminator's precision (ReducedPrecision)
};

/// DD-ERT's loss with its discriminator, which takes one step of its own for each batch and then
/// judges the generator's images.
///
/// Terms: the three unweighted parts of the loss ("content", "adversarial", "mask"), the
/// discriminator's loss ("discriminator") and, with a discriminator, the shares of patches of
/// truths and of images that it classifies correctly before its step ("discriminator_right_truths",
/// "discriminator_right_images"). If both are 1 the discriminator separates perfectly; at a mean of
/// 0.5 it only guesses.
class AdversarialObjective final : public Objective {
 public:
  explicit AdversarialObjective(const AdversarialSettings& settings);

  std::vector<std::string> terms() const override;
  void to(torch::Device device) override;
  torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                     std::vector<double>& terms) override;
  void begin_step(std::uint64_t step, std::uint64_t steps) override;
  void set_learning_rate(double learning_rate) override;
  std::optional<std::string> collapse() override;
  /// The discriminator's weights and its optimiser's state.
  NamedTensors state() const override;
  void set_state(const NamedTensors& state) override;

 private:
  torch::Tensor odds(const torch::Tensor& images);
  void train_discriminator(const torch::Tensor& images, const torch::Tensor& truths,
                           std::vector<double>& terms);

  AdversarialSettings settings_;
  InstanceNoise noise_;
  PatchDiscriminator discriminator_{nullptr};  ///< null where alpha is 0
  std::unique_ptr<Adam> optimiser_;
  torch::Tensor played_ = torch::zeros({6});  ///< the terms of the last move
  bool plays_ = true;                         ///< in this step
  double largest_spread_ = 0;  ///< largest range of log-odds in a batch of this epoch
};

}  // namespace ertbench
