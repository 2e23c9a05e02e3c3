#pragma once

#include <optional>
#include <span>

#include "bench/record/result_row.h"
#include "bench/score/metrics.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// Why a number may come out differently on another machine, or from another build.
enum class ToleranceClass {
  /// The truth and the empty image, which involve no solver: only metrics round.
  exact,
  /// A linear image (ImageComparison::rounding): FMA and other kernels change the last bits of
  /// voltages and matrix, and the means by 1e-15 to 1e-13. An "auto" parameter keeps its value to
  /// 1e-14, because the errors that its choice compares differ by more. With the tolerance of
  /// stored images also a solver that is loaded ("checkpoint"), whatever it is.
  linear,
  /// An iteration that stops when a duality gap falls below a tolerance: last bits may move the end
  /// of a frame to the iterate before or after.
  interior_point,
  /// A trained solver: last bits grow into another network, like another seed.
  seeds,
};

struct Tolerance {
  ToleranceClass type = ToleranceClass::exact;
  /// Relative change of a mean over frames; for seeds the smallest standard deviation assumed.
  double relative = 0;

  bool operator==(const Tolerance&) const = default;
};

/// The row's tolerance. `images`: the comparison registered for its solver; nothing without one.
Tolerance tolerance_of(const ResultRow& row, std::optional<ImageComparison> images);

/// A baseline's mean over frames of one metric.
struct BaselineMean {
  Metric metric = Metric::AR;
  std::span<const double> values;         ///< one, or one for each seed
  int frames = 1;                         ///< of the test set
  Sensor sensor = {};                     ///< of the images
  std::optional<double> resolution = {};  ///< the row's mean RES, %
};

/// The mean of `values`, with which a new value is compared.
double centre_of(std::span<const double> values);

/// Half the width of the interval of a check's mean over `seeds_now` trainings around that of a
/// baseline over `seeds_before`, in standard deviations of one training.
double seeds_interval(int seeds_before, int seeds_now);

/// Largest allowed distance of today's mean over `seeds_now` trainings from the centre of `before`.
///
/// - seeds: the prediction interval t s sqrt(1/seeds_now + 1/n) for new seeds from n old ones, with
///   s their standard deviation and t Student's quantile with n - 1 degrees of freedom at 99.9 %.
///   Without changes, today's trainings on the same kind of processor equal the old ones; on
///   another one rounding grows into other networks, which count as new seeds. Four networks with
///   sixteen metrics are 64 intervals, so a sound machine is refused in at most 3.2 % of the checks
///   (64 times 0.05 %, one-sided; less, as metrics of a network are correlated). At 99 % it would
///   be every fourth. Deviations of different networks are not pooled: they differ by up to ten
///   times.
/// - others: `relative` of the value or `relative` (at most 1e-8) of the metric's unit, whichever
/// is
///   larger: a centroid 1e-8 from the truth is as exact as one 1 from it.
/// - metrics with a threshold allow one pixel of one frame to cross it (none for the truth). For an
///   area in per cent that is 100 / (sqrt(pixels of the sheet) frames), the largest effect of a
///   pixel in (C2), when it is the second one. For a centroid it is diagonal / (2 pixels frames):
///   the pixel weighs a quarter of the largest, the bright ones (their number follows from the mean
///   RES) at least half of it each, and it is at most the sheet's diagonal away. A pixel may also
///   create or remove a contact: metrics of contacts allow one contact in one frame, 1 / frames or
///   a quarter of the side over the frames; with seeds too, whose means of a count are often all 0.
double allowed_change(const Tolerance& tolerance, const BaselineMean& before, int seeds_now = 1);

/// One-sided p value of the exact rank-sum test (Wilcoxon, Mann and Whitney) of `now` against
/// `before`, on the side on which the rank sum lies, with mid-ranks for ties; 1/2 or more if
/// nothing differs. Both must have values.
double rank_sum_chance(std::span<const double> before, std::span<const double> now);

struct TodaysMean {
  double mean = 0;
  std::span<const std::optional<double>> seeds = {};  ///< of each training of a trained solver

  int trainings() const { return seeds.empty() ? 1 : static_cast<int>(seeds.size()); }
};

/// True if today's mean differs from that of `before` by more than allowed_change().
///
/// Metrics of contacts with seeds must also differ by ranks. False positives and misses are rare,
/// and a training with many is rarer still: eight of dcnn in the quick experiment have false
/// positives in 3, 4, 4, 5, 5, 5, 6 and 20 of 200 frames. If none of the old trainings is like the
/// last, their deviation does not cover it, and one such training today would count as a worsening
/// of all. The rank sum's distribution does not depend on that of the values; its p value must be
/// at most 0.05 %, as one side of the interval, or the smallest possible for so many trainings. A
/// change in a few trainings only is noticed by the metrics of the image instead.
bool is_beyond(const Tolerance& tolerance, const BaselineMean& before, const TodaysMean& now);

/// Factor on a frame's time in units of calibration_us() beyond which it counts as slower, or its
/// inverse as better: the root of 1.5. Over 20 repetitions on two cores shared with ten other
/// processes the values of one solver lay within 1.21 of each other
/// (tests/data/latency_rounds.json), less than the root; and a solver that takes 1.5 times as long
/// exceeds the root, whichever of these values the baseline had.
inline constexpr double allowed_slow_down = 1.2247;
/// Factor for a frame of a batch, known only as the median of the rounds, which on busy cores is up
/// to 1.8 times that on idle ones.
inline constexpr double allowed_batch_slow_down = 3;

/// Relative change of one stored frame's image (2-norm), in float32. Kernels for other processors
/// (OpenBLAS for Haswell and Prescott, libtorch and oneDNN without AVX) change stored images by up
/// to 9e-7; a hundred times that is still far less than any change of a network.
inline constexpr double stored_image_tolerance = 1e-4;

/// Relative change after a short training (short_trainings): fifty times the effect of other
/// kernels.
inline constexpr double short_training_tolerance = 1e-2;

}  // namespace ertbench
