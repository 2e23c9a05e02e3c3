// Datasets out of files of the user's.

#include <gtest/gtest.h>
#include <hdf5.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/random.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"

namespace ertbench {
namespace {

using nlohmann::json;

RowMajorMatrix numbers(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  RandomStream random(seed, 0, 0, Purpose::scene);
  return RowMajorMatrix::NullaryExpr(rows, columns, [&] { return random.uniform(-1, 1); });
}

class MeasuredFramesTest : public ::testing::Test {
 protected:
  static constexpr Eigen::Index frames = 20;

  /// The file with what `more` adds: 208 channels, a reference for each frame, places.
  template <typename More>
  void write(More&& more, bool places = true) {
    Hdf5File file = Hdf5File::create(folder_ / "skin.h5");
    file.write_matrix("/voltages", voltages_);
    file.write_matrix("/reference_voltages", references_);
    if (places) file.write_matrix("/positions_mm", places_);
    more(file);
    file.close();
  }
  void write() {
    write([](Hdf5File&) {});
  }

  DatasetSpec spec(const json& more = json::object(), const char* name = "train") const {
    json object = {{"file", "skin.h5"}};
    object.update(more);
    return dataset_spec_from_json(JsonObject(object, "e.json", "/datasets/train"), Sensor{}, name,
                                  folder_.path());
  }
  DatasetFile made(const DatasetSpec& of) const {
    generate_dataset(of, folder_ / "set.h5");
    return DatasetFile(folder_ / "set.h5");
  }
  std::string refusal(const json& more = json::object()) const {
    try {
      spec(more);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }

  TemporaryFolder folder_;
  RowMajorMatrix references_ =
      numbers(1, 208, 7).replicate(frames, 1) + 0.05 * numbers(frames, 208, 1);
  RowMajorMatrix voltages_ = references_ + 0.01 * numbers(frames, 208, 2);
  RowMajorMatrix places_ = 60 * numbers(frames, 2, 3);
};

TEST_F(MeasuredFramesTest, KeepTheChangeFromTheReferenceOfEachFrame) {
  write();
  const DatasetSpec s = spec({{"rows", {3, 17}}, {"scale", 0.5}});
  EXPECT_EQ(s.count, 14u);
  const DatasetFile set = made(s);
  const Frames changes = set.voltages(0, 14).rowwise() - set.reference_voltages().transpose();
  const RowMajorMatrix expected = 0.5 * (voltages_ - references_).middleRows(3, 14);
  EXPECT_LE((changes - expected).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_EQ(set.truth(), (Truth{false, true}));
  EXPECT_EQ(to_json(set.spec()).dump(), set.recipe());
  EXPECT_TRUE(set.why_changed().empty());
}

TEST_F(MeasuredFramesTest, DrawTheDeclaredContactAtAPlace) {
  write([](Hdf5File& file) {
    file.write_vector("/depth_mm", Eigen::VectorXd::LinSpaced(frames, 10, 20));
  });
  const DatasetFile set = made(spec({{"contact",
                                      {{"radius_mm", 15},
                                       {"conductivity_ratio", 0.4},
                                       {"strength", {{"dataset", "/depth_mm"}, {"full", 20}}}}}}));
  const std::vector<Scene> scenes = set.scenes(0, set.size());
  for (Eigen::Index i = 0; i < frames; ++i) {
    const Contact& contact = scenes[static_cast<std::size_t>(i)].contacts.at(0);
    EXPECT_LE((100 * contact.centre - places_.row(i).transpose()).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(contact.half_size.x(), 0.15);
    const double depth = 10 + 10 * static_cast<double>(i) / (frames - 1);
    EXPECT_NEAR(contact.conductivity_ratio, 1 - 0.6 * depth / 20, 1e-12);
    // The image shows it: the integral of its change is that of the disc.
    const Eigen::RowVectorXd image = set.conductivity(static_cast<std::uint64_t>(i), 1);
    const double integral = (image.array() - 0.06).sum() * set.sensor().image().pixel_area();
    EXPECT_NEAR(integral, -0.06 * 0.6 * depth / 20 * std::numbers::pi * 0.15 * 0.15, 1e-12);
  }
}

TEST_F(MeasuredFramesTest, TakeContactsAndImagesAsTheirTruth) {
  RowMajorMatrix contacts(frames, 8);  // two of (x, y, radius, ratio), mm
  for (Eigen::Index i = 0; i < frames; ++i) contacts.row(i) << 10, -20, 8, 0.5, -50, 30, 5, 0.7;
  contacts.row(4).tail(4).setConstant(std::nan(""));
  write(
      [&](Hdf5File& file) {
        file.create_dataset("/contacts", {frames, 2, 4});
        file.write_rows("/contacts", 0, contacts);
      },
      false);
  {
    const DatasetFile set = made(spec());
    EXPECT_EQ(set.truth(), (Truth{true, true}));
    EXPECT_EQ(set.scenes(4, 1)[0].contacts.size(), 1u);
    ASSERT_EQ(set.scenes(5, 1)[0].contacts.size(), 2u);
    const Contact second = set.scenes(5, 1)[0].contacts[1];
    EXPECT_LE((second.centre - Eigen::Vector2d(-0.5, 0.3)).norm(), 1e-12);
    EXPECT_EQ(second.conductivity_ratio, 0.7);
  }
  const RowMajorMatrix images = 0.06 + 0.01 * numbers(frames, 576, 9).array();
  write(
      [&](Hdf5File& file) {
        file.create_dataset("/conductivity", {frames, 24, 24});
        file.write_rows("/conductivity", 0, images);
      },
      false);
  const DatasetFile set = made(spec());
  EXPECT_EQ(set.truth(), (Truth{true, false}));
  EXPECT_EQ(set.conductivity(0, frames), images);
}

TEST_F(MeasuredFramesTest, MayComeWithoutATruth) {
  write([](Hdf5File&) {}, false);
  const DatasetFile set = made(spec());
  EXPECT_EQ(set.truth(), (Truth{false, false}));
  EXPECT_TRUE(set.scenes(0, 1)[0].contacts.empty());
}

TEST_F(MeasuredFramesTest, AFoldsSharesAreAllRowsAndEachRowOnce) {
  write();
  std::multiset<std::uint64_t> held;
  for (int number = 0; number < 3; ++number) {
    const json share = {{"count", 3}, {"number", number}};
    json out = share;
    out["part"] = "held-out";
    json rest = share;
    rest["part"] = "rest";
    const auto rows = spec({{"fold", out}}).measured()->rows();
    const auto others = spec({{"fold", rest}}).measured()->rows();
    held.insert(rows.begin(), rows.end());
    std::set<std::uint64_t> all(rows.begin(), rows.end());
    all.insert(others.begin(), others.end());
    EXPECT_EQ(all.size(), 20u);
    EXPECT_EQ(rows.size() + others.size(), 20u);
    // Fewer are a part of more.
    rest["slice"] = {0, 5};
    const auto few = spec({{"fold", rest}}).measured()->rows();
    EXPECT_EQ(few, std::vector(others.begin(), others.begin() + 5));
  }
  EXPECT_EQ(std::set(held.begin(), held.end()).size(), 20u);
  EXPECT_EQ(held.size(), 20u);
}

TEST_F(MeasuredFramesTest, AnotherContentIsAnotherSet) {
  write();
  const std::string before = to_json(spec()).dump();
  voltages_(7, 7) += 1e-9;
  write();
  EXPECT_NE(to_json(spec()).dump(), before);
}

TEST_F(MeasuredFramesTest, SayWhatIsWrong) {
  EXPECT_NE(refusal().find("e.json: /datasets/train/file: there is no file"), std::string::npos);
  write();
  EXPECT_EQ(refusal(), "");
  EXPECT_NE(refusal({{"rows", {0, 21}}}).find("/rows: must be rows [first, last) of the 20"),
            std::string::npos)
      << refusal({{"rows", {0, 21}}});
  EXPECT_NE(refusal({{"rows", {5, 5}}}).find("/rows: must be"), std::string::npos);
  EXPECT_NE(refusal({{"checksum", "0"}}).find("/checksum: the file has another one"),
            std::string::npos);
  EXPECT_NE(refusal({{"grid", 24}}).find("/grid: unknown key"), std::string::npos);
  EXPECT_NE(refusal({{"count", 5}}).find("/count: must be left out"), std::string::npos);

  places_.row(12) << 99, 101;
  write();
  EXPECT_NE(refusal().find("row 12 lies off the sheet"), std::string::npos) << refusal();
  EXPECT_EQ(refusal({{"rows", {0, 12}}}), "");
  places_.row(12).setZero();
  voltages_(2, 3) = std::nan("");
  write();
  EXPECT_NE(refusal().find("/voltages"), std::string::npos) << refusal();
  voltages_.resize(frames, 192);
  voltages_.setZero();
  references_.resize(frames, 192);
  references_.setZero();
  write();
  EXPECT_NE(refusal().find("must have shape [frames, 208]"), std::string::npos) << refusal();
}

TEST_F(MeasuredFramesTest, DoNotFollowLinksToOtherFiles) {
  write([](Hdf5File&) {}, false);
  std::filesystem::copy_file(folder_ / "skin.h5", folder_ / "other.h5");
  const hid_t file = H5Fopen((folder_ / "skin.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, "/voltages", H5P_DEFAULT);
  H5Lcreate_external((folder_ / "other.h5").c_str(), "/voltages", file, "/voltages", H5P_DEFAULT,
                     H5P_DEFAULT);
  H5Fclose(file);
  EXPECT_NE(refusal().find("/voltages"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace ertbench
