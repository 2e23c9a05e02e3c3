// The program with file names, words and a plugin's messages that are no text: it works or says
// what is wrong with exit code 2, and its output has nothing that a terminal would obey.

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "core/text.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

/// A name of a file and a word of the command line.
const std::string hostile_name = "a \x1b[31mred\xff\xc2\x9b\x33\x31m";

void expect_clean(const Outcome& outcome) {
  const std::vector<char32_t> points = code_points(outcome.output);
  EXPECT_FALSE(std::any_of(points.begin(), points.end(), [](char32_t point) {
    return point != U'\n' && point != U'\t' && is_control(point);
  })) << printable_lines(outcome.output);
  std::string again;
  for (const char32_t point : points) append_utf8(again, point);
  EXPECT_EQ(again, outcome.output) << "is no UTF-8";
}

TEST(HostileProgram, FileNamesAreShownHarmlessly) {
  const TemporaryFolder folder("names");
  json experiment = small_experiment();
  experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}}};
  write_text(folder / (hostile_name + ".json"), experiment.dump());
  const std::string file = quoted(hostile_name + ".json");
  const Outcome run = run_program(folder.path(), "run " + file + " --out " + quoted(hostile_name));
  EXPECT_EQ(run.exit_code, 0) << printable_lines(run.output);
  expect_clean(run);
  const json summary = summary_of(folder / hostile_name);  // and so is UTF-8
  EXPECT_EQ(summary.at("experiment"), printable(hostile_name));
  EXPECT_EQ(summary.at("command"), "./ertbench run '" + printable(hostile_name) + ".json' --out '" +
                                       printable(hostile_name) + "'");
  const Outcome generated = run_program(
      folder.path(), "generate " + file + " --dataset test --out " + quoted(hostile_name + ".h5"));
  EXPECT_EQ(generated.exit_code, 0) << printable_lines(generated.output);
  expect_clean(generated);
}

TEST(HostileProgram, WordsAreShownHarmlesslyAndInPart) {
  const TemporaryFolder folder("words");
  write_text(folder / "small.json", small_experiment().dump());
  const std::string word = quoted(hostile_name + std::string(3000, 'x'));
  for (const std::string& command :
       {word, "run " + quoted(hostile_name), "run small.json --only " + word,
        "run small.json " + word, "run small.json --jobs " + word,
        "generate small.json --dataset " + word, "check " + quoted(hostile_name),
        "reconstruct --solver " + quoted(hostile_name) + " --input a --output b", "list " + word}) {
    const Outcome outcome = run_program(folder.path(), command);
    SCOPED_TRACE(printable_lines(outcome.output));
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_LT(outcome.output.size(), 1500U);
    expect_clean(outcome);
  }
}

TEST(HostileProgram, APluginMaySayWhatItLikes) {
  const TemporaryFolder folder("plugin");
  json experiment = small_experiment();
  experiment["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  experiment["solvers"] = {
      {{"type", "misbehaving"}, {"how", "throw hostile text"}, {"label", "thrower"}},
      {{"type", "toy-learned"},
       {"how", "say hostile text"},
       {"seed", 1},
       {"bad_seed", 1},
       {"epochs", 3},
       {"epoch_s", 0.6},
       {"label", "talker"}}};
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json");
  EXPECT_EQ(outcome.exit_code, 1) << printable_lines(outcome.output);  // of the thrower
  expect_clean(outcome);
  const fs::path results = folder / "results/small";
  const json talker = row_of(summary_of(results), "talker");
  EXPECT_NE(talker.at("status"), "ok");
  EXPECT_TRUE(talker.at("metrics").at("RIE").at("mean").is_number());
  for (const char* file : {"table.md", "table.tex", "report.html"}) {
    const std::string text = read_text(results / file);
    EXPECT_EQ(text.find("<script>alert"), std::string::npos) << file;
    expect_clean({0, text});
  }
}

TEST(HostileProgram, NoInputAndNoForeignFileIsWrittenOver) {
  const TemporaryFolder folder("overwrite");
  write_text(folder / "small.json", small_experiment().dump());
  write_text(folder / "gn.json", R"({"type": "one-step-gn", "lambda": 0.1})");
  write_text(folder / "diary.txt", "dear diary");
  fs::create_directory(folder / "papers");
  ASSERT_EQ(
      run_program(folder.path(), "generate small.json --dataset test --out test.h5").exit_code, 0);
  fs::create_symlink("test.h5", folder / "link.h5");
  fs::create_hard_link(folder / "gn.json", folder / "hard.h5");
  const std::string reconstruct = "reconstruct --solver gn.json --input test.h5 --output ";
  const std::string generate = "generate small.json --dataset test --out ";
  const auto refused = [&](const std::string& command, const std::string& why) {
    const Outcome outcome = run_program(folder.path(), command);
    EXPECT_EQ(outcome.exit_code, 2) << command << "\n" << outcome.output;
    EXPECT_NE(outcome.output.find(why), std::string::npos) << command << "\n" << outcome.output;
  };
  const std::string before = read_text(folder / "test.h5");
  refused(reconstruct + "test.h5", "test.h5: is the input test.h5; name another output");
  refused(reconstruct + "link.h5", "link.h5: is the input test.h5");
  refused(reconstruct + "gn.json", "is the input gn.json");
  refused(reconstruct + "hard.h5", "is the input gn.json");
  refused(reconstruct + "diary.txt", "is there already and is no file of images");
  refused(reconstruct + "papers", "papers: is a directory");
  refused(generate + "small.json", "is the input");
  refused(generate + "diary.txt", "is there already and is no dataset");
  refused(generate + "papers", "papers: is a directory");
  write_text(folder / "new.h5.part", "a browser's");
  refused(generate + "new.h5", "new.h5.part: is there already and is no unfinished dataset");
  EXPECT_EQ(read_text(folder / "diary.txt"), "dear diary");
  EXPECT_EQ(read_text(folder / "new.h5.part"), "a browser's");
  EXPECT_EQ(read_text(folder / "test.h5"), before);
  for (const std::string& command : {reconstruct + "out.h5", generate + "test.h5"}) {
    for (int again = 0; again < 2; ++again) {
      EXPECT_EQ(run_program(folder.path(), command).exit_code, 0) << command;
    }
  }
  refused("reconstruct --solver gn.json --input test.h5 --output small.json", "no file of images");
  refused(generate + "out.h5", "is there already and is no dataset");
}

TEST(HostileProgram, ACheckpointIsNotWrittenOver) {
  const TemporaryFolder folder("checkpoint");
  {
    Hdf5File::create(folder / "net.h5")
        .write_matrix("/conductivity_change", RowMajorMatrix::Ones(1, 1));
  }
  write_text(folder / "net.json", R"({"type": "tsvd", "checkpoint": "net.h5"})");
  const Outcome outcome =
      run_program(folder.path(), "reconstruct --solver net.json --input a.h5 --output net.h5");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.output.find("net.h5: is the input"), std::string::npos) << outcome.output;
}

}  // namespace
}  // namespace ertbench
