#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "models/inference/map_layout.h"

namespace ertbench {

/// One layer of a plan, with its weights as its kernel wants them.
class PlanStep {
 public:
  virtual ~PlanStep() = default;
  /// Called once, when it is known where the maps stand.
  virtual void prepare(Layouts layouts) = 0;
  virtual void run(float* workspace) const = 0;
};

/// A network laid out for the inference of single frames: a list of steps on buffers that are
/// allocated beforehand. Made by a PlanBuilder.
class InferencePlan {
 public:
  InferencePlan(std::vector<std::unique_ptr<PlanStep>> steps, const MapLayout& input,
                const MapLayout& output, std::ptrdiff_t workspace);
  ~InferencePlan();

  /// `input` [inputs], `output` [outputs], a planar map row by row. Thread-safe; each thread that
  /// is in here at a time has a workspace of its own, which is allocated when there is none left.
  void run(const float* input, float* output) const;

 private:
  class Workspace;
  std::unique_ptr<Workspace> take() const;
  void give_back(std::unique_ptr<Workspace> workspace) const;

  std::vector<std::unique_ptr<PlanStep>> steps_;
  MapLayout input_;
  MapLayout output_;
  std::ptrdiff_t size_;  ///< of a workspace, floats
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> free_;
};

}  // namespace ertbench
