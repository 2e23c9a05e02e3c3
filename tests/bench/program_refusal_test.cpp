// What the program cannot use ends with code 2, its place and a remedy.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

struct BadCall {
  const char* arguments;
  const char* message;
};

TEST(Program, UnusableInputEndsWithCodeTwoAndARemedy) {
  const TemporaryFolder folder("bad");
  write_text(folder / "small.json", small_experiment().dump());
  write_text(folder / "good.json", R"({"type": "tsvd", "rank": 30})");
  write_text(folder / "auto.json", R"({"type": "one-step-gn", "lambda": "auto"})");
  write_text(folder / "rank.json", R"({"type": "tsvd", "rank": 150})");
  write_text(folder / "type.json", R"({"type": "tvsd"})");
  write_text(folder / "checkpoint.json",
             R"({"type": "tsvd", "rank": 30, "checkpoint": "good.json"})");
  write_text(folder / "text.h5", "voltages: 1 2 3");
  const auto frames = [&](const char* name, const RowMajorMatrix& voltages,
                          const Eigen::VectorXd& reference) {
    Hdf5File file = Hdf5File::create(folder / name);
    file.write_matrix("/voltages", voltages);
    file.write_vector("/reference_voltages", reference);
  };
  const Eigen::VectorXd reference = Eigen::VectorXd::Ones(208);
  RowMajorMatrix voltages = RowMajorMatrix::Ones(3, 208);
  frames("good.h5", voltages, reference);
  frames("narrow.h5", voltages.leftCols(200), reference);
  frames("short.h5", voltages, reference.head(100));
  frames("empty.h5", voltages.topRows(0), reference);
  voltages(1, 7) = NAN;
  frames("nan.h5", voltages, reference);
  {
    Hdf5File file = Hdf5File::create(folder / "alone.h5");
    file.write_matrix("/voltages", RowMajorMatrix::Ones(3, 208));
    Hdf5File sensor = Hdf5File::create(folder / "sensor.h5");
    sensor.write_matrix("/voltages", RowMajorMatrix::Ones(3, 208));
    sensor.write_text("/", "sensor", R"({"electrode_count": 15})");
  }
#define TO " --output out.h5"
  const BadCall calls[] = {
      {"", "subcommand"},
      {"fly", "fly"},
      {"run", "EXPERIMENT.json is required"},
      {"run absent.json", "absent.json: cannot be opened"},
      {"run small.json --jobs 0", "--jobs"},
      {"run small.json --only tvsd", "one-step-gn, tsvd, pdipm"},
      {"run good.json", "good.json: "},
      {"run small.json --out /proc/nowhere", "/proc/nowhere"},
      {"reconstruct --solver good.json --input good.h5", "--output is required"},
      {"reconstruct --solver absent.json --input good.h5" TO, "absent.json: cannot be opened"},
      {"reconstruct --solver good.json --input absent.h5" TO, "absent.h5: does not exist"},
      {"reconstruct --solver good.json --input text.h5" TO, "text.h5: cannot be opened as HDF5"},
      {"reconstruct --solver good.json --input narrow.h5" TO,
       "narrow.h5: /voltages: must have shape [N, 208], has [3, 200]"},
      {"reconstruct --solver good.json --input short.h5" TO,
       "/reference_voltages: must have shape"},
      {"reconstruct --solver good.json --input empty.h5" TO, "/voltages: must have shape"},
      {"reconstruct --solver good.json --input nan.h5" TO, "/voltages: row 1, column 7"},
      {"reconstruct --solver good.json --input alone.h5" TO, "/reference_voltages: is missing"},
      {"reconstruct --solver good.json --input sensor.h5" TO, "sensor.h5"},
      {"reconstruct --solver auto.json --input good.h5" TO, "auto.json: /lambda"},
      {"reconstruct --solver rank.json --input good.h5" TO, "104"},
      {"reconstruct --solver type.json --input good.h5" TO, "type.json: /type"},
      {"reconstruct --solver checkpoint.json --input good.h5" TO, "good.json"},
      {"reconstruct --solver good.json --input good.h5 --output good.h5", "is the input"},
      {"reconstruct --solver good.json --input good.h5 --output absent/out.h5", "absent/out.h5"},
      {"reconstruct --solver good.json --input good.h5 --plugin absent.so" TO, "absent.so"},
  };
#undef TO
  for (const BadCall& call : calls) {
    SCOPED_TRACE(call.arguments);
    const Outcome outcome = run_program(folder.path(), call.arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_NE(outcome.output.find(call.message), std::string::npos) << outcome.output;
    EXPECT_FALSE(fs::exists(folder / "out.h5"));
  }
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
  }
}

}  // namespace
}  // namespace ertbench
