// Exported code is compiled by the system's compilers, called, and held against the program's own
// images and contacts, and on machines that QEMU has.

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>
#include <regex>
#include <sstream>

#include "core/errors.h"
#include "runtime/layer_file.h"
#include "tests/export/export_testing.h"

namespace ertbench::testing {
namespace {

TEST_F(Export, ImagesAndContactsAreTheProgramsInEachMethod) {
  for (const std::string& solver : methods()) {
    SCOPED_TRACE(solver);
    const FloatRows found = answers(exported(solver, "float32"));
    ASSERT_EQ(found.rows(), frames);
    const Eigen::MatrixXd own = images(solver);
    EXPECT_LE(relative_difference(found.leftCols(pixels).cast<double>(), own), 1e-6);
    for (int f = 0; f < frames; ++f) {
      const Eigen::RowVectorXd image = found.row(f).head(pixels).cast<double>();
      // Numbers within a network are of order 1, however weak the image, and are rounded to 6e-8:
      // the code of lean-net-8 is up to 1.2e-6 from its own evaluation in doubles, 0.3e-6 as a
      // median, and the program rounds as well, in an order that depends on the processor.
      EXPECT_LE((image - own.row(f)).cwiseAbs().maxCoeff(), 2e-6 * Sensor{}.background);
      expect_contacts(found.row(f).tail(contact_numbers), contacts_of_image({}, {}, image));
    }
  }
}

TEST_F(Export, CoarseWeightsCostLittle) {
  for (const std::string solver : {"tsvd", "lmmse", "fcnn-288", "eit-nn-288", "lean-net-8"}) {
    SCOPED_TRACE(solver);
    const Eigen::MatrixXd own = images(solver);
    // Half precision rounds to 2^-11, 8 bits to 2^-8 of an output's largest weight.
    for (const auto& [precision, most] : {std::pair{"float16", 0.004}, std::pair{"int8", 0.05}}) {
      const FloatRows found = answers(exported(solver, precision));
      ASSERT_EQ(found.rows(), frames);
      EXPECT_LE(relative_difference(found.leftCols(pixels).cast<double>(), own), most) << precision;
    }
  }
}

TEST_F(Export, AMixtureInHalfPrecisionCostsLittle) {
  const FloatRows found = answers(exported(mixture(), "float16"));
  EXPECT_LE(relative_difference(found.leftCols(pixels).cast<double>(), images(mixture())), 0.004);
}

TEST_F(Export, VoltagesBeyondTheRangeAreItsEnds) {
  const fs::path folder = exported("lean-net-8", "int8");
  FloatRows numbers = floats_of(path() / "frames.bin", 208).topRows(5);
  numbers.bottomRows(4).rowwise() = numbers.row(0).eval();
  numbers.col(7).tail(4) << 1e3F, 3e38F, -1e3F, -3e38F;
  write(folder / "far.bin", numbers);
  ASSERT_EQ(shell(folder, "./program images < far.bin > far.out").exit_code, 0);
  const FloatRows found = floats_of(folder / "far.out", pixels + contact_numbers);
  ASSERT_EQ(found.rows(), 4);
  EXPECT_EQ(found.row(0), found.row(1));
  EXPECT_EQ(found.row(2), found.row(3));
  EXPECT_NE(found.row(0), found.row(2));
}

TEST_F(Export, CompilesWithoutWarningByClang) {
  if (!has("clang")) GTEST_SKIP() << "no clang";
  for (const char* precision : {"float32", "float16", "int8"}) {
    EXPECT_EQ(answers(exported("lean-net-8", precision, "clang")).rows(), frames);
  }
}

TEST_F(Export, ContactsOfAnyImageAreTheRules) {
  // Noise has dozens of maxima of both signs, and blocks of equal numbers have plateaus.
  FloatRows given(40, pixels);
  given = random_matrix(40, pixels, 3).cast<float>();
  for (int f = 20; f < 40; ++f) {
    for (int p = 0; p < pixels; ++p) given(f, p) = given(f, (p / 24 / 4 * 24 + p % 24 / 3) * 2);
  }
  const fs::path folder = exported("tsvd", "float32");
  write(folder / "images.bin", given);
  const Outcome ran = shell(folder, "./program contacts < images.bin > contacts.bin");
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  const FloatRows found = floats_of(folder / "contacts.bin", contact_numbers);
  ASSERT_EQ(found.rows(), 40);
  for (int f = 0; f < 40; ++f) {
    SCOPED_TRACE(f);
    expect_contacts(found.row(f), contacts_of_image({}, {}, given.row(f).cast<double>()));
  }
}

TEST_F(Export, TheRuntimeGivesTheProgramsImagesAndContactsAndAllocatesNothing) {
  const FloatRows given = floats_of(path() / "frames.bin", 208);
  for (const std::string& solver : methods()) {
    SCOPED_TRACE(solver);
    const Outcome written = run_program(
        path(), "export " + solver + " --to runtime --threshold 0.25 --floor 0 --out runtime");
    ASSERT_EQ(written.exit_code, 0) << written.output;
    runtime::Solver loaded = runtime::Solver::load(stem(solver), path() / "runtime");
    ASSERT_EQ(loaded.channels(), 208);
    loaded.set_reference({given.row(0).data(), 208});
    const Eigen::MatrixXd own = images(solver);
    FloatRows images(frames, pixels);
    std::array<runtime::Contact, most_contacts> contacts;
    std::vector<int> counts(frames);
    FloatRows numbers = FloatRows::Zero(frames, contact_numbers);
    const std::size_t before = allocations();
    for (int f = 0; f < frames; ++f) {
      loaded.reconstruct({given.row(f + 1).data(), 208}, {images.row(f).data(), pixels});
      const int count = loaded.contacts({images.row(f).data(), pixels}, contacts);
      numbers(f, 0) = static_cast<float>(count);
      for (int i = 0; i < count; ++i) {
        const runtime::Contact& one = contacts[static_cast<std::size_t>(i)];
        float* const to = &numbers(f, 1 + 5 * i);
        std::tie(to[0], to[1], to[2], to[3], to[4]) =
            std::tie(one.x_mm, one.y_mm, one.strength, one.peak, one.area_mm2);
      }
    }
    EXPECT_EQ(allocations(), before);
    for (int f = 0; f < frames; ++f) {
      const Eigen::RowVectorXd image = images.row(f).cast<double>();
      EXPECT_LE((image - own.row(f)).cwiseAbs().maxCoeff(), 1e-6 * Sensor{}.background);
      expect_contacts(numbers.row(f), contacts_of_image({}, {}, image));
    }
  }
}

TEST_F(Export, TheRuntimeRefusesFilesThatAreDamaged) {
  ASSERT_EQ(run_program(path(), "export lean-net-8 --to runtime --out damaged").exit_code, 0);
  const fs::path file = path() / "damaged/lean-net-8.ert";
  const std::string sound = text_of(file);
  const auto refused = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    try {
      runtime::Solver::load(file);
    } catch (const std::runtime_error& error) {
      return std::string(error.what()).find("lean-net-8.ert: ") != std::string::npos;
    }
    return false;
  };
  for (std::size_t size = 0; size < sound.size(); size += 1 + sound.size() / 40) {
    EXPECT_TRUE(refused(sound.substr(0, size))) << size;
  }
  std::mt19937 random(4);
  for (int i = 0; i < 40; ++i) {
    std::string bytes = sound;
    bytes[random() % bytes.size()] ^= static_cast<char>(1 + random() % 255);
    EXPECT_TRUE(refused(bytes)) << i;
  }
  EXPECT_TRUE(refused("{}"));
  EXPECT_THROW(runtime::Solver::load("no-such", path()), std::runtime_error);

  // Numbers that contradict each other, under a right checksum.
  const runtime::LayerFile whole = runtime::layer_file_from(sound);
  for (const auto& change : std::vector<std::function<void(runtime::LayerFile&)>>{
           [](auto& f) { f.channels = 207; }, [](auto& f) { f.rows = 1 << 20; },
           [](auto& f) { f.columns = -24; }, [](auto& f) { f.no_sheet = {576}; },
           [](auto& f) { f.list.scale.pop_back(); }, [](auto& f) { f.list.layers.clear(); },
           [](auto& f) { f.list.layers.front().width = 0; },
           [](auto& f) { f.list.layers.back().inputs = {99}; },
           [](auto& f) { f.list.layers.back().kind = static_cast<Layer::Kind>(77); }}) {
    runtime::LayerFile wrong = whole;
    change(wrong);
    EXPECT_TRUE(refused(runtime::bytes_of(wrong)));
  }
  for (std::size_t i = 0; i < whole.list.layers.size(); ++i) {
    for (const auto& change : std::vector<std::function<void(Layer&)>>{
             [](auto& l) { l.channels += 1; },
             [](auto& l) { (l.kind == Layer::Kind::convolution ? l.kernel : l.stride) = 1 << 15; },
             [](auto& l) { l.padding = -1; }, [](auto& l) { l.height *= 2; },
             [](auto& l) { l.stride = 0; }}) {
      runtime::LayerFile wrong = whole;
      change(wrong.list.layers[i]);
      EXPECT_TRUE(refused(runtime::bytes_of(wrong))) << i;
    }
    if (whole.list.layers[i].weights.empty()) continue;
    runtime::LayerFile wrong = whole;
    wrong.list.layers[i].weights.pop_back();
    EXPECT_TRUE(refused(runtime::bytes_of(wrong))) << i;
  }
  EXPECT_FALSE(refused(runtime::bytes_of(whole)));
}

TEST_F(Export, AMatrixIsReadByOthers) {
  const Outcome written = run_program(path(), "export lmmse --to matrix --out matrix");
  ASSERT_EQ(written.exit_code, 0) << written.output;
  const Outcome read = shell(path() / "matrix", R"(python3 -c "
import ast, struct, zipfile
with zipfile.ZipFile(\"matrix.npz\") as archive:
    assert archive.testzip() is None
    bytes_ = archive.read(\"matrix.npy\")
size, = struct.unpack(\"<H\", bytes_[8:10])
header = ast.literal_eval(bytes_[10:10 + size].decode())
assert header == {\"descr\": \"<f4\", \"fortran_order\": False, \"shape\": (576, 208)}, header
assert (10 + size) % 64 == 0
numbers = struct.unpack(\"<119808f\", bytes_[10 + size:])
lines = [[float(word) for word in line.split(\",\")] for line in open(\"matrix.csv\")]
assert [len(line) for line in lines] == 576 * [208]
assert all(abs(a - b) <= 1e-7 * abs(b) for a, b in zip(numbers, sum(lines, [])))
")");
  EXPECT_EQ(read.exit_code, 0) << read.output;
  Eigen::MatrixXd matrix(pixels, 208);
  std::ifstream csv(path() / "matrix/matrix.csv");
  char comma = 0;
  for (int p = 0; p < pixels; ++p) {
    for (int c = 0; c < 208; ++c) {
      csv >> matrix(p, c);
      if (c < 207) csv >> comma;
    }
  }
  const Hdf5File in = Hdf5File::open(path() / "rounded.h5");
  Frames changes = in.read_rows("/voltages", 0, frames);
  changes.rowwise() -= in.read_vector("/reference_voltages").transpose();
  EXPECT_LE(relative_difference(changes * matrix.transpose(), images("lmmse")), 1e-6);
}

TEST_F(Export, WhatCannotBeExportedIsSaid) {
  const auto said = [&](const std::string& words) {
    const Outcome outcome = run_program(path(), "export " + words + " --out refused");
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_FALSE(fs::exists(path() / "refused"));
    return outcome.output;
  };
  EXPECT_NE(said("contacts").find("has no layers"), std::string::npos);
  EXPECT_NE(said("tsvd --floor nan").find("must be a finite number"), std::string::npos);
  EXPECT_NE(said("tsvd --threshold 2").find("--threshold"), std::string::npos);
  EXPECT_NE(said("lean-net-9").find("did you mean \"lean-net-8\""), std::string::npos);
  EXPECT_NE(said("tsvd --precision int8").find("--frames"), std::string::npos);
  EXPECT_NE(said("lean-net-8 --to matrix").find("--to c"), std::string::npos);
  EXPECT_NE(said(mixture() + " --precision int8 --frames frames.h5").find("float16"),
            std::string::npos);
  EXPECT_NE(said("lean-net-8 --to onnx --precision int8").find("--to c has"), std::string::npos);
  EXPECT_NE(said("lean-net-8-rugged --to onnx").find("has no front"), std::string::npos);
  EXPECT_NE(said("tsvd --front --to matrix").find("--to c or --to runtime"), std::string::npos);
  std::ofstream(path() / "frames.txt") << "none";
  EXPECT_NE(said("tsvd --frames frames.txt").find("frames.txt"), std::string::npos);
}

TEST_F(Export, AFileThatIsNoExportIsKept) {
  fs::create_directories(path() / "mine");
  std::ofstream(path() / "mine/solver.c") << "int mine;\n";
  const Outcome outcome = run_program(path(), "export tsvd --out mine");
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  EXPECT_EQ(text_of(path() / "mine/solver.c"), "int mine;\n");
}

TEST_F(Export, TheNameOfAFileIsNoCode) {
  const std::string name = "x*& $(y) int no_such; .fitted";
  fs::copy_file(ERTBENCH_SOURCE_DIR "/results/networks/tsvd.fitted", path() / name);
  const Outcome outcome = run_program(path(), "export '" + name + "' --out named");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(text_of(path() / "named/solver.c").rfind("/* x y int no_such .fitted: ", 0), 0U);
}

TEST_F(Export, IsARowLikeAnySolver) {
  const DatasetFile validation(path() / "frames.h5");
  FitInput input;
  input.validation = &validation;
  const auto make = [](const char* precision) {
    return make_solver({{"type", "exported"}, {"of", "tsvd"}, {"precision", precision}});
  };
  Frames changes = validation.voltages(0, frames);
  changes.rowwise() -= validation.reference_voltages().transpose();
  const Images own = images("tsvd");
  for (const auto& [precision, most] : {std::pair{"float32", 1e-5}, std::pair{"int8", 0.05}}) {
    const std::unique_ptr<Solver> solver = make(precision);
    solver->fit(input);
    const Images fitted = reconstruct(*solver, changes).images;
    EXPECT_LE(relative_difference(fitted, own), most) << precision;
    const fs::path file = path() / (std::string(precision) + ".fitted");
    solver->save(file);
    const std::unique_ptr<Solver> loaded = make(precision);
    loaded->load(file, {});
    EXPECT_EQ(reconstruct(*loaded, changes).images, fitted);
  }
  EXPECT_THROW(make("int4"), InputError);
  EXPECT_THROW(fitted({{"type", "exported"}, {"of", "tsvd"}, {"precision", "int8"}}), InputError);
}

TEST_F(Export, OtherMachinesGiveTheSameBits) {
  if (!has("arm-none-eabi-gcc") || !has("qemu-system-arm")) GTEST_SKIP() << "no Cortex-M here";
  const Outcome outcome =
      shell(path(), "ERTBENCH=" ERTBENCH_PROGRAM " " ERTBENCH_SOURCE_DIR
                    "/solvers/export/fits --frames frames.h5 --frames-run 2 lean-net-8:int8 "
                    "tsvd:float32 tsvd:float16");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("| no |"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("| int8 | Cortex-M7"), std::string::npos) << outcome.output;
}

TEST_F(Export, TheCommandsOfThePageWork) {
  const std::string page = text_of(ERTBENCH_SOURCE_DIR "/docs/robot.md");
  const std::regex block("```sh\n([^`]*)```");
  std::string commands;
  for (auto at = std::sregex_iterator(page.begin(), page.end(), block);
       at != std::sregex_iterator(); ++at) {
    commands += (*at)[1];
  }
  ASSERT_FALSE(commands.empty());
  // The front page has some of them.
  const std::string front = text_of(ERTBENCH_SOURCE_DIR "/README.md");
  std::size_t start = front.find("```sh\n", front.find("## Run it on your robot")) + 6;
  for (std::size_t end; (end = front.find('\n', start)), front[start] != '`'; start = end + 1) {
    const std::string line = front.substr(start, end + 1 - start);
    EXPECT_NE(commands.find(line), std::string::npos) << line;
  }
  // The page's empty.csv: the reference with noise of 60 dB.
  const DatasetFile set(path() / "frames.h5");
  const fs::path folder = path() / "page";
  fs::create_directories(folder);
  std::ofstream csv(folder / "empty.csv");
  const Eigen::MatrixXd noise = random_matrix(24, 208, 5);
  const double size = 1e-3 * set.reference_voltages().norm() / std::sqrt(208.0);
  for (int f = 0; f < 24; ++f) {
    for (int c = 0; c < 208; ++c) {
      csv << (c == 0 ? "" : ",") << set.reference_voltages()[c] + size * noise(f, c);
    }
    csv << '\n';
  }
  csv.close();
  fs::copy_file(path() / "rounded.h5", folder / "presses.h5");
  for (const char* place : {"sensors", "experiments"}) {
    fs::create_directory_symlink(fs::path(ERTBENCH_SOURCE_DIR) / place, folder / place);
  }
  std::ofstream(folder / "page.sh") << "set -ex\n" << commands;
  fs::create_symlink(ERTBENCH_PROGRAM, folder / "ertbench");
  const Outcome outcome = shell(folder, "bash page.sh");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  // A line with an empty cell is no frame, and the next one is not read into it.
  const Outcome gap =
      shell(folder, "(head -1 empty.csv; sed -n '2s/,[^,]*,/,,/p' empty.csv) | ./contacts");
  EXPECT_EQ(gap.exit_code, 1);
  EXPECT_NE(gap.output.find("frame 1: must be a line of 208 numbers"), std::string::npos)
      << gap.output;
}

}  // namespace
}  // namespace ertbench::testing
