#pragma once

#include <gtest/gtest.h>

#include <array>
#include <fstream>

#include "bench/score/image_contacts.h"
#include "forward/data/generate.h"
#include "runtime/runtime.h"
#include "solvers/channel_mask.h"
#include "tests/bench/program.h"
#include "tests/export/allocations.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench::testing {

inline constexpr int frames = 60;
inline constexpr int pixels = 576;
inline constexpr int most_contacts = 8;  ///< ERT_MOST_CONTACTS
inline constexpr int contact_numbers = 1 + 5 * most_contacts;

/// What a shell says to a command in `folder`; its exit code comes first where it is not 0.
inline Outcome shell(const fs::path& folder, const std::string& command) {
  return run_program(folder, "-c " + quoted(command), "/bin/bash");
}

inline bool has(const std::string& program) {
  return shell("/", "command -v " + program).exit_code == 0;
}

inline std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline FloatRows floats_of(const fs::path& file, Eigen::Index columns) {
  const std::string bytes = text_of(file);
  const auto* first = reinterpret_cast<const float*>(bytes.data());
  const auto size = static_cast<Eigen::Index>(bytes.size() / sizeof(float));
  return Eigen::Map<const FloatRows>(first, size / columns, columns);
}

inline void write(const fs::path& file, const FloatRows& numbers) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(numbers.data()),
             static_cast<std::streamsize>(sizeof(float)) * numbers.size());
}

/// Frames of random contacts whose voltages are floats: a dataset, and what the C code reads.
class Export : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    generate_dataset(random_contacts(frames), path() / "frames.h5");
    const DatasetFile set(path() / "frames.h5");
    FloatRows numbers(frames + 1, 208);
    numbers.row(0) = set.reference_voltages().cast<float>();
    numbers.bottomRows(frames) = set.voltages(0, frames).cast<float>();
    record(numbers, "frames", "rounded");
    record(with_faults(numbers), "faults", "faults");
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static fs::path path() { return folder_->path(); }

  /// The reference and frames, for the exported code and for the program.
  static void record(const FloatRows& numbers, const std::string& binary, const std::string& name) {
    write(path() / (binary + ".bin"), numbers);
    Hdf5File rounded = Hdf5File::create(path() / (name + ".h5"));
    rounded.write_matrix("/voltages", numbers.bottomRows(frames).cast<double>());
    rounded.write_vector("/reference_voltages", numbers.row(0).cast<double>());
    rounded.close();
  }
  /// Exports into a folder of its name and compiles, without a warning, into `program`.
  static fs::path exported(const std::string& solver, const std::string& precision,
                           const std::string& compiler = "gcc", const std::string& more = "") {
    const std::string name = solver + "-" + precision;
    const Outcome written =
        run_program(path(), "export " + solver + more + " --precision " + precision +
                                " --frames frames.h5 --threshold 0.25 --floor 0"
                                " --out " +
                                name);
    EXPECT_EQ(written.exit_code, 0) << written.output;
    const Outcome compiled =
        shell(path() / name, compiler +
                                 " -std=c99 -O2 -Wall -Wextra -Wconversion -pedantic -Werror -I. " +
                                 ERTBENCH_SOURCE_DIR
                                 "/tests/export/check.c solver.c weights.c -lm -o program"
                                 " && " +
                                 compiler +
                                 " -std=c99 -O2 -Wall -Wextra -pedantic -Werror example.c "
                                 "solver.c weights.c -lm -o example");
    EXPECT_EQ(compiled.exit_code, 0) << compiler << ": " << compiled.output;
    return path() / name;
  }
  static FloatRows answers(const fs::path& folder, const std::string& recording = "frames") {
    const Outcome ran = shell(folder, "./program images < ../" + recording + ".bin > answers.bin");
    EXPECT_EQ(ran.exit_code, 0) << ran.output;
    return floats_of(folder / "answers.bin", pixels + contact_numbers);
  }
  /// The program's images of the same frames [frames, pixels].
  static Eigen::MatrixXd images(const std::string& solver,
                                const std::string& recording = "rounded") {
    const std::string file = solver + ".images.h5";
    std::string named = solver;
    if (solver.ends_with(".fitted")) {
      named = solver + ".json";
      std::ofstream(path() / named)
          << R"({"type": ")" << stem(solver) << R"(", "checkpoint": ")" << solver << '"'
          << (stem(solver) == "lmmse" ? R"(, "components": 8})" : "}");
    }
    const Outcome ran = run_program(path(), "reconstruct --force --solver " + named + " --input " +
                                                recording + ".h5 --output " + file);
    EXPECT_EQ(ran.exit_code, 0) << ran.output;
    return Hdf5File::open(path() / file).read_rows("/conductivity_change", 0, frames);
  }

  /// One to three electrodes that read zero or are loose, one that floats, another level, noise,
  /// one or two that read half, and nothing.
  static FloatRows with_faults(FloatRows numbers) {
    const std::vector<ElectrodeSet> users = electrode_sets_of_channels(Sensor{});
    const FloatRows random = random_matrix(frames, 208, 8).cast<float>();
    const float size = numbers.row(0).norm() / std::sqrt(208.0F);
    for (int f = 0; f < frames; ++f) {
      auto frame = numbers.row(f + 1);
      const int kind = f % 12 == 5 ? 6 : f % 6;
      ElectrodeSet dead = 0;
      for (int i = 0; kind < 4 && i < kind; ++i) dead |= ElectrodeSet{1} << (5 * f + i * i) % 16;
      const ElectrodeSet floating = kind == 4 ? ElectrodeSet{1} << f % 16 : 0;
      const ElectrodeSet half = kind == 6 ? ElectrodeSet{1} << f % 16 | ElectrodeSet{1} << 9 : 0;
      if (f % 4 == 3) frame *= 1 + 0.01F * static_cast<float>(f % 5);
      if (kind == 5) frame += 0.01F * size * random.row(f);
      for (int c = 0; c < 208; ++c) {
        const bool reads = f % 4 >= 2 && random(f, c) < 0;  // at times, as a loose one does
        if (users[static_cast<std::size_t>(c)] & dead && !reads) frame[c] = 0;
        if (users[static_cast<std::size_t>(c)] & floating) frame[c] = 0.3F * size * random(f, c);
        if (users[static_cast<std::size_t>(c)] & half) frame[c] *= 0.5F;
      }
    }
    return numbers;
  }
  /// The file of a small solver that is trained here.
  static std::string trained(const std::string& name, const std::string& settings) {
    const fs::path folder = path() / (name + "-trained");
    fs::create_directories(folder);
    std::ofstream(folder / "e.json") << R"({"datasets": {
      "train": {"count": 200, "seed": 1, "grid": 24, "snr_db": 50, "snr_basis": "absolute", "scenes": {}},
      "validation": {"count": 100, "seed": 2, "grid": 24, "snr_db": 50, "snr_basis": "absolute", "scenes": {}},
      "test": {"count": 20, "seed": 3, "grid": 24, "snr_db": 50, "snr_basis": "absolute", "scenes": {}}},
      "timing": {"enabled": false},
      "solvers": [{"type": ")" << name
                                     << R"(", )" << settings << "}]}";
    const Outcome ran = run_program(folder, "run e.json --out out");
    EXPECT_EQ(ran.exit_code, 0) << ran.output;
    for (const auto& file : fs::recursive_directory_iterator(folder / "cache")) {
      if (file.path().extension() != ".fitted") continue;
      fs::copy_file(file.path(), path() / (name + ".fitted"));
      break;
    }
    return name + ".fitted";
  }
  static const std::vector<std::string>& small_networks() {
    static const std::vector<std::string> names = {
        trained("dd-ert", R"("epochs": 6, "batch": 16, "width": 4, "convolutions": 1,
                             "discriminator_widths": [4, 8])"),
        trained("dcnn", R"("epochs": 6, "batch": 16, "widths": [8, 8, 16])")};
    return names;
  }
  /// An lmmse of several components.
  static const std::string& mixture() {
    static const std::string name = trained("lmmse", R"("components": 8)");
    return name;
  }
  /// Whose images are held against the program's, in C, the runtime and ONNX.
  static std::vector<std::string> methods() {
    return {"one-step-gn", "tsvd", "lmmse", mixture(), "fcnn-288", "eit-nn-288", "lean-net-8"};
  }
  static std::string stem(const std::string& solver) {
    return solver.substr(0, solver.find(".fitted"));
  }
  /// Images of a recording by the runtime library [frames, pixels].
  static FloatRows runtime_images(const std::string& solver, const std::string& recording,
                                  const std::string& more = "") {
    const Outcome written =
        run_program(path(), "export " + solver + more + " --to runtime --out runtime");
    EXPECT_EQ(written.exit_code, 0) << written.output;
    runtime::Solver loaded = runtime::Solver::load(stem(solver), path() / "runtime");
    const FloatRows given = floats_of(path() / (recording + ".bin"), 208);
    loaded.set_reference({given.row(0).data(), 208});
    FloatRows out(frames, pixels);
    const std::size_t before = allocations();
    for (int f = 0; f < frames; ++f) {
      loaded.reconstruct({given.row(f + 1).data(), 208}, {out.row(f).data(), pixels});
    }
    EXPECT_EQ(allocations(), before);
    return out;
  }

  inline static std::unique_ptr<TemporaryFolder> folder_;
};

inline void expect_contacts(const Eigen::Ref<const Eigen::RowVectorXf>& numbers,
                            const std::vector<FoundContact>& contacts) {
  const Sensor sensor;
  const double mm = sensor.sheet->unit_mm();
  ASSERT_EQ(numbers[0], std::min<std::size_t>(contacts.size(), most_contacts));
  for (int i = 0; i < static_cast<int>(numbers[0]); ++i) {
    const FoundContact& one = contacts[static_cast<std::size_t>(i)];
    const auto found = numbers.segment(1 + 5 * i, 5);
    EXPECT_NEAR(found[0], mm * one.place.x(), 1e-3);
    EXPECT_NEAR(found[1], mm * one.place.y(), 1e-3);
    EXPECT_NEAR(found[2], mm * mm * one.strength, 1e-5 * mm * mm * one.strength);
    EXPECT_NEAR(found[3], one.peak, 1e-6 * one.peak);
    EXPECT_NEAR(found[4], mm * mm * one.area, 1e-2);
  }
}

/// No pixel differs by more than this share of the background.
inline void expect_equal(const FloatRows& found, const Eigen::MatrixXd& own, double most) {
  ASSERT_EQ(found.rows(), own.rows());
  for (Eigen::Index f = 0; f < own.rows(); ++f) {
    EXPECT_LE((found.row(f).cast<double>() - own.row(f)).cwiseAbs().maxCoeff(),
              most * Sensor{}.background)
        << "frame " << f;
  }
}

}  // namespace ertbench::testing
