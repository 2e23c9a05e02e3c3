#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "solvers/export/layer_program.h"

namespace ertbench {

inline std::string c_number(double value, int digits = 16) {
  char text[32];
  const auto end =
      std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, digits);
  return {text, end.ptr};
}
inline std::string c_number(float value) { return c_number(static_cast<double>(value), 8) + "F"; }
inline std::string c_number(int value) { return std::to_string(value); }
inline std::string c_number(std::uint64_t value) { return std::to_string(value) + "U"; }

/// Values of a sigmoid [257] in 2^-16, of each 256th count from -32768 on.
inline std::vector<int> sigmoid_table(double step) {
  std::vector<int> table;
  for (int i = 0; i <= 256; ++i) {
    table.push_back(static_cast<int>(
        std::min(65535.0, std::round(65536 / (1 + std::exp(-step * (256 * i - 32768)))))));
  }
  return table;
}

/// [outputs][taps and inputs] as [outputs / group][taps and inputs / together][group][together].
template <typename Number>
std::vector<Number> grouped(const std::vector<Number>& weights, int outputs, int group,
                            int together) {
  const std::size_t size = weights.size() / index_of(outputs);
  std::vector<Number> out;
  for (int first = 0; first < outputs; first += group) {
    for (std::size_t i = 0; i < size; i += index_of(together)) {
      for (int o = first; o < first + group; ++o) {
        const auto at = weights.begin() + static_cast<std::ptrdiff_t>(index_of(o) * size + i);
        out.insert(out.end(), at, at + together);
      }
    }
  }
  return out;
}

/// Arrays of constants: their definitions, their declarations and their size.
class Constants {
 public:
  template <typename Number>
  std::string add(const std::string& type, const std::string& name,
                  const std::vector<Number>& numbers, std::size_t bytes_each) {
    const std::string begin =
        "const " + type + " " + name + "[" + std::to_string(numbers.size()) + "]";
    declarations_ += "extern " + begin + ";\n";
    definitions_ += "\n" + begin + " = {";
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      definitions_ += i == 0 ? "\n    " : i % 8 == 0 ? ",\n    " : ", ";
      definitions_ += c_number(numbers[i]);
    }
    definitions_ += "\n};\n";
    bytes_ += bytes_each * numbers.size();
    return name;
  }
  const std::string& declarations() const { return declarations_; }
  const std::string& definitions() const { return definitions_; }
  std::size_t bytes() const { return bytes_; }

 private:
  std::string declarations_;
  std::string definitions_;
  std::size_t bytes_ = 0;
};

}  // namespace ertbench
