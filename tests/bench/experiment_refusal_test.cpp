// Files that are wrong are refused, each with its place and a remedy.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/bench/experiment_testing.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using namespace testing;

struct Broken {
  const char* place;   ///< JSON pointer of what is changed
  const char* value;   ///< the new JSON, or "remove"
  const char* path;    ///< that the message must name
  const char* remedy;  ///< that it must contain
  bool schema_can_tell = true;
};

const Broken broken[] = {
    {"/solvers/1/lambda", "-1", "/solvers/1/lambda", "must be > 0"},
    {"/solvers/1/lambda", "0", "/solvers/1/lambda", "must be > 0"},
    {"/solvers/1/lambda", "\"best\"", "/solvers/1/lambda", "auto"},
    {"/solvers/1/lambda", "[1]", "/solvers/1/lambda", "auto"},
    {"/solvers/1/lamda", "1", "/solvers/1/lamda", "did you mean \"lambda\""},
    {"/solvers/1/prior", "\"total variation\"", "/solvers/1/prior", "\"tikhonov\""},
    {"/solvers/0/rank", "0", "/solvers/0/rank", "1"},
    {"/solvers/0/rank", "105", "/solvers/0/rank", "104", false},
    {"/solvers/0/rank", "2.5", "/solvers/0/rank", "whole"},
    {"/solvers/0/threshold", "0.1", "/solvers/0", "rank"},
    {"/solvers/2/alpha", "-1e-4", "/solvers/2/alpha", "must be > 0"},
    {"/solvers/2/max_iterations", "0", "/solvers/2/max_iterations", "from 1 to"},
    {"/solvers/0/type", "\"tsdv\"", "/solvers/0/type", "tsvd", false},
    {"/solvers/0/type", "7", "/solvers/0/type", "string"},
    {"/solvers/0/type", "remove", "/solvers/0/type", "missing"},
    {"/solvers/0/label", "\"../../etc\"", "/solvers/0/label", "letters"},
    {"/solvers/0/label", "\"pdipm\"", "/solvers/2/label", "taken", false},
    {"/solvers/0/label", "\"truth\"", "/solvers/0/label", "taken", false},
    {"/solvers/0/label", "\"limit-lower\"", "/solvers/0/label", "taken", false},
    {"/solvers", "[]", "/solvers", "at least one"},
    {"/solvers", "{}", "/solvers", "array"},
    {"/solvers", "remove", "/solvers", "missing"},
    {"/solvers/0", "\"tsvd\"", "/solvers/0", "object"},
    {"/datasets", "remove", "/datasets", "missing"},
    {"/datasets", "{}", "/datasets", "test set"},
    {"/datasets/test", "remove", "/datasets", "test set", false},
    {"/datasets/validation", "remove", "/solvers/1", "validation", false},
    {"/datasets/a b", "{}", "/datasets/a b", "letters"},
    {"/datasets/test/snr_db", "remove", "/datasets/test/snr_db", "missing"},
    {"/datasets/test/snr_db", "\"50\"", "/datasets/test/snr_db", "null"},
    {"/datasets/test/count", "7", "/datasets/test/count", "1", false},
    {"/datasets/validation/snr_basis", "remove", "/datasets/validation/snr_basis", "missing"},
    {"/datasets/validation/snr_basis", "\"relative\"", "/datasets/validation/snr_basis",
     "\"difference\""},
    {"/datasets/validation/count", "0", "/datasets/validation/count", "from 1 to"},
    {"/datasets/validation/count", "-5", "/datasets/validation/count", "from 1 to"},
    {"/datasets/validation/count", "1e300", "/datasets/validation/count", "from 1 to"},
    {"/datasets/validation/count", "remove", "/datasets/validation/count", "missing", false},
    {"/datasets/validation/grid", "30", "/datasets/validation/grid", "power of two", false},
    {"/datasets/validation/grid", "12", "/datasets/validation/grid", "power of two", false},
    {"/datasets/validation/grid", "1000000", "/datasets/validation/grid", "from 1 to"},
    {"/datasets/validation/rasterisation", "\"exact\"", "/datasets/validation/rasterisation",
     "\"centre\""},
    {"/datasets/validation/seed", "-1", "/datasets/validation/seed", "from 0"},
    {"/datasets/validation/scenes", "5", "/datasets/validation/scenes", "object"},
    {"/datasets/validation/scenes", "[]", "/datasets/validation/scenes", "at least one"},
    {"/datasets/validation/scenes/radius", "[0.3, 0.1]", "/datasets/validation/scenes/radius",
     "low <= high", false},
    {"/datasets/validation/scenes/radius", "[0.1, 0.2, 0.3]", "/datasets/validation/scenes/radius",
     "2 numbers"},
    {"/datasets/validation/scenes/radius", "-0.1", "/datasets/validation/scenes/radius",
     "from 1e-06 to 2"},
    {"/datasets/validation/scenes/contacts", "[1.5, 2]", "/datasets/validation/scenes/contacts",
     "whole"},
    {"/datasets/validation/scenes/shapes", "[\"circle\"]", "/datasets/validation/scenes/shapes/0",
     "\"disc\""},
    {"/datasets/validation/scenes/shapes", "[]", "/datasets/validation/scenes/shapes", "disc"},
    {"/datasets/validation/scenes/blank_fraction", "2",
     "/datasets/validation/scenes/blank_fraction", "from 0 to 1"},
    {"/datasets/validation/scenes/conductivity", "0.5", "/datasets/validation/scenes/conductivity",
     "did you mean \"conductivity_ratio\""},
    {"/datasets/test/scenes/0/contacts/0/radius", "remove",
     "/datasets/test/scenes/0/contacts/0/radius", "missing"},
    {"/datasets/test/scenes/0/contacts/0/centre", "[0]",
     "/datasets/test/scenes/0/contacts/0/centre", "2 numbers"},
    {"/datasets/test/scenes/0/contacts/0/shape", "\"ring\"",
     "/datasets/test/scenes/0/contacts/0/shape", "\"polygon\""},
    {"/datasets/test/scenes/0/contacts/0/conductivity_ratio", "0",
     "/datasets/test/scenes/0/contacts/0/conductivity_ratio", "from 1e-06 to 1000"},
    {"/datasets/test/scenes/0/contacts/0/semi_axes", "[1, 1]",
     "/datasets/test/scenes/0/contacts/0/semi_axes", "unknown key"},
    {"/datasets/test/scenes/0/contacts",
     "[{\"shape\": \"polygon\", \"conductivity_ratio\": 0.5, "
     "\"vertices\": [[0, 0], [1, 1], [1, 0], [0, 1]]}]",
     "/datasets/test/scenes/0/contacts/0/vertices", "cross", false},
    {"/datasets/test/scenes/0/contacts",
     "[{\"shape\": \"polygon\", \"conductivity_ratio\": 0.5, "
     "\"vertices\": [[0, 0], [1, 1]]}]",
     "/datasets/test/scenes/0/contacts/0/vertices", "3 to 64"},
    {"/datasets/test/scenes/0/contacts/0/radius_mm", "20",
     "/datasets/test/scenes/0/contacts/0/radius_mm", "stands beside \"radius\""},
    {"/datasets/test/scenes/0/contacts/0/centre_mm", "[0, 0]",
     "/datasets/test/scenes/0/contacts/0/centre_mm", "remove one"},
    {"/datasets/validation/scenes/radius_mm", "20", "/datasets/validation/scenes/radius_mm",
     "stands beside \"radius\""},
    {"/datasets/validation/scenes/centre", R"({"x_mm": 0})", "/datasets/validation/scenes/centre/y",
     "missing"},
    {"/datasets/validation/scenes/centre", R"({"x_mm": "left", "y": 0})",
     "/datasets/validation/scenes/centre/x_mm", "2 numbers"},
    {"/sensor/electrode_count", "3", "/sensor/electrode_count", "from 5"},
    {"/sensor/electrode_width", "0.1", "/sensor/electrode_width", "point electrodes", false},
    {"/sensor/measures_driven", "true", "/sensor/measures_driven", "infinite", false},
    {"/sensor/drive", "[[0, 16]]", "/sensor/drive", "from 0 to 15", false},
    {"/sensor/background", "0", "/sensor/background", "must be from 1e-09 to 1e+08 S/m, got 0"},
    {"/sensor/background", "1e200", "/sensor/background", "to 1e+08 S/m, got 1e+200"},
    {"/sensor/background", "1e-200", "/sensor/background", "from 1e-09"},
    {"/sensor/drive_current", "\"25 mA\"", "/sensor/drive_current", "from 1e-09 to 100 A"},
    {"/sensor/drive_current", "1e200", "/sensor/drive_current", "to 100 A"},
    {"/sensor/drive_current", "1e-200", "/sensor/drive_current", "from 1e-09"},
    {"/solvers/1/lambda", "1e200", "/solvers/1/lambda", "must be from 1e-20 to 1e+20 or \"auto\""},
    {"/solvers/1/lambda", "1e-200", "/solvers/1/lambda", "from 1e-20"},
    {"/solvers/2/alpha", "1e-200", "/solvers/2/alpha", "from 1e-20"},
    {"/datasets/validation/scenes/radius", "1e-200", "/datasets/validation/scenes/radius",
     "from 1e-06 to 2"},
    {"/datasets/validation/scenes/aspect", "1e-200", "/datasets/validation/scenes/aspect",
     "from 0.001 to 1"},
    {"/datasets/validation/scenes/conductivity_ratio", "[1e-200, 1]",
     "/datasets/validation/scenes/conductivity_ratio", "from 1e-06 to 1000"},
    {"/datasets/test/scenes/0/contacts/0/radius", "1e-200",
     "/datasets/test/scenes/0/contacts/0/radius", "from 1e-06 to 100"},
    {"/published/rows/tsvd/AR", "1e308", "/published/rows/tsvd/AR", "from -1e+06 to 1e+06"},
    {"/sensor/electrodes", "16", "/sensor/electrodes", "did you mean"},
    {"/timing/frames", "100", "/timing/frames", "from 662"},
    {"/timing/rounds", "0", "/timing/rounds", "from 1"},
    {"/check", R"({"seeds": 0})", "/check/seeds", "from 1"},
    {"/check", R"({"baseline_seeds": 2})", "/check/baseline_seeds", "from 3"},
    {"/check", R"({"seed": 2})", "/check/seed", "did you mean"},
    {"/contacts", R"({"threshold": 1.5})", "/contacts/threshold", "from 0 to 1"},
    {"/contacts", R"({"threshold": "best"})", "/contacts/threshold", "auto"},
    {"/contacts", R"({"floor": -1})", "/contacts/floor", "\"auto\""},
    {"/contacts", R"({"saddle": "auto"})", "/contacts/saddle", "from 0 to 1"},
    {"/contacts", R"({"match_mm": 0})", "/contacts/match_mm", "> 0"},
    {"/contacts", R"({"ospa": 50})", "/contacts/ospa", "did you mean \"ospa_mm\""},
    {"/right_sizing", R"({"margin": -0.1})", "/right_sizing/margin", "from 0 to 10"},
    {"/right_sizing", R"({"metric": "AR"})", "/right_sizing/metric", "\"PE\"", false},
    {"/right_sizing", R"({"margins": 0.1})", "/right_sizing/margins", "did you mean"},
    {"/solvers/0/family", R"("a/b")", "/solvers/0/family", "label"},
    {"/charts", R"([{"type": "speed-accuracy", "name": "a", "metric": "AR"}])", "/charts/0/metric",
     "\"relative_error\"", false},
    {"/charts", R"([{"type": "speed-accuracy", "name": "a", "budgets_us": [0]}])",
     "/charts/0/budgets_us", "> 0"},
    {"/charts", R"([{"type": "speed-accuracy", "name": "a", "break_even_against": ["gn"]}])",
     "/charts/0/break_even_against/0", "\"one-step-gn\"", false},
    {"/charts", R"([{"type": "training-budget", "name": "a", "metric": "AR"}])", "/charts/0/metric",
     "\"relative_error\"", false},
    {"/charts", R"([{"type": "training-budget", "name": "a", "cost": "money"}])", "/charts/0/cost",
     "\"scenes\""},
    {"/timing/enabled", "1", "/timing/enabled", "true or false"},
    {"/time_limit_s", "0", "/time_limit_s", "> 0"},
    {"/figure/scenes", "[1]", "/figure/scenes", "from 0 to 0", false},
    {"/figure/scenes", "[-1]", "/figure/scenes", "from 0 to 0"},
    {"/published/rows/tsvd/ar", "1", "/published/rows/tsvd/ar", "did you mean \"AR\"", false},
    {"/published/datasets", "[\"train\"]", "/published/datasets", "test sets", false},
    {"/plugins", "[\"absent.so\"]", "/plugins", "absent.so", false},
    {"/plugins", "\"absent.so\"", "/plugins", "list"},
    {"/titel", "\"x\"", "/titel", "did you mean \"title\""},
    {"/solvers/0/seeds", "[1, 2]", "/solvers/0/seeds", "tsvd has no training seed; remove it"},
    {"/solvers/1/sweep", "5", "/solvers/1/sweep", "object"},
    {"/solvers/1/sweep", "{}", "/solvers/1/sweep", "one or two"},
    {"/solvers/1/sweep", R"({"a": [1], "b": [1], "c": [1]})", "/solvers/1/sweep", "one or two"},
    {"/solvers/1/sweep", R"({"prior": ["noser", "tikonov"]})", "/solvers/1/sweep/prior/1",
     "\"tikhonov\"", false},
    {"/solvers/1/sweep", R"({"lambda": [0.1, 1]})", "/solvers/1/sweep/lambda", "remove one", false},
    {"/solvers/1/sweep", R"({"priors": ["noser"]})", "/solvers/1/sweep/priors",
     "there are prior, lambda", false},
    {"/solvers/1/sweep", R"({"seed": [1, 2]})", "/solvers/1/sweep/seed", "\"seeds\""},
    {"/solvers/1/sweep", R"({"label": ["a"]})", "/solvers/1/sweep/label", "cannot be swept"},
    {"/solvers/1/sweep", R"({"prior": []})", "/solvers/1/sweep/prior", "1 to 50"},
    {"/solvers/1/sweep", R"({"prior": "noser"})", "/solvers/1/sweep/prior", "1 to 50"},
    {"/solvers/1/sweep", R"({"prior": ["noser", "noser"]})", "/solvers/1/sweep/prior/1", "twice"},
    {"/solvers/1/sweep", R"({"prior": [["noser"]]})", "/solvers/1/sweep/prior/0",
     "list of numbers"},
    {"/solvers/1/sweep", R"({"prior": ["a/b"]})", "/solvers/1/sweep/prior/0", "letters", false},
    {"/charts", "{}", "/charts", "array"},
    {"/charts", R"([{"type": "pie", "name": "a"}])", "/charts/0/type", "\"heat-map\""},
    {"/charts", R"([{"type": "bars"}])", "/charts/0/name", "missing"},
    {"/charts", R"([{"type": "bars", "name": "a b"}])", "/charts/0/name", "letters"},
    {"/charts", R"([{"type": "bars", "name": "reconstructions"}])", "/charts/0/name", "taken",
     false},
    {"/charts", R"([{"type": "bars", "name": "a"}, {"type": "bars", "name": "a"}])",
     "/charts/1/name", "taken", false},
    {"/charts", R"([{"type": "bars", "name": "a", "solvers": []}])", "/charts/0/solvers", "labels"},
    {"/charts", R"([{"type": "bars", "name": "a", "solvers": ["tsvd", "tvsd"]}])",
     "/charts/0/solvers/1", "there are tsvd, one-step-gn, pdipm", false},
    {"/charts", R"([{"type": "bars", "name": "a", "metrics": ["ar"]}])", "/charts/0/metrics/0",
     "\"AR\"", false},
    {"/charts", R"([{"type": "bars", "name": "a", "metrics": [""]}])", "/charts/0/metrics/0",
     "\"AR\""},
    {"/charts", R"([{"type": "bars", "name": "a", "metrics": ["AR", "AR"]}])", "/charts/0/metrics",
     "twice"},
    {"/charts", R"([{"type": "bars", "name": "a", "dataset": "validation"}])", "/charts/0/dataset",
     "\"test\"", false},
    {"/charts", R"([{"type": "bars", "name": "a", "solver": "tsvd"}])", "/charts/0/solver",
     "did you mean \"solvers\""},
    {"/charts", R"([{"type": "heat-map", "name": "a", "solver": "tsvd"}])", "/charts/0/solver",
     "two parameters", false},
};

TEST(Experiment, BrokenFilesAreRefusedWithPlaceAndRemedy) {
  const TemporaryFolder folder("experiment");
  const auto file = folder / "broken.json";
  write_text(file, good().dump());
  ASSERT_EQ(refusal(file), "");
  ASSERT_EQ(schema_complaint(good()), "");
  for (const Broken& b : broken) {
    SCOPED_TRACE(std::string(b.place) + " = " + b.value);
    json value = good();
    const json::json_pointer place(b.place);
    if (std::string(b.value) == "remove") {
      value.at(place.parent_pointer()).erase(place.back());
    } else {
      value[place] = json::parse(b.value);
    }
    write_text(file, value.dump());
    const std::string message = refusal(file);
    EXPECT_EQ(message.rfind(file.string() + ": " + b.path + ":", 0), 0u) << message;
    EXPECT_NE(message.find(b.remedy), std::string::npos) << message;
    if (b.schema_can_tell) {
      EXPECT_NE(schema_complaint(value), "");
    }
  }
}

TEST(Experiment, TextThatIsNotJsonIsRefused) {
  const TemporaryFolder folder("text");
  const auto file = folder / "text.json";
  const auto message_for = [&](const std::string& text) {
    write_text(file, text);
    return refusal(file);
  };
  EXPECT_NE(message_for("").find("text.json: not valid JSON"), std::string::npos);
  EXPECT_NE(message_for("{\"datasets\": ").find("line 1, column"), std::string::npos);
  EXPECT_NE(message_for("{\"solvers\": [], \"solvers\": []}").find("\"solvers\" stands twice"),
            std::string::npos);
  EXPECT_NE(message_for("[]").find("/: must be an object"), std::string::npos);
  EXPECT_NE(message_for("{\"time_limit_s\": 1e999}").find("text.json"), std::string::npos);
  EXPECT_NE(message_for(std::string(100000, '[')).find("text.json: is nested deeper than 64"),
            std::string::npos);
  EXPECT_NE(message_for(std::string("\0\xff\xfe", 3)).find("not valid JSON"), std::string::npos);
  EXPECT_NE(refusal(folder / "absent.json").find("cannot be opened"), std::string::npos);
  EXPECT_NE(refusal(folder.path()).find("is a directory"), std::string::npos);
}

}  // namespace
}  // namespace ertbench
