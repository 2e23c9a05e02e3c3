#include "models/inference/inference_plan.h"

#include <algorithm>
#include <cstdlib>
#include <new>

namespace ertbench {

/// Zeros at first; borders and unused lanes stay so.
class InferencePlan::Workspace {
 public:
  explicit Workspace(std::ptrdiff_t size)
      : numbers_(static_cast<float*>(std::aligned_alloc(64, bytes_of(size)))) {
    if (!numbers_) throw std::bad_alloc();
    std::fill_n(numbers_.get(), bytes_of(size) / sizeof(float), 0.0F);
  }
  float* numbers() const { return numbers_.get(); }

 private:
  struct Free {
    void operator()(float* numbers) const { std::free(numbers); }
  };
  static std::size_t bytes_of(std::ptrdiff_t size) {
    return (static_cast<std::size_t>(size) * sizeof(float) + 63) / 64 * 64;
  }

  std::unique_ptr<float, Free> numbers_;
};

InferencePlan::InferencePlan(std::vector<std::unique_ptr<PlanStep>> steps, const MapLayout& input,
                             const MapLayout& output, std::ptrdiff_t workspace)
    : steps_(std::move(steps)), input_(input), output_(output), size_(workspace) {
  free_.push_back(std::make_unique<Workspace>(size_));
}

InferencePlan::~InferencePlan() = default;

std::unique_ptr<InferencePlan::Workspace> InferencePlan::take() const {
  {
    const std::lock_guard lock(mutex_);
    if (!free_.empty()) {
      std::unique_ptr<Workspace> workspace = std::move(free_.back());
      free_.pop_back();
      return workspace;
    }
  }
  return std::make_unique<Workspace>(size_);
}

void InferencePlan::give_back(std::unique_ptr<Workspace> workspace) const {
  const std::lock_guard lock(mutex_);
  free_.push_back(std::move(workspace));
}

void InferencePlan::run(const float* input, float* output) const {
  std::unique_ptr<Workspace> workspace = take();
  float* const numbers = workspace->numbers();
  std::copy_n(input, input_.width, numbers + input_.channel(0));
  for (const auto& step : steps_) step->run(numbers);
  for (int channel = 0; channel < output_.channels; ++channel) {
    const float* row = numbers + output_.channel(channel);
    for (int y = 0; y < output_.height; ++y, row += output_.row(), output += output_.width) {
      std::copy_n(row, output_.width, output);
    }
  }
  give_back(std::move(workspace));
}

}  // namespace ertbench
