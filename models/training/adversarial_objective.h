#pragma once

#include <torch/optim/adam.h>

#include <array>
#include <cstdint>
#include <memory>

#include "models/networks/patch_discriminator.h"
#include "models/training/instance_noise.h"
#include "models/training/losses.h"
#include "models/training/objective.h"

namespace ertbench {

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
