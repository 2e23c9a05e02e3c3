#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "bench/pages/page_expression.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A cell of CSV: a number where all of it is one.
json cell_value(const std::string& text) {
  if (text.empty()) return nullptr;
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return *end == '\0' ? json(number) : json(text);
}

json csv_rows(const fs::path& file) {
  require_regular_file(file);
  const std::string text = contents_of(file);
  const std::vector<std::vector<std::string>> lines = csv_lines(text);
  json rows = json::array();
  for (std::size_t i = 1; i < lines.size(); ++i) {
    json row = json::object();
    for (std::size_t c = 0; c < lines[i].size() && c < lines[0].size(); ++c) {
      row[lines[0][c]] = cell_value(lines[i][c]);
    }
    if (!row.contains("label")) row["label"] = lines[i].front();
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The "rows" of a summary.json; of the card of a fitted solver the card, with the file's name.
json json_rows(const fs::path& file) {
  json content = read_json_file(file);
  json rows = json::array();
  if (content.is_object() && !content.contains("rows")) {
    content["label"] = file.stem().string();
    rows.push_back(std::move(content));
    return rows;
  }
  for (const JsonObject& row : JsonObject(content, file.string(), "").objects("rows")) {
    rows.push_back(row.value());
  }
  return rows;
}

/// Whether `text` is `pattern`, in which * stands for any text.
bool matches(std::string_view text, std::string_view pattern) {
  if (pattern.empty()) return text.empty();
  if (pattern.front() != '*') {
    return !text.empty() && text.front() == pattern.front() &&
           matches(text.substr(1), pattern.substr(1));
  }
  for (std::size_t skip = 0; skip <= text.size(); ++skip) {
    if (matches(text.substr(skip), pattern.substr(1))) return true;
  }
  return false;
}

bool matches_any(const std::string& text, const std::vector<std::string>& patterns) {
  return std::ranges::any_of(patterns,
                             [&](const std::string& pattern) { return matches(text, pattern); });
}

std::string text_in(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number()) return number_text(value.get<double>());
  return value.is_null() ? "" : json_text(value);
}

/// One condition of a selection: of a row's label where `column` is empty.
struct Condition {
  std::string column;
  char relation;  // '=', '!' (none of), '<' or '>'
  std::vector<std::string> alternatives;

  std::string text_of(const json& row) const {
    return column.empty() ? label_of(row) : text_in(value_in(row, column));
  }
  bool names(const json& row) const { return matches_any(text_of(row), alternatives); }
  bool holds(const json& row) const {
    if (relation == '=') return names(row);
    if (relation == '!') return !names(row);
    const json& value = value_in(row, column);
    if (!value.is_number()) return false;
    const double limit = std::strtod(alternatives.front().c_str(), nullptr);
    return relation == '<' ? value.get<double>() < limit : value.get<double>() > limit;
  }
};

Condition condition_in(const std::string& text) {
  const std::size_t at = text.find_first_of("=<>!");
  // A label may hold these characters too, "tsvd rank=35"; a column's name has no blank in it.
  const bool column =
      at != std::string::npos &&
      std::all_of(text.begin(), text.begin() + static_cast<long>(at),
                  [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.'; });
  if (!column) return {"", '=', split(text, "|")};
  const bool two = text.compare(at, 2, "!=") == 0;
  return {text.substr(0, at), text[at], split(text.substr(at + (two ? 2 : 1)), "|")};
}

}  // namespace

std::string label_of(const json& row) {
  const auto label = row.find("label");
  return label != row.end() && label->is_string() ? label->get<std::string>() : "";
}

const json& ResultRows::rows(const std::string& file) {
  const auto found = files_.find(file);
  if (found != files_.end()) return *found->second;
  fs::path path = folder_ / file;
  if (path.extension() != ".csv" && path.extension() != ".json") path /= "summary.json";
  if (!fs::exists(path)) throw InputError(path.string() + ": there is no such result");
  const json rows = path.extension() == ".csv" ? csv_rows(path) : json_rows(path);
  return *files_.emplace(file, JsonValue(rows)).first->second;
}

std::vector<const json*> ResultRows::select(const std::string& file, const std::string& selection,
                                            const std::string& column) {
  std::vector<Condition> conditions;
  for (const std::string& one : split(selection, ",")) conditions.push_back(condition_in(one));
  std::vector<const json*> out;
  // Rows as they would be without limits: which of those a limit leaves is what it asks.
  std::vector<const json*> named;
  for (const json& row : rows(file)) {
    const auto holds = [&](const Condition& one) { return one.holds(row); };
    const auto holds_or_limits = [&](const Condition& one) {
      return one.relation == '<' || one.relation == '>' || one.holds(row);
    };
    if (std::ranges::all_of(conditions, holds)) out.push_back(&row);
    if (!std::ranges::all_of(conditions, holds_or_limits)) continue;
    if (column.empty() || !value_in(row, column).is_null()) named.push_back(&row);
  }
  for (const Condition& condition : conditions) {
    if (condition.relation != '=') continue;
    for (const std::string& name : condition.alternatives) {
      if (name.find('*') != std::string::npos) continue;
      const bool there = std::ranges::any_of(
          named, [&](const json* row) { return matches(condition.text_of(*row), name); });
      if (there) continue;
      throw InputError("no " + (column.empty() ? "row" : column) + " of \"" + name +
                       "\" in the rows \"" + selection + "\" of " + file);
    }
  }
  return out;
}

const json& value_in(const json& row, const std::string& column) {
  static const json none;
  const json* value = &row;
  std::vector<std::string> keys = split(column, ".");
  const bool metric = !row.contains(keys.front()) && row.contains("metrics") &&
                      row.at("metrics").contains(keys.front());
  if (metric) {
    keys.insert(keys.begin(), "metrics");
    if (keys.size() == 2) keys.emplace_back("mean");
  }
  for (const std::string& key : keys) {
    if (value->is_array()) {
      const auto index = whole_number<std::size_t>(key);
      if (!index) throw InputError(column + ": \"" + key + "\" is no place in a list");
      if (*index >= value->size()) return none;
      value = &value->at(*index);
    } else {
      if (!value->is_object() || !value->contains(key)) return none;
      value = &value->at(key);
    }
  }
  return *value;
}

}  // namespace ertbench
