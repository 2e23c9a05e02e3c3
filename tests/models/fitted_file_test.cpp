// The file of a fitted network is numbers: it runs nothing, and what does not belong to the network
// that it describes is refused by name.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>

#include "core/errors.h"
#include "tests/file_size_limit.h"
#include "tests/models/models_testing.h"
#include "tests/models/torch_archive.h"

namespace ertbench {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Number = Hdf5File::Number;
namespace fs = std::filesystem;

/// A dataset of a fitted network's file.
struct Tensor {
  Number number = Number::real32;
  std::vector<std::uint64_t> shape;
  RowMajorMatrix values;
};
using Tensors = std::map<std::string, Tensor>;

Number number_of(const Hdf5File& file, const std::string& dataset) {
  const bool real =
      message_of<InputError>([&] { file.require_number(dataset, Number::real32); }).empty();
  return real ? Number::real32 : Number::int64;
}

/// Copies a fitted network's file, its tensors changed.
void rewrite(const fs::path& from, const fs::path& to,
             const std::function<void(Tensors&)>& change) {
  const Hdf5File in = Hdf5File::open(from);
  Hdf5File out = Hdf5File::create(to);
  out.write_number("/", "format_version", in.read_number("/", "format_version"));
  for (const char* name : {"solver", "sensor", "parameters", "training"}) {
    out.write_text("/", name, in.read_text("/", name));
  }
  Tensors tensors;
  std::vector<std::string> names = {"/mean", "/scale"};
  for (const std::string& name : in.names("/network")) names.push_back("/network/" + name);
  for (const std::string& name : names) {
    const auto shape = in.shape(name);
    tensors[name] = {number_of(in, name), shape, in.read_rows(name, 0, shape[0])};
  }
  change(tensors);
  for (const auto& [name, tensor] : tensors) {
    out.create_dataset(name, tensor.shape, tensor.number);
    out.write_rows(name, 0, tensor.values);
  }
  out.close();
}

class FittedFile : public ::testing::Test {
 protected:
  static constexpr const char* stored = ERTBENCH_SOURCE_DIR "/results/baselines/networks/";

  /// What loading says of a stored network whose tensors were changed; nothing where it loads.
  std::string said_of(const std::string& type, const std::function<void(Tensors&)>& change) {
    rewrite(stored + (type + ".fitted"), folder_ / "changed.fitted", change);
    return said_of_loading(type, folder_ / "changed.fitted");
  }
  static std::string said_of_loading(const std::string& type, const fs::path& file) {
    return message_of<InputError>([&] { make_learned({{"type", type}})->load(file, Sensor{}); });
  }

  TemporaryFolder folder_;
};

TEST_F(FittedFile, RefusesByNameWhatIsNotTheNetworks) {
  const std::string weight = "/network/initial_imaging.weight";
  const auto said = [&](const std::function<void(Tensors&)>& change) {
    return said_of("dd-ert", change);
  };
  EXPECT_EQ(said([](Tensors&) {}), "");
  EXPECT_THAT(said([&](Tensors& all) {
                all[weight] = {Number::real32, {208, 576}, RowMajorMatrix::Zero(208, 576)};
              }),
              HasSubstr(weight + ": must have shape [576, 208], has [208, 576]"));
  EXPECT_THAT(said([&](Tensors& all) { all[weight].number = Number::real64; }),
              HasSubstr(weight + ": must be stored as 32-bit real numbers"));
  EXPECT_THAT(said([&](Tensors& all) { all.erase(weight); }), HasSubstr(weight + ": is missing"));
  EXPECT_THAT(said([&](Tensors& all) { all["/network/other"] = all[weight]; }),
              HasSubstr("/network/other: has no place in the network"));
  const std::string steps = "/network/encode_full.1.num_batches_tracked";
  EXPECT_THAT(said([&](Tensors& all) { all[steps].number = Number::real32; }),
              HasSubstr(steps + ": must be stored as 64-bit integers"));
  EXPECT_THAT(said([&](Tensors& all) { all.erase("/mean"); }),
              AllOf(HasSubstr("/mean: is missing"), HasSubstr("fit the solver anew")));
  EXPECT_THAT(said([&](Tensors& all) {
                all["/scale"] = {Number::real32, {16, 13}, RowMajorMatrix::Zero(16, 13)};
              }),
              HasSubstr("/scale: must have shape [208], has [16, 13]"));
}

TEST_F(FittedFile, RefusesNumbersThatAreNotFinite) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const char* name : {"/network/layers.0.weight", "/scale"}) {
      EXPECT_THAT(said_of("fcnn", [&](Tensors& all) { all[name].values(0, 0) = bad; }),
                  HasSubstr(std::string(name) + ": element 0 is not a finite number"));
    }
  }
}

TEST_F(FittedFile, IsNotCodeThatRuns) {
  const fs::path archive = folder_ / "prepared.fitted";
  const fs::path marker = folder_ / "marker";
  write_prepared_archive(archive, marker);
  for (const char* type : {"fcnn", "dcnn", "eit-nn", "dd-ert", "lean-net"}) {
    EXPECT_THAT(said_of_loading(type, archive),
                AllOf(HasSubstr("prepared.fitted: is a torch archive"), HasSubstr("code"),
                      HasSubstr("fit the solver anew")));
    EXPECT_FALSE(fs::exists(marker));
  }
  EXPECT_ANY_THROW(torch::jit::load(archive.string()).forward({}));
  EXPECT_TRUE(fs::exists(marker));  // it would have run
}

TEST_F(FittedFile, ThatFindsNoRoomOnTheDiskIsAnErrorOfTheInput) {
  const auto solver = make_learned({{"type", "dd-ert"}});
  solver->load(std::string(stored) + "dd-ert.fitted", Sensor{});
  for (const rlim_t bytes : {50, 5000, 300000}) {
    const std::string message = message_of<InputError>([&] {
      const FileSizeLimit full(bytes);
      solver->save(folder_ / "full.fitted");
    });
    EXPECT_THAT(message, HasSubstr(bytes == 50 ? "cannot be created" : "cannot be written"));
    EXPECT_THAT(message, HasSubstr("is the disk full?"));
  }
  solver->save(folder_ / "full.fitted");
  EXPECT_EQ(said_of_loading("dd-ert", folder_ / "full.fitted"), "");
}

}  // namespace
}  // namespace ertbench
