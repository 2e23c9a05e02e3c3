#pragma once

#include <torch/types.h>

#include <string>

namespace ertbench {

/// How discriminator and generator oppose each other.
enum class AdversarialForm {
  minimax,         ///< both on log D(truth) + log(1 - D(image)), as (B4) is written
  non_saturating,  ///< the generator maximises log D(image) instead (Goodfellow et al. 2014)
  least_squares,   ///< squared distances to 1 and 0 (Mao et al. 2017)
};

AdversarialForm adversarial_form_from_name(const std::string& name);
const char* name_of(AdversarialForm form);

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

}  // namespace ertbench
