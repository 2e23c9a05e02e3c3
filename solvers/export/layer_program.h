#pragma once

#include <cstddef>
#include <vector>

#include "core/arrays.h"
#include "core/layers.h"

namespace ertbench {

inline std::size_t index_of(int i) { return static_cast<std::size_t>(i); }

/// One call of the exported code. Maps lie as [row][column][channel], and a vector is one pixel.
struct ExportStep {
  enum class Kind {
    sums_of_pairs,
    gather,
    convolve,
    prelu,
    pool,
    join,
    shuffle,
    sigmoid,
    summarise,
    weigh,
    mixture
  };

  Kind kind = Kind::convolve;
  std::vector<int> inputs = {};  ///< values
  int value = 0;                 ///< that it writes
  int added = -1;                ///< value that a convolution adds
  int outputs = 0;
  int kernel = 1;
  int stride = 1;
  int padding = 0;
  int spread = 1;  ///< output (r, c) is pixel (spread r + row, spread c + column)
  int row = 0;
  int column = 0;
  bool relu = false;
  std::vector<float> weights = {};  ///< [outputs][kernel][kernel][inputs], slopes of a prelu;
                                    ///< with the bias, of a mixture as Layer has them
  std::vector<float> bias = {};     ///< [outputs]
  std::vector<int> indices = {};    ///< pairs, or of a gather
};

/// The layers of a solver in the order and the memory of the exported code.
class ExportProgram {
 public:
  struct Value {
    int channels = 1;
    int rows = 1;
    int columns = 1;
    int place = 0;  ///< of its first number in the memory

    int pixels() const { return rows * columns; }
    int size() const { return channels * pixels(); }
  };

  /// Throws InputError for layers that are not exported.
  explicit ExportProgram(const LayerList& list);

  const std::vector<ExportStep>& steps() const { return steps_; }
  const std::vector<Value>& values() const { return values_; }
  const Value& value(int index) const { return values_[static_cast<std::size_t>(index)]; }
  /// Rows and columns of a convolution's sums, before they are spread.
  int sum_rows(const ExportStep& step) const;
  int sum_columns(const ExportStep& step) const;
  int output() const { return output_; }
  int memory() const { return memory_; }  ///< numbers
  /// Of its input as in LayerList; never empty, and of what a front tells 0 and 1.
  const std::vector<float>& shift() const { return shift_; }
  const std::vector<float>& scale() const { return scale_; }
  double unit() const { return unit_; }
  bool is_standardised() const { return standardised_; }

  /// Gives the input of a linear method, which is in V, the scale that the pairs of channels have
  /// in `changes` [frames, channels], so that each is resolved as well as the others.
  void equalise_input(const Frames& changes);
  /// Largest absolute number of each value over frames, behind whose channels stands what a front
  /// tells; of what a sigmoid makes, before it.
  std::vector<double> ranges(const Frames& changes) const;

 private:
  int add_value(int channels, int rows, int columns);
  void add(const Layer& layer);
  void add_slopes(const Layer& layer);
  void add_dense(const Layer& layer);
  void add_convolution(const Layer& layer, std::vector<float> weights, int padding);
  void add_spread(const Layer& layer);
  void add_attention(const Layer& layer);
  void add_maps(const Layer& layer);
  bool can_merge(const ExportStep& dense, const ExportStep& next) const;
  void merge(std::size_t index);
  void place_values();
  void run(std::vector<std::vector<float>>& numbers) const;

  std::vector<Value> values_;
  std::vector<int> value_of_;  ///< of each value of the list
  std::vector<bool> doubled_;  ///< values that are sums where the list has means
  std::vector<ExportStep> steps_;
  int output_ = 0;
  int memory_ = 0;
  bool standardised_;
  std::vector<float> shift_;
  std::vector<float> scale_;
  double unit_;
};

/// One output pixel of a convolution of `numbers`: the sum over the part of the kernel that lies on
/// the maps.
float window_sum(const ExportStep& step, const ExportProgram::Value& from,
                 const std::vector<float>& numbers, int output, int row, int column);

}  // namespace ertbench
