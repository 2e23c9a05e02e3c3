#pragma once

#include <torch/optim/adam.h>
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

namespace ertbench {

/// 1 for pixels that are on the sheet and 0 for those that are not, [1, 1, rows, columns];
/// undefined where the sheet fills its image.
torch::Tensor sheet_mask(const Sensor& sensor);

/// Images as they count: without what lies off the sheet. As they are where `mask` is undefined.
inline torch::Tensor masked(const torch::Tensor& images, const torch::Tensor& mask) {
  return mask.defined() ? images * mask : images;
}

/// How discriminator and generator oppose each other.
enum class AdversarialForm {
  minimax,         ///< both on log D(truth) + log(1 - D(image)), as (B4) is written
  non_saturating,  ///< the generator maximises log D(image) instead (Goodfellow et al. 2014)
  least_squares,   ///< squared distances to 1 and 0 (Mao et al. 2017)
};

/// What the discriminator minimises; `odds_of_truths`, `odds_of_images`: its log-odds, any shape.
/// With one-sided label smoothing s (Salimans et al. 2016) it is to answer truths with 1 - s, not
/// 1, so that it does not grow sure of itself; images with 0 all the same.
torch::Tensor discriminator_loss(AdversarialForm form, const torch::Tensor& odds_of_truths,
                                 const torch::Tensor& odds_of_images, double label_smoothing = 0);
/// Of the log-odds that a discriminator gave to truths (or to images), the share on the right side.
double share_judged_right(AdversarialForm form, const torch::Tensor& odds, bool of_truths);
/// What the generator minimises, L_adv of (B7) as far as it depends on the generator.
torch::Tensor generator_loss(AdversarialForm form, const torch::Tensor& odds_of_images);

/// Mask loss (B5): the cross entropy of images and truths, both y in [0, 1] and of one shape,
/// inside the true contacts (truth >= `threshold`), summed and divided by the number of all pixels.
torch::Tensor mask_loss(const torch::Tensor& images, const torch::Tensor& truths, double threshold);

/// What the training of a network minimises, together with whatever is trained against it.
class Objective {
 public:
  virtual ~Objective() = default;

  /// The parts of the loss, as the log's columns call them.
  virtual std::vector<std::string> terms() const { return {}; }

  /// The loss of one batch: `images` as the network made them, `truths`, both [frames, 1, grid,
  /// grid]. Trains the network's opponent first, where there is one. `terms` [terms().size()]
  /// receives the parts.
  virtual torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                             std::vector<double>& terms) = 0;

  /// Before each step's loss: its place in the whole training, from 0.
  virtual void begin_step(std::uint64_t /*step*/, std::uint64_t /*steps*/) {}
  virtual void set_learning_rate(double) {}
  /// After an epoch: what has gone wrong in it, for the status; nothing where all is well.
  virtual std::optional<std::string> collapse() { return std::nullopt; }

  /// All that the next step depends on.
  virtual NamedTensors state() const { return {}; }
  /// Goes on from what `state` gave: the same names, in the same order.
  virtual void set_state(const NamedTensors&) {}
};

/// The relative error of the change of the conductivity, which the tables report,
///
///     mean over the frames of sqrt(|y - y_true|^2 + a^2) / sqrt(|y_true|^2 + b^2),
///
/// a = .01, so that there is a gradient at 0, and b = .55, the norm of a weak small contact (two
/// pixels at y = .4), so that frames that show nothing, or next to it, do not outweigh the others.
class RelativeError final : public Objective {
 public:
  torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                     std::vector<double>& terms) override;
};

/// Mean squared error, |y - S y_true|^2 where a blur S is given.
class SquaredError final : public Objective {
 public:
  SquaredError() = default;
  /// `blur` [pixels, pixels].
  explicit SquaredError(const torch::Tensor& blur) : blur_(blur) {}
  torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                     std::vector<double>& terms) override;

 private:
  torch::Tensor blur_;
};

/// Gaussian noise on all that a discriminator sees, truths and images alike, so that it cannot tell
/// them by traits too fine for a generator to follow (Sønderby et al. 2017). It falls in a straight
/// line to 0 over the training. What a step draws depends on (seed, step) alone.
class InstanceNoise {
 public:
  /// `deviation`: its standard deviation at the first step, in units of y; 0: none, and then
  /// nothing is drawn.
  InstanceNoise(double deviation, std::uint64_t seed) : largest_(deviation), seed_(seed) {}

  /// Steps count from 0; the last is `steps` - 1 and has no noise. Of a training of one step, that
  /// one has all of it.
  void begin_step(std::uint64_t step, std::uint64_t steps);
  /// The standard deviation in this step.
  double deviation() const { return deviation_; }
  /// Each call of a step draws other noise.
  torch::Tensor add_to(const torch::Tensor& images);

 private:
  double largest_;
  std::uint64_t seed_;
  double deviation_ = 0;
  torch::Generator generator_;
};

/// The terms of DD-ERT's loss (B7): content + alpha adversarial + beta mask.
struct AdversarialSettings {
  bool squared_content = false;  ///< mean squared in place of mean absolute error (B6, B3)
  double alpha = 1e-3;           ///< 0: no discriminator
  double beta = 0.1;
  AdversarialForm form = AdversarialForm::minimax;
  std::array<int, 2> discriminator_widths{64, 128};
  double discriminator_rate = 0.1;  ///< its learning rate over the generator's
  bool spectral_norm = false;       ///< of its convolutions, in place of batch normalisation
  double instance_noise = 0;        ///< y; standard deviation at the first step (InstanceNoise)
  double label_smoothing = 0;       ///< one-sided: truths are labelled 1 - this, below 0.5
  std::uint64_t seed = 1;           ///< of the instance noise
  double mask_threshold = 0.05;     ///< y from which a pixel belongs to a contact
  bool bfloat16 = false;            ///< the discriminator's precision (ReducedPrecision)
};

/// DD-ERT's loss, with its discriminator: for each batch the discriminator takes one step of its
/// own, then judges the generator's images.
///
/// Its terms are the three of the loss, unweighted ("content", "adversarial", "mask"), the
/// discriminator's own loss ("discriminator") and, with a discriminator, how alive the game is: the
/// share of the patches of truths and of images that it judges right, before the step that it takes
/// on them ("discriminator_right_truths", "discriminator_right_images"). Both at 1 is a game that
/// is over, a mean of 0.5 one in which it can but guess.
class AdversarialObjective final : public Objective {
 public:
  explicit AdversarialObjective(const AdversarialSettings& settings);

  std::vector<std::string> terms() const override;
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
  std::unique_ptr<torch::optim::Adam> optimiser_;
  double largest_spread_ = 0;  ///< of the log-odds over a batch, in this epoch
};

}  // namespace ertbench
