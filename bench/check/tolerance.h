#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/record/result_row.h"
#include "bench/score/metrics.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// Why a number may come out differently on another machine, or from another build.
enum class ToleranceClass {
  /// The truth and the image of nothing, which no solver has touched: the rounding of the metrics.
  exact,
  /// An image that depends on the frame as on a fixed matrix (ImageComparison::rounding): FMA and
  /// other kernels change the last bits of voltages and matrix, and the means by 1e-15 to
  /// 1e-13. A parameter "auto" keeps its value to 1e-14: the errors that its choice compares are
  /// further apart.
  linear,
  /// Stops where a duality gap falls below a tolerance; last bits decide on which side of it an
  /// iterate lies, so that a frame may end with the iterate before or after.
  interior_point,
  /// Trained: last bits grow into another network, as another seed would give.
  seeds,
};

/// "exact", "linear", "interior point", "seeds".
const char* name_of(ToleranceClass type);
std::vector<std::string> tolerance_class_names();
/// The inverse. Throws std::invalid_argument for another name.
ToleranceClass tolerance_class_from_name(const std::string& name);

struct Tolerance {
  ToleranceClass type = ToleranceClass::exact;
  /// Of a mean over frames, relative; for seeds the least standard deviation that is believed.
  double relative = 0;

  bool operator==(const Tolerance&) const = default;
};

/// What the row's numbers are held to; `images`: how those of its solver are compared, none where
/// no solver has touched them.
Tolerance tolerance_of(const ResultRow& row, std::optional<ImageComparison> images);

/// The mean over frames of one metric, as the baseline has it.
struct BaselineMean {
  Metric metric = Metric::AR;
  std::span<const double> values;         ///< one, or one for each seed
  int frames = 1;                         ///< of the test set
  Sensor sensor = {};                     ///< whose images the frames are
  std::optional<double> resolution = {};  ///< the row's mean RES, %
};

/// The mean of `values`: what a new value is compared with.
double centre_of(std::span<const double> values);

/// Half the width of the interval of a check's mean over `seeds_now` trainings around that of a
/// baseline over `seeds_before`, in standard deviations of one training.
double seeds_interval(int seeds_before, int seeds_now);

/// How far today's value, the mean over `seeds_now` trainings, may lie from the centre of `before`.
///
/// - seeds: the prediction interval t s sqrt(1/seeds_now + 1/n) for new seeds from n old ones, s
///   their standard deviation, t Student's quantile with n - 1 degrees of freedom at 99.9 %. Where
///   nothing changed on the same kind of processor, today's trainings are the old ones and the
///   difference is as good as 0; elsewhere rounding grows into other networks, and they count as
///   new seeds. Then four networks with sixteen metrics are 64 such intervals, and a sound machine
///   is refused in 3.2 % of the checks at most (64 times 0.05 %, worse being on one side; less, as
///   the metrics of a network move together). At 99 % it would be every fourth. The deviations of
///   different networks are not pooled: those of one metric differ by up to ten times.
/// - all others: `relative` of the value, or `relative` (at most 1e-8) of the metric's own unit
///   where that is more: a centroid 1e-8 from the truth is as exact as one 1 from it.
/// - metrics with a threshold let one pixel of one frame change sides of it (none of the truth):
///   100 / (sqrt(pixels of the sheet) frames) for an area in per cent, the most that a pixel is
///   worth in (C2), where it is the second one; diagonal / (2 pixels frames) for a centroid: the
///   pixel weighs a quarter of the largest, the bright ones (as many as the mean RES says) at least
///   half of it each, and it is at most the sheet's diagonal from them. A pixel may also make a
///   contact, or end one: metrics of contacts have room for one in one frame, 1 / frames or a
///   quarter of the side over the frames, with seeds too, whose means of a count are often all 0.
double allowed_change(const Tolerance& tolerance, const BaselineMean& before, int seeds_now = 1);

/// The chance that, of values in no order, those of `now` have ranks whose sum is as far to the
/// side on which it lies, or farther: the exact distribution of the rank sum of Wilcoxon, Mann and
/// Whitney, equal values sharing their ranks. 1/2 and more where nothing differs. Both must have
/// values.
double rank_sum_chance(std::span<const double> before, std::span<const double> now);

/// The mean over frames of today.
struct TodaysMean {
  double mean = 0;
  std::span<const std::optional<double>> seeds = {};  ///< of each training of a trained solver

  int trainings() const { return seeds.empty() ? 1 : static_cast<int>(seeds.size()); }
};

/// Whether today's mean lies beyond allowed_change() of that of `before`.
///
/// Metrics of contacts with seeds need the ranks of the trainings as a second witness. A ghost or a
/// miss is rare, and a training that has many is rarer still: of eight of dcnn's in the quick
/// experiment, ghosts in 3, 4, 4, 5, 5, 5, 6 and 20 of 200 frames. Where the old trainings have
/// none like the last, their deviation says nothing about it, and one of today's would be called a
/// worsening of all. A rank sum has the same distribution whatever that of the values is; its
/// chance must be at most what the interval leaves on one side, 0.05 %, or the smallest that so
/// many trainings can have. A change that shows in few of the trainings is not noticed by these
/// metrics, but by those of the image.
bool is_beyond(const Tolerance& tolerance, const BaselineMean& before, const TodaysMean& now);

/// How much more of calibration_us() one frame may take before it counts as slower, and how much
/// less before it counts as better: the root of 1.5. Over 20 repetitions on two cores that ten
/// other processes shared, the values of one solver lay within 1.21 of each other
/// (tests/data/latency_rounds.json), so that noise is less than the root; and a solver that takes
/// 1.5 times as long exceeds the root, whichever of these the baseline had.
inline constexpr double allowed_slow_down = 1.2247;
/// The same for a frame of a batch, of which the median of the rounds is all there is: on busy
/// cores up to 1.8 times that of idle ones.
inline constexpr double allowed_batch_slow_down = 3;

/// Relative change of one stored frame's image (2-norm), in float32. The kernels for other
/// processors (OpenBLAS for Haswell and Prescott, libtorch and oneDNN without AVX) change the
/// stored images by up to 9e-7; a hundred times that is still far less than any change of a
/// network.
inline constexpr double stored_image_tolerance = 1e-4;

/// The same after a short training (short_trainings): fifty times what other kernels make of it.
inline constexpr double short_training_tolerance = 1e-2;

}  // namespace ertbench
