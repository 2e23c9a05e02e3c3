#include "bench/timing/benchmark_output.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/errors.h"
#include "core/json_text.h"
#include "core/quantile.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// `text` with null in place of NaN and Infinity, signed or not, outside of strings.
std::string with_nulls(std::string_view text) {
  std::string out;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!in_string) {
      const std::size_t sign = text[i] == '-' || text[i] == '+' ? 1 : 0;
      std::size_t length = 0;
      for (const std::string_view word : {"NaN", "nan", "Infinity", "inf"}) {
        if (text.substr(i + sign).starts_with(word)) length = std::max(length, word.size());
      }
      if (length > 0) {
        out += "null";
        i += sign + length - 1;
        continue;
      }
    }
    if (text[i] == '"') in_string = !in_string;
    out += text[i];
    if (in_string && text[i] == '\\' && i + 1 < text.size()) out += text[++i];
  }
  return out;
}

double unit_seconds(const std::string& unit) {
  if (unit == "ns") return 1e-9;
  if (unit == "us") return 1e-6;
  return unit == "ms" ? 1e-3 : 1;
}

/// "3.90 µs"
std::string time_text(double seconds) {
  if (seconds < 1e-6) return three_digits(1e9 * seconds) + " ns";
  if (seconds < 1e-3) return three_digits(1e6 * seconds) + " µs";
  return seconds < 1 ? three_digits(1e3 * seconds) + " ms" : three_digits(seconds) + " s";
}

/// "256 k", "40.7 G"
std::string rate_text(double rate) {
  if (rate < 1e3) return three_digits(rate) + " ";
  if (rate < 1e6) return three_digits(1e-3 * rate) + " k";
  return rate < 1e9 ? three_digits(1e-6 * rate) + " M" : three_digits(1e-9 * rate) + " G";
}

std::string rate_of(const json& benchmark) {
  for (const auto& [key, unit] :
       {std::pair{"FLOP/s", "FLOP/s"}, std::pair{"items_per_second", "/s"},
        std::pair{"bytes_per_second", "B/s"}}) {
    const auto rate = benchmark.find(key);
    if (rate != benchmark.end() && rate->is_number()) return rate_text(*rate) + unit;
  }
  return "";
}

std::string limit_of(const json& benchmark) {
  if (benchmark.value("error_occurred", false)) {
    return "failed: " + one_line(benchmark.value("error_message", "without a message"), 60);
  }
  const auto fraction = benchmark.find("of_limit");
  if (fraction == benchmark.end() || !fraction->is_number()) return "";
  return fixed(*fraction, 2) + " of " + benchmark.value("label", "");
}

}  // namespace

json parse_benchmark_output(std::string_view text) {
  json output;
  try {
    output = parse_json(with_nulls(text), "its output");
  } catch (const InputError& error) {
    throw std::runtime_error(error.what());
  }
  const auto benchmarks = output.find("benchmarks");
  const auto is_benchmark = [](const json& one) {
    return one.is_object() && one.contains("name") && one["name"].is_string();
  };
  if (benchmarks == output.end() || !benchmarks->is_array() ||
      !std::all_of(benchmarks->begin(), benchmarks->end(), is_benchmark)) {
    throw std::runtime_error("its output has no list \"benchmarks\" of objects with a \"name\"");
  }
  return output;
}

void add_round(const std::string& program, const json& output,
               std::vector<TimedBenchmark>& benchmarks) {
  for (const json& one : output.at("benchmarks")) {
    const std::string name = one.at("name");
    const auto known = std::find_if(
        benchmarks.begin(), benchmarks.end(),
        [&](const TimedBenchmark& b) { return b.program == program && b.name() == name; });
    if (known == benchmarks.end()) {
      benchmarks.push_back({program, {one}});
    } else {
      known->rounds.push_back(one);
    }
  }
}

double seconds_of(const json& benchmark) {
  const std::string name = benchmark.at("name");
  const bool wall = name.find("/real_time") != std::string::npos ||
                    name.find("/manual_time") != std::string::npos;
  const auto time = benchmark.find(wall ? "real_time" : "cpu_time");
  if (time == benchmark.end() || !time->is_number()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return time->get<double>() * unit_seconds(benchmark.value("time_unit", "ns"));
}

json median_of(const TimedBenchmark& benchmark) {
  std::vector<std::pair<double, const json*>> rounds;
  json times = json::array();
  for (const json& round : benchmark.rounds) {
    const double seconds = seconds_of(round);
    times.push_back(std::isfinite(seconds) ? json(seconds) : json());
    if (std::isfinite(seconds)) rounds.emplace_back(seconds, &round);
  }
  json out = benchmark.rounds.front();
  if (!rounds.empty()) {
    std::sort(rounds.begin(), rounds.end());
    out = *rounds[nearest_rank(rounds.size(), 0.5)].second;
  }
  out["program"] = benchmark.program;
  out["time_s"] = rounds.empty() ? json() : json(seconds_of(out));
  const std::string name = benchmark.name();
  out["name"] = name.substr(0, name.find("/iterations:"));  // said again under "iterations"
  out["rounds_s"] = times;
  return out;
}

TableSection timing_table(const std::string& program, const std::vector<json>& medians) {
  TableSection section;
  section.caption = program;
  section.columns = {{"benchmark", Align::left}, "time", "rate", {"of the limit", Align::left}};
  for (const json& one : medians) {
    const json& time = one.at("time_s");
    section.rows.push_back({one.at("name").get<std::string>(),
                            time.is_number() ? time_text(time) : "—", rate_of(one), limit_of(one)});
  }
  return section;
}

}  // namespace ertbench
