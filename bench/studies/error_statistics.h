#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/table/table.h"
#include "core/statistics.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// A statistic with its 95 % interval.
struct Estimate {
  double value = 0;
  Interval ci95;

  /// A number that was not estimated and has no interval: NaN at both ends.
  static Estimate exact(double value);
};

/// Without its interval.
std::optional<double> value_of(const std::optional<Estimate>& estimate);
std::optional<Estimate> scaled(std::optional<Estimate> estimate, double factor);
/// `{"value", "ci95": [low, high]}`, the first by the name `key`; or null.
nlohmann::json to_json(const std::optional<Estimate>& estimate, const char* key = "value");
nlohmann::json to_json(const std::optional<double>& value);  ///< null where there is none
/// "4.12" and below it "[3.98, 4.31]"; a dash where there is none.
Cell estimate_cell(const std::optional<Estimate>& estimate, int decimals);
/// Three cells of a CSV file: the value and the ends of its interval, empty where there is none.
std::vector<Cell> exact_cells(const std::optional<Estimate>& estimate);

/// Errors that come in groups, such as those of the frames at one place, which share its bias.
class GroupedErrors {
 public:
  explicit GroupedErrors(std::size_t groups) : groups_(groups) {}

  void add(std::size_t group, double error) { values_.push_back({error, group}); }

  // Nothing where there is no error. Intervals by the bootstrap over the groups that have errors;
  // `name` keys their random numbers.
  std::optional<Estimate> mean(std::string_view name) const;
  /// The smallest error that at least that share of the errors does not exceed.
  std::optional<Estimate> quantile(double share, std::string_view name) const;
  std::optional<double> worst() const;

 private:
  struct Value {
    double error;
    std::size_t group;
  };

  /// A copy without the groups that have no error.
  GroupedErrors compact() const;

  std::size_t groups_;
  std::vector<Value> values_;
};

}  // namespace ertbench

/// Shares of successes against a quantity that they grow with: detection against force.
namespace ertbench {

/// An observation of a curve.
struct WeightedPoint {
  double x = 0;
  double y = 0;
  double weight = 1;
};

/// Observations that share their value in an isotonic fit.
struct IsotonicBlock {
  double first = 0;  ///< least x
  double last = 0;   ///< largest x
  double value = 0;
  double weight = 0;  ///< sum
};

/// The non-decreasing curve of least weighted squares through points by ascending x, by pooling
/// adjacent violators (Ayer et al. 1955); equal x share a block. Between two blocks the curve is
/// taken to be straight. Points without weight do not enter.
std::vector<IsotonicBlock> isotonic_fit(std::span<const WeightedPoint> points);

/// A share of which so many were counted, with Wilson's interval; nothing of none.
struct CountedShare {
  int count = 0;
  int total = 0;

  void add(bool counted) {
    count += counted;
    ++total;
  }
  std::optional<Estimate> share() const;
};

struct Trial {
  double value = 0;  ///< what success grows with
  bool success = false;
  std::size_t group = 0;  ///< trials of a group are drawn together: the frames of a scene
};

/// Trials that follow each other in their values.
struct ShareBin {
  double low = 0;   ///< the least value
  double high = 0;  ///< the largest
  CountedShare successes;
};

/// At most `bins` bins of equally many trials, twenty or more, the least values first.
std::vector<ShareBin> share_bins(std::vector<Trial> trials, int bins);

/// The value from which on the share of successes reaches a given one.
struct LeastFound {
  double value = 0;
  Interval ci95;  ///< by the bootstrap over groups
  /// From the mean of the twenty least values, where a value stands for "here or before", to the
  /// largest, beyond which a value stands for "nowhere".
  Interval reach;
};

/// By isotonic regression (pool adjacent violators, Ayer et al. 1955) of the success on the value,
/// in bins of twenty trials, as one in twenty is the least that a share of 95 % can tell, with
/// straight lines between the bins. Nothing of fewer than two bins.
std::optional<LeastFound> least_found(std::vector<Trial> trials, double share,
                                      const std::string& name);

}  // namespace ertbench

/// The areas x areas equal rectangles into which D.2 and D.5 of the paper divide a sheet. Area 0 is
/// at the least x and y; the areas of a row, along x, follow each other.
namespace ertbench {

/// The area in which a place lies, mm from the origin of the domain units; of places beyond the
/// bounds of the sheet the nearest.
int area_of(const Sheet& sheet, const Eigen::Vector2d& place_mm, int areas = 5);

/// [areas²] the orbit of each area, from 0: the symmetries of the sheet take the areas of an orbit
/// into each other, so that a touch should be felt alike in all of them. Outer rings are counted
/// first, and in a ring what is farther from the middle: of the square's 5 x 5 areas corners (4),
/// beside the corners (8), edge middles (4), inner diagonal (4), inner straight (4), centre (1).
std::vector<int> area_orbits(const Sheet& sheet, int areas = 5);

/// The name of an orbit: "I" of 0, "II" of 1, ... Throws std::invalid_argument below 0.
std::string roman(int orbit);

}  // namespace ertbench
