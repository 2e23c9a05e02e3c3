// The learned solvers as a plugin, with which libtorch is loaded.

#include "models/solvers/solvers.h"
#include "models/solvers/torch_script_solver.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

/// `own` and the parameters that all trainings share.
std::vector<ParameterInfo> with_training(std::vector<ParameterInfo> own) {
  const std::vector<ParameterInfo> shared = {
      {"seed", "of first weights, order and noise, 0 ... 2147483647; default 1",
       ParameterRole::seed},
      {"epochs", "passes over the training set, at most; default 20 (lean-net: 40)"},
      {"batch", "scenes a step, 2 ... 65536; default 32 (dd-ert: 16)"},
      {"learning_rate", "of Adam, its largest, > 0; default 0.002 (dd-ert, lean-net: 0.004)"},
      {"schedule",
       "\"one-cycle\" (up over a tenth of the steps, down along a cosine; the default) or "
       "\"constant\""},
      {"slow_rate",
       "of the learning rate, for layers that begin as physics has them (the dense layer of "
       "dd-ert and lean-net), 0 ... 1; default 0.015 (lean-net: 0.3)"},
      {"freeze_statistics",
       "share of the steps after which batch normalisation uses its running statistics, 0 ... 1; "
       "default 0.6 (dd-ert: 0.4)"},
      {"precision",
       "of convolutions and dense layers in training: \"float32\" (the default) or \"bfloat16\", "
       "two to three times faster with AVX512-BF16"},
      {"device",
       "that it is trained on: \"cpu\", \"cuda\" or \"auto\", CUDA where there is one (the "
       "default; "
       "`--device` sets what auto means); images are made on the CPU"},
      {"symmetries", "whether scenes are turned by the sensor's symmetries; default true"},
      {"new_scenes", "whether every epoch draws scenes of its own; default false"},
      {"patience", "epochs without a better validation error before the training ends; default 20"},
      {"training_faults",
       "faults of the electronics put into training frames, {\"dead_electrodes\": [0, 4], "
       "\"dead_reading\": \"zero\" or \"floating\", \"gain_error\": [0, 0.1], \"offset\": [0, "
       "0.01]}, "
       "sizes uniform in these intervals; default none"},
      {"fault_share", "of the training frames have them, above 0 ... 1; default 0.5"}};
  own.insert(own.end(), shared.begin(), shared.end());
  return own;
}

const ParameterInfo relative_loss = {
    "loss", "\"mse\" (the default) or \"relative\" (mean relative error of a frame's change)"};

/// `parameters`: without those of the training. `probe`: settings of a small network of the type.
template <typename Learned>
void add(SolverRegistry& registry, std::string summary, std::vector<ParameterInfo> parameters,
         const std::string& probe) {
  SolverInfo info{std::move(summary), with_training(std::move(parameters)), make_from_json<Learned>,
                  ImageComparison::seeds};
  // Two epochs of four batches from the 64 scenes of a probe.
  info.probes = {R"({"epochs": 2, "batch": 16, "learning_rate": 0.004)" + probe + "}"};
  registry.add(Learned::type, std::move(info));
}

}  // namespace
}  // namespace ertbench

ERTBENCH_SOLVER_PLUGIN

extern "C" void ertbench_register_solvers(ertbench::SolverRegistry& registry) {
  using namespace ertbench;
  add<FcnnSolver>(registry, "fully connected network",
                  {{"widths", "of the hidden layers; default [2304, 576, 576]"},
                   relative_loss,
                   {"inference_precision",
                    "of the frozen network that images frames, \"float32\" (the default) or "
                    "\"bfloat16\": faster in batches",
                    ParameterRole::inference}},
                  R"(, "widths": [32, 32])");
  add<DcnnSolver>(
      registry, "convolutional network on the drive x measurement map",
      {{"widths", "channels of the three levels; default [64, 128, 256]"}, relative_loss},
      R"(, "widths": [4, 8, 8])");
  add<EitNnSolver>(
      registry,
      "EIT-NN (Park et al. 2021): dense layers, then convolutions; spatially blurred target",
      {{"dense_widths", "the last is the number of pixels; default [2304, 576, pixels]"},
       {"channels", "of the two convolutions; default [32, 64]"},
       {"loss",
        "\"ssa-mse\" (target blurred by the sensitivity; the default), \"mse\" or \"relative\""},
       {"sensitivity_lambda",
        "regularisation of that blur, > 0 or \"auto\" (the default), V per S/m"}},
      R"(, "dense_widths": [32, 576], "channels": [4, 4])");
  add<DdErtSolver>(
      registry,
      "DD-ERT (Zheng et al.): dense layer from the sensitivity, U-Net with spatial attention, "
      "trained against a PatchGAN discriminator (B1-B7)",
      {{"width", "feature maps of the U-Net at full resolution; default 24"},
       {"convolutions", "in each block; default 2"},
       {"attention", "on the two coarsest maps; default true"},
       {"attention_form",
        "\"spatial\" (B2; the default) or \"self\" (named in B.2.1's text; Zhang et al. 2019)"},
       {"initialisation",
        "of the dense layer: \"physics\" (the default), \"lmmse\", the linear estimate of least "
        "mean squared error from the training scenes, or \"random\""},
       {"train_dense", "whether that layer is trained; default true"},
       {"content_loss", "\"l1\" (B3; the default), \"mse\" (B6) or \"relative\""},
       {"alpha", "weight of the adversarial term, 0: no discriminator; default 0.001"},
       {"beta", "weight of the mask term (B5); default 0.1"},
       {"adversarial_form",
        "\"minimax\" (B4; the default), \"non-saturating\" or \"least-squares\""},
       {"discriminator_rate",
        "learning rate of the discriminator over that of the generator, > 0; default 0.1"},
       {"adversarial_every",
        "steps from one move of the game to the next, whose term then weighs as many times more; "
        "default 1"},
       {"spectral_norm",
        "whether the discriminator's convolutions are divided by their largest singular values "
        "(Miyato et al. 2018), in place of batch normalisation; default false"},
       {"instance_noise",
        "standard deviation (of y) of the noise on truths and images that the discriminator sees, "
        "falling to 0 over the training; default 0"},
       {"label_smoothing",
        "s of the label 1 - s that the discriminator is to give to truths, 0 ... 0.49; default 0"},
       {"mask_threshold", "y from which a pixel is in a contact; default 0.05"},
       {"discriminator_widths", "channels of its two hidden layers; default [64, 128]"}},
      R"(, "width": 4, "convolutions": 1, "discriminator_widths": [4, 8], "alpha": 0.1, "slow_rate": 0.3)");
  add<LeanNetSolver>(
      registry,
      "lean network: the linear estimate of least mean squared error, corrected by a residual "
      "network at half the image's resolution",
      {{"width", "feature maps at half the resolution; default 32"},
       {"blocks", "convolutions at half the resolution, on each side of the bottom; default 1"},
       {"bottom_blocks", "convolutions at a quarter of the resolution; default 4"},
       {"extra_maps", "maps that the dense layer makes beside the image; default 4"},
       {"output",
        "\"bounded\" to 0 ... 1 (y, by a sigmoid; the default) or \"linear\", a "
        "correction added to the linear estimate"},
       {"initialisation",
        "of the dense layer: \"lmmse\", the linear estimate of least mean squared error from the "
        "training scenes (the default), or \"random\""},
       {"loss", "\"relative\" (mean relative error of a frame's change; the default) or \"mse\""}},
      R"(, "width": 4, "bottom_blocks": 1)");
  SolverInfo script{
      "a module traced or scripted in PyTorch, channels -> pixels (docs/your_method.md)",
      {{"file", "the module (torch.jit.save), relative to the experiment; code, as a plugin is",
        ParameterRole::file},
       {"input",
        "what it is fed: \"change\" (dv, V; the default), \"training\" ((dv - mean) / standard "
        "deviation of the training set) or {\"mean\": ..., \"std\": ...}, numbers or lists of "
        "one for each channel, V"},
       {"output",
        "what it gives: \"change\" (of the conductivity, S/m; the default) or \"drop\" (1 - "
        "sigma / background)"},
       {"precision", "\"float32\" (the default) or \"float64\""},
       {"seed", "of the training that made the file; \"{seed}\" in the file's name stands for it",
        ParameterRole::seed}},
      make_from_json<TorchScriptSolver>};
  script.probes = {};  // its file is part of the key
  registry.add(TorchScriptSolver::type, std::move(script));
}
