#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// What the title of a column says.
struct ColumnTitle {
  enum class Kind { value, magnitude, phase, real, imaginary, stamp };

  Kind kind = Kind::value;
  /// Driving and measuring electrodes as they are written: "E01_E09_E02_E10_Magnitude [mV]".
  std::optional<std::array<int, 4>> electrodes;
  std::string unit;  ///< "V", "mV", "uV", "deg", "rad", or empty
};

ColumnTitle column_title(std::string_view text);

/// How the columns of a table are read by their titles.
struct TitledColumns {
  struct Column {
    std::size_t value = 0;             ///< column of the table
    std::optional<std::size_t> phase;  ///< of the column whose phase belongs to this magnitude
  };

  std::vector<Column> columns;
  /// Driving and measuring electrodes of each, counted from 0; empty if the titles name none.
  std::vector<std::array<int, 4>> channels;
  std::string unit;        ///< of the values, empty if it is not said
  std::string phase_unit;  ///< "deg", "rad" or empty
};

/// Throws InputError, which begins with `source`, for channels that come twice and for units that
/// differ. Without electrodes in the titles all columns but stamps are taken.
TitledColumns titled_columns(const std::vector<std::string_view>& titles,
                             const std::string& source);

}  // namespace ertbench
