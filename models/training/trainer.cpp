#include "models/training/trainer.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <future>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/files.h"
#include "core/lists.h"
#include "core/seconds.h"
#include "models/networks/torch_runtime.h"
#include "models/training/adam.h"
#include "models/training/checkpoint.h"
#include "models/training/objective.h"

namespace ertbench {

nlohmann::json to_json(const TrainingResult& result) {
  nlohmann::json out = {{"status", result.report.status},
                        {"message", result.report.message},
                        {"earlier_s", result.report.earlier_s},
                        {"epochs", result.epochs},
                        {"best_epoch", result.best_epoch},
                        {"validation_error", result.validation_error},
                        {"seconds", result.seconds}};
  if (!result.converged) out["converged"] = false;
  return out;
}

TrainingResult training_result_from_json(const nlohmann::json& json) {
  TrainingResult out;
  out.report = {json.at("status"), json.at("message"), json.value("earlier_s", 0.0)};
  out.epochs = json.at("epochs");
  out.best_epoch = json.at("best_epoch");
  out.converged = json.value("converged", true);
  out.validation_error = json.at("validation_error");
  out.seconds = json.at("seconds");
  return out;
}

namespace {

namespace fs = std::filesystem;

/// A network whose images differ by less between any two frames has collapsed.
constexpr double least_spread = 1e-4;
constexpr double warm_up_share = 0.1;
constexpr double last_rate = 1e-3;  ///< of the largest

/// The batches of an epoch in their order, on the device of the training.
class BatchStream {
 public:
  /// `scenes` outlives it, and begins no other epoch meanwhile.
  BatchStream(const TrainingSet& scenes, std::uint64_t batch, std::uint64_t batches,
              const TrainingPlace& on)
      : scenes_(scenes), batch_(batch), batches_(batches), on_(on) {}

  /// At most `batches` times.
  TrainingBatch next() {
    if (!on_.ahead) return drawn(next_++);
    TrainingBatch batch = ahead_.valid() ? ahead_.get() : drawn(next_);
    if (++next_ < batches_) {
      ahead_ = std::async(std::launch::async, [this, index = next_] { return drawn(index); });
    }
    return batch;
  }

 private:
  TrainingBatch drawn(std::uint64_t index) const {
    const TrainingBatch batch = scenes_.batch(index * batch_, batch_, on_.threads);
    return {batch.frames.to(on_.device), batch.truths.to(on_.device)};
  }

  const TrainingSet& scenes_;
  std::uint64_t batch_;
  std::uint64_t batches_;
  TrainingPlace on_;
  std::uint64_t next_ = 0;
  std::future<TrainingBatch> ahead_;
};

/// Learning rate of one step: a linear rise, then a cosine decay.
double one_cycle_rate(double largest, std::uint64_t step, std::uint64_t steps) {
  const double place = (static_cast<double>(step) + 1) / static_cast<double>(steps);
  if (place < warm_up_share) return largest * place / warm_up_share;
  const double fall = (place - warm_up_share) / (1 - warm_up_share);
  return largest * (last_rate + (1 - last_rate) * (1 + std::cos(std::numbers::pi * fall)) / 2);
}

std::vector<std::string> log_columns(const Objective& objective) {
  std::vector<std::string> columns = {"epoch", "loss"};
  for (const std::string& term : objective.terms()) columns.push_back(term);
  for (const char* column : {"validation_error", "learning_rate", "seconds"}) {
    columns.emplace_back(column);
  }
  return columns;
}

void write_log(const RowMajorMatrix& log, const Objective& objective, const fs::path& folder) {
  const auto write = [&](const fs::path& aside) {
    std::ofstream out(aside);
    const Eigen::IOFormat csv(9, Eigen::DontAlignCols, ",", "\n");
    out << joined(log_columns(objective), ",") << "\n" << log.format(csv) << "\n";
    out.close();
    if (!out) throw InputError(aside.string() + ": cannot be written; is the disk full?");
  };
  replace_file(folder / "training.csv", write, folder / "training.csv.part");
}

/// State of a training between two epochs.
class Training {
 public:
  Training(Network& network, Objective& objective, TrainingSet& scenes,
           const ValidationSet& validation, const TrainingSettings& settings,
           const TrainingOutlet& outlet)
      : network_(network),
        objective_(objective),
        scenes_(scenes),
        validation_(validation),
        settings_(settings),
        outlet_(outlet),
        batch_(std::min<std::uint64_t>(static_cast<std::uint64_t>(settings.batch), scenes.size())),
        steps_per_epoch_(scenes.size() / batch_),
        mask_(on_device(scenes.mask(), outlet.on.device)),
        optimiser_(parameter_groups(network)),
        log_(0, std::ssize(log_columns(objective))) {
    result_.validation_error = std::numeric_limits<double>::infinity();
  }

  TrainingResult run() {
    resume();
    while (!done() && epoch()) {
    }
    fs::remove(checkpoint_file());
    if (result_.best_epoch == 0) {
      throw std::runtime_error("the training diverged: " + result_.report.message +
                               "; lower \"learning_rate\"");
    }
    copy_values(best_, weights_of(network_));
    result_.converged = result_.best_epoch < settings_.epochs;
    return result_;
  }

 private:
  fs::path checkpoint_file() const { return outlet_.folder / "checkpoint.h5"; }

  bool done() const {
    return result_.epochs >= settings_.epochs ||
           result_.epochs - result_.best_epoch >= settings_.patience;
  }

  /// Steps of the whole training, unless it ends early.
  std::uint64_t steps() const {
    return steps_per_epoch_ * static_cast<std::uint64_t>(settings_.epochs);
  }

  double set_learning_rate(std::uint64_t step) {
    const double rate = settings_.one_cycle ? one_cycle_rate(settings_.learning_rate, step, steps())
                                            : settings_.learning_rate;
    optimiser_.set_rate(0, rate);
    optimiser_.set_rate(1, rate * settings_.slow_rate);
    objective_.set_learning_rate(rate);
    return rate;
  }

  void show(std::uint64_t steps_done) {
    if (!outlet_.progress || seconds_since(shown_) < outlet_.progress_interval_s) return;
    shown_ = SteadyClock::now();
    std::string text =
        "epoch " + std::to_string(result_.epochs + 1) + " of " + std::to_string(settings_.epochs);
    if (result_.best_epoch > 0) {
      char error[64];
      std::snprintf(error, sizeof error, ", validation error %.3f", result_.validation_error);
      text += error;
    }
    outlet_.progress(steps_done, steps(), text);
  }

  torch::Tensor images_of(const torch::Tensor& frames) {
    const ReducedPrecision precision(settings_.bfloat16, outlet_.on.device);
    return network_.forward(frames).to(torch::kFloat32);
  }

  /// Trains and validates for an epoch; false if the loss was not finite.
  bool epoch() {
    const SteadyClock::time_point start = SteadyClock::now();
    const auto number = static_cast<std::uint64_t>(result_.epochs);
    scenes_.begin_epoch(number);
    network_.train();
    std::vector<double> sums(1 + objective_.terms().size(), 0.0);
    double rate = 0;
    const auto frozen_from = static_cast<std::uint64_t>(
        settings_.freeze_statistics * settings_.epochs * static_cast<double>(steps_per_epoch_));
    BatchStream batches(scenes_, batch_, steps_per_epoch_, outlet_.on);
    for (std::uint64_t i = 0; i < steps_per_epoch_; ++i) {
      const std::uint64_t step = number * steps_per_epoch_ + i;
      rate = set_learning_rate(step);
      objective_.begin_step(step, steps());
      if (step >= frozen_from) freeze_statistics(network_);
      const TrainingBatch batch = batches.next();
      std::vector<double> terms(objective_.terms().size());
      const torch::Tensor loss =
          objective_.loss(masked(images_of(batch.frames), mask_), batch.truths, terms);
      const double value = loss.item<double>();
      if (!std::isfinite(value)) {
        set_status("diverged", "the loss is not finite in epoch " + std::to_string(number + 1) +
                                   ", step " + std::to_string(i + 1));
        return false;
      }
      optimiser_.zero_grad();
      loss.backward();
      optimiser_.step();
      sums[0] += value;
      for (std::size_t t = 0; t < terms.size(); ++t) sums[t + 1] += terms[t];
      show(step + 1);
    }
    finish_epoch(sums, rate, start);
    return true;
  }

  void finish_epoch(const std::vector<double>& sums, double rate, SteadyClock::time_point start) {
    const ValidationSet::Score score = validation_.score(network_, outlet_.on.device);
    ++result_.epochs;
    judge(score);
    if (score.error < result_.validation_error) {
      result_.validation_error = score.error;
      result_.best_epoch = result_.epochs;
      best_ = copies(weights_of(network_));
    }
    std::vector<double> row = {static_cast<double>(result_.epochs)};
    for (const double sum : sums) row.push_back(sum / static_cast<double>(steps_per_epoch_));
    row.insert(row.end(), {score.error, rate, seconds_since(start)});
    log_.conservativeResize(log_.rows() + 1, Eigen::NoChange);
    log_.bottomRows(1) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), std::ssize(row));
    result_.seconds += seconds_since(start);
    write_log(log_, objective_, outlet_.folder);
    const bool due = seconds_since(saved_) >= outlet_.checkpoint_interval_s;
    if (due && !done() && result_.best_epoch > 0) save();
  }

  void set_status(const std::string& status, const std::string& message) {
    result_.report.status = status;
    result_.report.message = message;
  }

  void judge(const ValidationSet::Score& score) {
    set_status("ok", "");
    const std::string when = "after epoch " + std::to_string(result_.epochs);
    if (const auto collapse = objective_.collapse()) set_status(*collapse, when);
    if (score.spread < least_spread) {
      set_status("generator collapsed", "one image for all frames " + when);
    }
  }

  Checkpoint state() const {
    return {.result = result_,
            .log = log_,
            .network = weights_of(network_),
            .best = best_,
            .optimiser = optimiser_.state(),
            .objective = objective_.state()};
  }

  void save() {
    saved_ = SteadyClock::now();
    fs::path aside = checkpoint_file();
    replace_file(
        checkpoint_file(), [&](const fs::path& to) { write_checkpoint(to, state()); },
        aside += ".part");
  }

  void resume() {
    if (!fs::exists(checkpoint_file())) return;
    Checkpoint expected = state();
    expected.best = expected.network;
    Checkpoint found;
    try {
      found = read_checkpoint(checkpoint_file(), expected);
    } catch (const std::exception& error) {
      spdlog::warn("{}; the training begins anew", error.what());
      return;
    }
    result_ = found.result;
    result_.report.earlier_s = result_.seconds;
    log_ = found.log;
    copy_values(found.network, weights_of(network_));
    best_ = std::move(found.best);
    optimiser_.set_state(found.optimiser);
    objective_.set_state(found.objective);
  }

  Network& network_;
  Objective& objective_;
  TrainingSet& scenes_;
  const ValidationSet& validation_;
  const TrainingSettings& settings_;
  const TrainingOutlet& outlet_;
  std::uint64_t batch_;
  std::uint64_t steps_per_epoch_;
  torch::Tensor mask_;  ///< see sheet_mask
  Adam optimiser_;
  RowMajorMatrix log_;  ///< [epochs, columns]
  TrainingResult result_;
  NamedTensors best_;  ///< weights of the best epoch; empty before the first
  SteadyClock::time_point saved_ = SteadyClock::now();
  SteadyClock::time_point shown_ = SteadyClock::now();
};

}  // namespace

TrainingResult train(Network& network, Objective& objective, TrainingSet& scenes,
                     const ValidationSet& validation, const TrainingSettings& settings,
                     const TrainingOutlet& outlet) {
  network.to(outlet.on.device);
  objective.to(outlet.on.device);
  TrainingResult result = Training(network, objective, scenes, validation, settings, outlet).run();
  network.to(torch::kCPU);
  return result;
}

}  // namespace ertbench
