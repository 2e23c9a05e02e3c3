#pragma once

#include <cstdint>
#include <vector>

#include "solvers/export/layer_program.h"

namespace ertbench {

/// A program in integers: weights of 8 bits, each output's with a step of its own, numbers between
/// the layers of 16 bits, each value's with a step of its own, and sums of 32 bits that cannot
/// overflow.
struct QuantisedProgram {
  struct Value {
    double step = 1;  ///< of one count
    int most = 0;     ///< largest count
  };
  struct Step {
    std::vector<std::int8_t> weights;  ///< as ExportStep::weights
    std::vector<std::int32_t> bias;
    /// Of the sums, 2^-32; of a join's inputs, and the slopes of a prelu, 2^-16.
    std::vector<std::int32_t> factors;
    std::vector<std::int32_t> added;  ///< factors of the counts that are added; may be empty
  };
  int bits = 0;  ///< of the counts that layers write, without the sign
  std::vector<Value> values;
  std::vector<Step> steps;
};

/// `ranges`: largest absolute number of each value (ExportProgram::ranges).
QuantisedProgram quantise(const ExportProgram& program, std::vector<double> ranges);

}  // namespace ertbench
