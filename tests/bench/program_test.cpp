// The program as users call it: exit codes, messages, interrupted and repeated runs, damaged files.

#include "tests/bench/program.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

/// What must not depend on how a run went: everything but the clocks and the date.
json lasting_part(json summary) {
  for (json& row : summary.at("rows")) {
    for (const char* key : {"fit_s", "latency_us", "frames_per_s", "peak_rss_mb"}) row.erase(key);
  }
  return summary.at("rows");
}

TEST(Program, RunWritesEveryResult) {
  const TemporaryFolder folder("run");
  json experiment = small_experiment();
  experiment["timing"] = {{"frames", 662}, {"batch", 8}};
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("one-step-gn"), std::string::npos);
  const fs::path results = folder / "results/small";
  for (const char* file : {"summary.json", "table.md", "table.csv", "table.tex", "report.html",
                           "reconstructions.svg", "reconstructions.png"}) {
    EXPECT_GT(fs::file_size(results / file), 500u) << file;
  }
  const json summary = summary_of(results);
  EXPECT_EQ(summary.at("schema"), 1);
  EXPECT_EQ(summary.at("experiment"), "small");
  for (const char* key : {"commit", "host", "cpu", "threads", "libraries", "date", "seeds"}) {
    EXPECT_TRUE(summary.at("provenance").contains(key)) << key;
  }
  EXPECT_EQ(summary.at("rows").size(), 5u);
  EXPECT_EQ(row_of(summary, "no-contact").at("metrics").at("AR").at("mean"), 0);
  EXPECT_EQ(row_of(summary, "no-contact").at("metrics").at("RES").at("undefined"), 40);
  EXPECT_EQ(row_of(summary, "truth").at("metrics").at("RIE").at("mean"), 0);
  for (const char* label : {"one-step-gn", "tsvd", "pdipm"}) {
    const json& row = row_of(summary, label);
    EXPECT_EQ(row.at("status"), "ok");
    EXPECT_EQ(row.at("frames"), 40);
    // Better than doing nothing, by far more than the interval.
    EXPECT_LT(row.at("metrics").at("relative_error").at("ci95")[1], 0.95);
    const json& latency = row.at("latency_us");
    EXPECT_GT(latency.at("p50"), 0);
    EXPECT_LE(latency.at("p50"), latency.at("p99"));
    EXPECT_LE(latency.at("p99"), latency.at("max"));
    EXPECT_GT(row.at("frames_per_s"), 0);
    EXPECT_GT(row.at("peak_rss_mb"), 0);
  }
  const json& parameters = row_of(summary, "one-step-gn").at("parameters");
  EXPECT_TRUE(parameters.at("lambda").is_number());
  EXPECT_TRUE(parameters.at("contacts").at("threshold").is_number());
  EXPECT_TRUE(parameters.at("contacts").at("floor").is_number());
}

TEST(Program, OneOrTwoJobsGiveTheSame) {
  const TemporaryFolder folder("jobs");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "run small.json --jobs 1 --out one").exit_code, 0);
  fs::remove_all(folder / "cache");
  ASSERT_EQ(run_program(folder.path(), "run small.json --jobs 2 --out two").exit_code, 0);
  EXPECT_EQ(lasting_part(summary_of(folder / "one")), lasting_part(summary_of(folder / "two")));
}

TEST(Program, RepeatedRunComputesNothingTwice) {
  const TemporaryFolder folder("repeat");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "run small.json").exit_code, 0);
  const auto ages = [&] {
    std::map<std::string, fs::file_time_type> out;
    for (const char* part : {"cache", "results/small/records"}) {
      for (const auto& entry : fs::recursive_directory_iterator(folder / part)) {
        if (entry.is_regular_file()) out[entry.path()] = entry.last_write_time();
      }
    }
    return out;
  };
  const auto before = ages();
  const json first = summary_of(folder / "results/small");
  ASSERT_EQ(run_program(folder.path(), "run small.json").exit_code, 0);
  EXPECT_EQ(ages(), before);
  EXPECT_EQ(lasting_part(summary_of(folder / "results/small")), lasting_part(first));
  ASSERT_EQ(run_program(folder.path(), "run small.json --fresh --only tsvd").exit_code, 0);
  EXPECT_NE(ages(), before);
  EXPECT_EQ(lasting_part(summary_of(folder / "results/small")), lasting_part(first));
}

TEST(Program, KilledAtRandomTimesAndRepeated) {
  const TemporaryFolder folder("kill");
  json experiment = small_experiment();
  experiment["datasets"]["validation"]["count"] = 3000;
  write_text(folder / "small.json", experiment.dump());
  ASSERT_EQ(run_program(folder.path(), "run small.json --out whole").exit_code, 0);
  fs::remove_all(folder / "cache");
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (int attempt = 0; attempt < 8; ++attempt) {
    const pid_t child = ::fork();
    if (child == 0) {
      ::setpgid(0, 0);
      _exit(run_program(folder.path(), "run small.json --out killed").exit_code);
    }
    ::setpgid(child, child);
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + random() % 700));
    ::kill(-child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    // Whatever is there under its final name is whole.
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      if (entry.path().extension() == ".json") {
        EXPECT_TRUE(json::accept(read_text(entry.path()))) << entry.path();
      }
      if (entry.path().extension() == ".h5") {
        EXPECT_NO_THROW(DatasetFile{entry.path()});
      }
    }
  }
  // Trials die with the run; give the last one the moment it needs.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const Outcome outcome = run_program(folder.path(), "run small.json --out killed");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(lasting_part(summary_of(folder / "killed")),
            lasting_part(summary_of(folder / "whole")));
}

TEST(Program, FailingTrialsCostOnlyTheirRows) {
  const TemporaryFolder folder("fail");
  json experiment = small_experiment();
  experiment["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
#ifdef __SANITIZE_ADDRESS__
  experiment["time_limit_s"] = 60;
#else
  experiment["time_limit_s"] = 8;
#endif
  experiment["solvers"] = json::array({{{"type", "tsvd"}, {"rank", 30}}});
  for (const char* how : {"crash", "throw", "hang", "nan", "stops"}) {
    experiment["solvers"].push_back({{"type", "misbehaving"}, {"how", how}, {"label", how}});
  }
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json --jobs 2");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  const json summary = summary_of(folder / "results/small");
  const auto status = [&](const char* label) { return row_of(summary, label).at("status"); };
  EXPECT_EQ(status("tsvd"), "ok");
  EXPECT_EQ(status("crash"), "crashed");
  EXPECT_EQ(status("throw"), "failed");
  EXPECT_NE(row_of(summary, "throw").at("message").get<std::string>().find("on fire"),
            std::string::npos);
  EXPECT_EQ(status("hang"), "timed out");
  EXPECT_EQ(status("nan"), "ok");
  EXPECT_EQ(row_of(summary, "nan").at("undefined_frames"), 20);
  EXPECT_EQ(row_of(summary, "stops").at("frames_not_converged"), 40);
  const std::string table = read_text(folder / "results/small/table.md");
  for (const char* label : {"crash", "throw", "hang", "nan", "stops"}) {
    EXPECT_NE(table.find(label), std::string::npos) << label;
  }
}

TEST(Program, AnAbsentOrBrokenPluginCostsOnlyItsSolvers) {
  const TemporaryFolder folder("plugin");
  const fs::path program = folder / "ertbench";  // a copy, which has no plugin beside it
  fs::copy_file(ERTBENCH_PROGRAM, program);
  json experiment = small_experiment();
  experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}}, {{"type", "dd-ert"}}};
  write_text(folder / "small.json", experiment.dump());
  write_text(folder / "learned.json", R"({"type": "dd-ert", "checkpoint": "net.fitted"})");
  ASSERT_EQ(run_program(folder.path(), "generate small.json --dataset test --out t.h5", program)
                .exit_code,
            0);
  for (const bool broken : {false, true}) {
    SCOPED_TRACE(broken ? "broken" : "absent");
    if (broken) write_text(folder / "libertbench_models.so", "no library");
    const Outcome outcome = run_program(folder.path(), "run small.json --fresh", program);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    const json summary = summary_of(folder / "results/small");
    EXPECT_EQ(row_of(summary, "tsvd").at("status"), "ok");
    EXPECT_EQ(row_of(summary, "dd-ert").at("status"), "failed");
    const std::string message = row_of(summary, "dd-ert").at("message");
    EXPECT_NE(message.find("libertbench_models.so"), std::string::npos) << message;
    const Outcome frames = run_program(
        folder.path(), "reconstruct --solver learned.json --input t.h5 --output o.h5", program);
    EXPECT_EQ(frames.exit_code, 2);
    EXPECT_NE(frames.output.find("libertbench_models.so"), std::string::npos) << frames.output;
  }
}

TEST(Program, ReadmesSolverAndExperimentWork) {
  const TemporaryFolder folder("readme");
  json experiment = json::parse(read_text(ERTBENCH_PAGE_EXPERIMENT));
  experiment["plugins"] = {ERTBENCH_PAGE_PLUGIN};
  experiment["solvers"].push_back({{"type", "back-projection"}, {"gain", 0.05}});
  experiment["datasets"]["validation"]["count"] = 20;
  experiment["datasets"]["test"]["count"] = 20;
  experiment["timing"] = {{"enabled", false}};
  write_text(folder / "readme.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run readme.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json summary = summary_of(folder / "results/readme");
  for (const char* label : {"one-step-gn", "tsvd", "pdipm", "back-projection"}) {
    EXPECT_EQ(row_of(summary, label).at("status"), "ok");
  }
  // It smears, but it points at the contacts.
  EXPECT_LT(row_of(summary, "back-projection").at("metrics").at("relative_error").at("mean"), 1);
}

TEST(Program, GenerateWritesTheNamedDataset) {
  const TemporaryFolder folder("generate");
  write_text(folder / "small.json", small_experiment().dump());
  const Outcome outcome =
      run_program(folder.path(), "generate small.json --dataset test --out test.h5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(DatasetFile(folder / "test.h5").size(), 40u);
  EXPECT_EQ(run_program(folder.path(), "generate small.json").exit_code, 0);
  const Outcome unknown =
      run_program(folder.path(), "generate small.json --dataset tset --out x.h5");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.output.find("validation, test"), std::string::npos) << unknown.output;
  const Outcome nowhere =
      run_program(folder.path(), "generate small.json --dataset test --out absent/x.h5");
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_NE(nowhere.output.find("folder"), std::string::npos) << nowhere.output;
}

TEST(Program, SaysWhereTheVoltagesMissTheirModelError) {
  const TemporaryFolder folder("missed_promise");
  nlohmann::json experiment = small_experiment();
  nlohmann::json& test = experiment["datasets"]["test"];
  test["count"] = 2;
  test["grid"] = "auto";
  test["model_error"] = 1e-6;  // of next to no noise: out of reach of contacts with corners
  test["snr_db"] = 200;
  test["scenes"]["shapes"] = {"rectangle"};
  experiment.erase("figure");
  write_text(folder / "small.json", experiment.dump());
  const std::string sentence =
      "2 of 2 scenes have voltages whose estimated error is above 1e-06 of "
      "the noise, at most ";
  for (const char* arguments :
       {"generate small.json --dataset test --out test.h5", "generate small.json",
        "generate small.json", "run small.json --out out"}) {
    const Outcome outcome = run_program(folder.path(), arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    const std::size_t where = outcome.output.find("test: " + sentence);
    EXPECT_NE(where, std::string::npos) << arguments << ": " << outcome.output;
    EXPECT_EQ(outcome.output.find(sentence, where + 10), std::string::npos) << "said twice";
  }
  EXPECT_NE(read_text(folder / "out/table.md").find(sentence), std::string::npos);
  EXPECT_NE(read_text(folder / "out/report.html").find(sentence), std::string::npos);
  const nlohmann::json missed = summary_of(folder / "out").at("missed_promises").at("test");
  EXPECT_EQ(missed.at("scenes"), 2);
  EXPECT_EQ(missed.at("sentence").get<std::string>().find(sentence), 0u);
}

/// EIDORS's frames and what EIDORS makes of them.
TEST(Program, ReconstructsFramesOfEidors) {
  const TemporaryFolder folder("reconstruct");
  const Hdf5File eidors = Hdf5File::open(ERTBENCH_TEST_DATA "/eidors_d2s.h5");
  {
    Hdf5File frames = Hdf5File::create(folder / "frames.h5");
    frames.write_matrix("/voltages", eidors.read_rows("/scenes/voltages", 0, 6));
    frames.write_vector("/reference_voltages", eidors.read_vector("/reference_voltages"));
  }
  const std::pair<const char*, const char*> cases[] = {
      {"gn_tikhonov", R"({"type": "one-step-gn", "prior": "tikhonov", "lambda": 0.03})"},
      {"gn_noser", R"({"type": "one-step-gn", "prior": "noser", "lambda": 0.1})"},
      {"gn_laplace", R"({"type": "one-step-gn", "prior": "laplace", "lambda": 0.01})"},
      {"tsvd", R"({"type": "tsvd", "threshold": 0.01})"}};
  for (const auto& [image, spec] : cases) {
    SCOPED_TRACE(image);
    write_text(folder / "solver.json", spec);
    const Outcome outcome = run_program(
        folder.path(), "reconstruct --solver solver.json --input frames.h5 --output images.h5");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    const Hdf5File images = Hdf5File::open(folder / "images.h5");
    EXPECT_EQ(images.shape("/conductivity_change"), (std::vector<std::uint64_t>{6, 24, 24}));
    EXPECT_EQ(images.read_vector("/status"), Eigen::VectorXd::Zero(6));
    const RowMajorMatrix mine = images.read_rows("/conductivity_change", 0, 6);
    const RowMajorMatrix theirs = eidors.read_rows(std::string("/images/") + image, 0, 6);
    EXPECT_LT((mine - theirs).norm(), 1e-8 * theirs.norm());
  }
}

TEST(Program, ReconstructSaysWhichFramesAreNotToBeTrusted) {
  const TemporaryFolder folder("suspect");
  const Hdf5File eidors = Hdf5File::open(ERTBENCH_TEST_DATA "/eidors_d2s.h5");
  RowMajorMatrix voltages = eidors.read_rows("/scenes/voltages", 0, 3);
  const std::vector<Channel> channels = channels_of(Sensor{});
  for (std::size_t c = 0; c < channels.size(); ++c) {
    // Electrode 5 belongs to the pairs 4 and 5.
    const bool dead = channels[c].drive / 2 * 2 == 4 || channels[c].measurement / 2 * 2 == 4;
    if (dead) voltages(1, static_cast<Eigen::Index>(c)) = 0;
  }
  {
    Hdf5File frames = Hdf5File::create(folder / "frames.h5");
    frames.write_matrix("/voltages", voltages);
    frames.write_vector("/reference_voltages", eidors.read_vector("/reference_voltages"));
  }
  const auto run = [&](const char* spec) {
    write_text(folder / "solver.json", spec);
    return run_program(folder.path(),
                       "reconstruct --solver solver.json --input frames.h5 --output images.h5");
  };
  const Outcome plain = run(R"({"type": "tsvd", "rank": 45})");
  EXPECT_NE(plain.output.find("1 suspect\n  1 with a dead electrode"), std::string::npos)
      << plain.output;
  {
    const Hdf5File images = Hdf5File::open(folder / "images.h5");
    EXPECT_EQ(images.read_vector("/status"), Eigen::Vector3d(0, 3, 0));
    EXPECT_EQ(images.read_vector("/reason"), Eigen::Vector3d(0, 1, 0));
  }
  const Outcome masked = run(R"({"type": "tsvd", "rank": 45, "channel_mask": "detect"})");
  EXPECT_NE(masked.output.find("0 suspect\n  1 with a dead electrode"), std::string::npos)
      << masked.output;
  const Hdf5File images = Hdf5File::open(folder / "images.h5");
  EXPECT_EQ(images.read_vector("/status"), Eigen::Vector3d::Zero());
  EXPECT_EQ(images.read_vector("/reason"), Eigen::Vector3d(0, 1, 0));
}

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
      {"reconstruct --solver good.json --input nan.h5" TO, "/voltages: element 7 of row 1"},
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

/// Random damage: whatever happens, it ends, with code 0 or 2, and leaves no half-written output.
TEST(Program, DamagedFramesNeverCrash) {
  const TemporaryFolder folder("damage");
  write_text(folder / "solver.json", R"({"type": "tsvd", "rank": 30})");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(
      run_program(folder.path(), "generate small.json --dataset test --out good.h5").exit_code, 0);
  const std::string good = read_text(folder / "good.h5");
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  int refused = 0;
  constexpr int attempts = 40;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    std::string bytes = good;
    if (attempt % 4 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      // The headers, spread over the file's first kilobytes and its end, are where it hurts.
      for (int i = 0; i < 1 + attempt % 16; ++i) {
        const std::size_t reach = std::min<std::size_t>(bytes.size(), 6000);
        const std::size_t at = random() % reach;
        bytes[attempt % 2 ? at : bytes.size() - 1 - at] = static_cast<char>(random());
      }
    }
    write_text(folder / "bad.h5", bytes);
    const Outcome outcome = run_program(
        folder.path(), "reconstruct --solver solver.json --input bad.h5 --output out.h5");
    EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 2)
        << outcome.exit_code << ": " << outcome.output;
    if (outcome.exit_code == 2) {
      ++refused;
      EXPECT_NE(outcome.output.find("bad.h5"), std::string::npos) << outcome.output;
      EXPECT_FALSE(fs::exists(folder / "out.h5"));
    }
    fs::remove(folder / "out.h5");
  }
  EXPECT_GE(refused, attempts / 4);
}

TEST(Program, HelpShowsAnExampleOfEachCommand) {
  const TemporaryFolder folder("help");
  for (const std::string command :
       {"run", "check", "generate", "reconstruct", "list", "timing", "fidelity"}) {
    const Outcome outcome = run_program(folder.path(), command + " --help");
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.output.find("ertbench " + command), std::string::npos) << outcome.output;
  }
  const Outcome list = run_program(folder.path(), "list");
  EXPECT_EQ(list.exit_code, 0);
  for (const char* name : {"one-step-gn", "tsvd", "pdipm", "fcnn", "dcnn", "eit-nn", "dd-ert",
                           "lean-net", "lambda", "table_c1.json"}) {
    EXPECT_NE(list.output.find(name), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace ertbench
