#include "bench/experiment/experiment_charts.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "bench/experiment/experiment.h"
#include "bench/experiment/names.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

const ChartType& read_type(JsonObject& object, const ChartTypes& types) {
  std::vector<std::string> names;
  for (const ChartType& type : types) names.push_back(type.name);
  const std::string name = object.choice("type", names);
  return *std::find_if(types.begin(), types.end(),
                       [&](const ChartType& type) { return type.name == name; });
}

ChartPlace read_place(JsonObject& object, const Experiment& experiment) {
  ChartPlace place;
  place.name = object.text("name");
  if (!is_name(place.name)) {
    object.fail("name", "must be made of letters, digits, \"_\" and \"-\" (at most 60), got \"" +
                            place.name + "\"");
  }
  std::vector<std::string> tests;
  for (const DatasetSpec& test : experiment.tests) tests.push_back(test.name);
  place.dataset = object.choice_or("dataset", tests.front(), tests);
  return place;
}

}  // namespace

std::vector<std::shared_ptr<const Chart>> read_charts(JsonObject& root,
                                                      const Experiment& experiment,
                                                      const ChartTypes& types,
                                                      SolverRegistry& registry) {
  std::vector<std::shared_ptr<const Chart>> charts;
  std::set<std::string> taken = {"reconstructions"};
  for (JsonObject& object : root.objects("charts")) {
    const ChartType& type = read_type(object, types);
    const ChartPlace place = read_place(object, experiment);
    charts.push_back(type.read({object, place, experiment, registry}));
    object.finish();
    if (!taken.insert(place.name).second) {
      object.fail("name", "\"" + place.name + "\" is taken; give every chart its own name");
    }
  }
  return charts;
}

}  // namespace ertbench
