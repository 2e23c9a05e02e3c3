#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "bench/table/table.h"
#include "core/interval.h"

namespace ertbench {

/// A statistic with its 95 % interval.
struct Estimate {
  double value = 0;
  Interval ci95;
};

/// Without its interval.
std::optional<double> value_of(const std::optional<Estimate>& estimate);
/// `{"value", "ci95": [low, high]}`, or null.
nlohmann::json to_json(const std::optional<Estimate>& estimate);
/// "4.12" and below it "[3.98, 4.31]"; a dash where there is none.
Cell estimate_cell(const std::optional<Estimate>& estimate, int decimals);

/// Errors that come in groups, such as those of the frames at one place, which share its bias.
class GroupedErrors {
 public:
  explicit GroupedErrors(std::size_t groups) : groups_(groups) {}

  void add(std::size_t group, double error) { values_.push_back({error, group}); }
  void add_undefined() { ++undefined_; }

  std::size_t size() const { return values_.size(); }
  std::size_t undefined() const { return undefined_; }

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

  /// The same without groups that have no error.
  GroupedErrors compact() const;
  Estimate mean_of_groups(std::string_view name) const;
  Estimate quantile_of_groups(double share, std::string_view name) const;

  std::size_t groups_;
  std::vector<Value> values_;
  std::size_t undefined_ = 0;
};

}  // namespace ertbench
