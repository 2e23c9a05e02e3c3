#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/fem/forward_model.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

class Dataset : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("ertbench_dataset_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static DatasetSpec spec(std::uint64_t count, int grid = 24) {
    const nlohmann::json json = {{"count", count},
                                 {"seed", 5},
                                 {"grid", grid},
                                 {"snr_db", 50},
                                 {"snr_basis", "absolute"},
                                 {"scenes", {{"blank_fraction", 0.1}}}};
    return dataset_spec_from_json(JsonObject(json, "test", ""), Sensor{}, "train");
  }
  static std::string bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  fs::path folder_;
};

TEST_F(Dataset, HoldsWhatItsSpecSays) {
  const fs::path file = folder_ / "a.h5";
  const DatasetSpec s = spec(300, 48);
  generate_dataset(s, file);
  EXPECT_FALSE(fs::exists(folder_ / "a.h5.part"));
  const DatasetFile set(file);
  ASSERT_EQ(set.size(), 300u);
  EXPECT_EQ(set.sensor(), s.sensor);
  EXPECT_EQ(nlohmann::json::parse(set.recipe()), to_json(s));
  const ForwardModel model(s.sensor, 48);
  EXPECT_EQ(set.reference_voltages(), model.reference_voltages());
  const Frames clean = set.clean_voltages(0, 300);
  const Frames noisy = set.voltages(0, 300);
  const Images truth = set.conductivity(0, 300);
  const std::vector<Scene> scenes = set.scenes(0, 300);
  int blank = 0;
  for (Eigen::Index i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    // From the file's own contacts to its voltages and image.
    Eigen::VectorXd fine(48 * 48);
    Eigen::VectorXd coarse(576);
    const Scene& scene = scenes[static_cast<std::size_t>(i)];
    blank += scene.contacts.empty();
    rasterise(scene, square_sheet()->pixels(48), Rasterisation::area, fine);
    rasterise(scene, square_sheet()->pixels(24), Rasterisation::area, coarse);
    EXPECT_LT((truth.row(i).transpose() - 0.06 * coarse).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((clean.row(i) - model.solve(0.06 * fine.transpose())).norm(),
              1e-9 * clean.row(i).norm());
    EXPECT_NEAR((noisy.row(i) - clean.row(i)).norm(), clean.row(i).norm() * std::pow(10, -2.5),
                1e-12);
  }
  EXPECT_GT(blank, 5);
}

TEST_F(Dataset, DoesNotDependOnThreads) {
  generate_dataset(spec(1500), folder_ / "one.h5", {1, {}});
  generate_dataset(spec(1500), folder_ / "two.h5", {2, {}});
  EXPECT_TRUE(bytes(folder_ / "one.h5") == bytes(folder_ / "two.h5"));
}

TEST_F(Dataset, ScenesDoNotDependOnTheCountButOnTheName) {
  generate_dataset(spec(10), folder_ / "few.h5");
  generate_dataset(spec(50), folder_ / "many.h5");
  const DatasetFile few(folder_ / "few.h5");
  const DatasetFile many(folder_ / "many.h5");
  EXPECT_EQ(few.voltages(0, 10), many.voltages(0, 10));
  DatasetSpec other = spec(10);
  other.name = "test";
  generate_dataset(other, folder_ / "other.h5");
  EXPECT_NE(few.voltages(0, 1), DatasetFile(folder_ / "other.h5").voltages(0, 1));
}

/// Kills the writer after each of several blocks; what is left must be refused, and continued.
TEST_F(Dataset, KilledWriterLeavesNothingWholeAndGoesOn) {
  const fs::path file = folder_ / "killed.h5";
  const DatasetSpec s = spec(5000);
  for (const std::uint64_t stop_at : {1024u, 3072u}) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      generate_dataset(s, file, {1, [&](std::uint64_t done, std::uint64_t) {
                                   if (done >= stop_at) raise(SIGKILL);
                                 }});
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_FALSE(fs::exists(file));
    fs::path part = file;
    part += ".part";
    ASSERT_TRUE(fs::exists(part));
    EXPECT_THROW(DatasetFile{part}, InputError)
        << "an unfinished file must not pass for a whole one";
  }
  std::uint64_t first_seen = 0;
  generate_dataset(s, file, {1, [&](std::uint64_t done, std::uint64_t) {
                               if (first_seen == 0) first_seen = done;
                             }});
  EXPECT_GT(first_seen, 3072u) << "finished blocks must not be computed again";
  generate_dataset(s, folder_ / "whole.h5");
  EXPECT_TRUE(bytes(file) == bytes(folder_ / "whole.h5"));
}

/// While it lives, no file of this process grows over so many bytes: a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit full = {bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &full);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(Dataset, FailureBeforeTheFirstWholeSceneLeavesNothing) {
  const FullDisk disk(64 << 10);  // the images of 20 scenes take 92 kB
  EXPECT_THROW(generate_dataset(spec(20), folder_ / "full.h5"), InputError);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Dataset, FailureLaterSaysWhereTheSameCommandGoesOn) {
  const fs::path file = folder_ / "failed.h5";
  std::string message;
  try {
    generate_dataset(spec(1500), file, {1, [](std::uint64_t, std::uint64_t) {
                                          throw InputError("the disk is full");
                                        }});
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_EQ(message, "the disk is full; the same command goes on behind scene 1024");
  generate_dataset(spec(1500), file);
  generate_dataset(spec(1500), folder_ / "whole.h5");
  EXPECT_TRUE(bytes(file) == bytes(folder_ / "whole.h5"));
}

TEST_F(Dataset, PartOfAnotherSpecIsNotContinued) {
  const fs::path file = folder_ / "b.h5";
  fs::path part = file;
  part += ".part";
  generate_dataset(spec(20), part);  // a file of other scenes under the part's name
  DatasetSpec s = spec(20);
  s.seed = 6;
  generate_dataset(s, file);
  generate_dataset(s, folder_ / "c.h5");
  EXPECT_TRUE(bytes(file) == bytes(folder_ / "c.h5"));
}

std::string refusal(const fs::path& file) {
  try {
    const DatasetFile set(file);
    set.voltages(0, set.size());
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST_F(Dataset, RefusesFilesThatAreNotWhole) {
  EXPECT_NE(refusal(folder_ / "absent.h5").find("does not exist"), std::string::npos);
  std::ofstream(folder_ / "text.h5") << "not HDF5";
  EXPECT_NE(refusal(folder_ / "text.h5").find("cannot be opened as HDF5"), std::string::npos);

  generate_dataset(spec(20), folder_ / "good.h5");
  ASSERT_EQ(refusal(folder_ / "good.h5"), "accepted");
  fs::copy(folder_ / "good.h5", folder_ / "cut.h5");
  fs::resize_file(folder_ / "cut.h5", fs::file_size(folder_ / "cut.h5") / 2);
  EXPECT_NE(refusal(folder_ / "cut.h5").find("cut.h5"), std::string::npos);

  {
    Hdf5File file = Hdf5File::create(folder_ / "shape.h5");
    file.write_matrix("/voltages", RowMajorMatrix::Ones(3, 200));
  }
  EXPECT_NE(refusal(folder_ / "shape.h5").find("/voltages: must have shape [N, 208], has [3, 200]"),
            std::string::npos)
      << refusal(folder_ / "shape.h5");

  fs::copy(folder_ / "good.h5", folder_ / "nan.h5");
  {
    Hdf5File file = Hdf5File::open_writable(folder_ / "nan.h5");
    RowMajorMatrix row = file.read_rows("/voltages", 7, 1);
    row(0, 17) = std::numeric_limits<double>::quiet_NaN();
    file.write_rows("/voltages", 7, row);
  }
  EXPECT_NE(refusal(folder_ / "nan.h5").find("/voltages: element 17 of row 7"), std::string::npos)
      << refusal(folder_ / "nan.h5");
}

TEST_F(Dataset, ReadsTheSensorItDescribes) {
  Hdf5File file = Hdf5File::create(folder_ / "frames.h5");
  EXPECT_EQ(sensor_of(file), Sensor{});
  file.write_text("/", "sensor", R"({"electrode_count": 8, "image_grid": 16})");
  const Sensor sensor = sensor_of(file);
  EXPECT_EQ(sensor.electrode_count, 8);
  EXPECT_EQ(sensor.channels(), 40);
}

TEST(Scene, JsonRoundTrip) {
  const nlohmann::json json = nlohmann::json::parse(R"({"contacts": [
      {"shape": "disc", "centre": [0.1, 0.2], "radius": 0.3, "conductivity_ratio": 0.5},
      {"shape": "ellipse", "centre": [0.1, 0.2], "semi_axes": [0.3, 0.1], "angle": 0.5,
       "conductivity_ratio": 0.5},
      {"shape": "rectangle", "centre": [0.1, 0.2], "half_sides": [0.3, 0.1], "angle": -0.5,
       "conductivity_ratio": 1.5},
      {"shape": "polygon", "vertices": [[0, 0], [0.5, 0], [0, 0.5]], "conductivity_ratio": 0.2}]})");
  const Scene scene = scene_from_json(JsonObject(json, "", ""), *square_sheet());
  EXPECT_EQ(to_json(scene), json);

  Eigen::RowVectorXd contacts(4 * dataset_layout::contact_columns);
  Eigen::RowVectorXd vertices(4 * 2 * 5);
  dataset_layout::pack(scene, contacts, vertices);
  const Scene back = dataset_layout::unpack(contacts, vertices);
  EXPECT_EQ(to_json(back), json);
}

}  // namespace
}  // namespace ertbench
