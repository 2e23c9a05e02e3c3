#include "core/hdf5_file.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <fstream>
#include <iterator>

#include "core/errors.h"
#include "core/files.h"
#include "tests/file_size_limit.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using testing::FileSizeLimit;
using Number = Hdf5File::Number;

std::string refusal_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

bool says(const std::string& message, const std::string& part) {
  return message.find(part) != std::string::npos;
}

void write_numbers(const fs::path& path) {
  Hdf5File file = Hdf5File::create(path);
  file.create_dataset("/group/b", {2, 2, 1}, Number::real32);
  file.write_rows("/group/b", 0, (RowMajorMatrix(2, 2) << 1, -0.0, 0.1F, 3e38).finished());
  file.create_dataset("/group/a", {1}, Number::int64);
  file.write_rows("/group/a", 0, RowMajorMatrix::Constant(1, 1, 1234567890123));
  file.write_vector("/alone", Eigen::VectorXd::Ones(2));
  file.close();
}

TEST(Hdf5File, KeepsNumbersOfAnyTypeInGroups) {
  const TemporaryFolder folder;
  write_numbers(folder / "a.h5");
  const Hdf5File file = Hdf5File::open(folder / "a.h5");
  EXPECT_EQ(file.names("/group"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(file.names("/"), (std::vector<std::string>{"alone", "group"}));
  EXPECT_TRUE(file.names("/no group").empty());
  EXPECT_EQ(file.shape("/group/b"), (std::vector<std::uint64_t>{2, 2, 1}));
  const RowMajorMatrix values = file.read_rows("/group/b", 0, 2);
  EXPECT_EQ(values(0, 0), 1);
  EXPECT_TRUE(std::signbit(values(0, 1)));
  EXPECT_EQ(values(1, 0), 0.1F);
  EXPECT_EQ(file.read_rows("/group/a", 0, 1)(0, 0), 1234567890123);
  file.require_number("/group/a", Number::int64);
  file.require_number("/group/b", Number::real32);
  file.require_number("/alone", Number::real64);
  EXPECT_TRUE(says(refusal_of([&] { file.require_number("/alone", Number::real32); }),
                   "a.h5: /alone: must be stored as 32-bit real numbers"));
  EXPECT_TRUE(says(refusal_of([&] { file.require_number("/group/c", Number::real32); }),
                   "/group/c: is missing"));
}

TEST(Hdf5File, ReadsSixteenBitsWhereThirtyTwoAreWanted) {
  const TemporaryFolder folder;
  const fs::path path = folder / "half.h5";
  const float values[] = {1, -0.333251953125F, 65504};  // exact in 16 bits
  const hsize_t count = 3;
  const hid_t half = H5Tcopy(H5T_IEEE_F32LE);
  H5Tset_fields(half, 15, 10, 5, 0, 10);
  H5Tset_size(half, 2);
  H5Tset_ebias(half, 15);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t space = H5Screate_simple(1, &count, nullptr);
  const hid_t set = H5Dcreate2(file, "a", half, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  H5Dclose(set), H5Sclose(space), H5Tclose(half), H5Fclose(file);
  const Hdf5File read = Hdf5File::open(path);
  read.require_number("/a", Number::real32);
  EXPECT_EQ(read.read_vector("/a"), Eigen::Vector3d(values[0], values[1], values[2]));
  EXPECT_TRUE(says(refusal_of([&] { read.require_number("/a", Number::real64); }), "64-bit real"));
}

TEST(Hdf5File, EqualContentMakesEqualFiles) {
  const TemporaryFolder folder;
  std::string contents[2];
  for (const int i : {0, 1}) {
    const fs::path path = folder / (std::to_string(i) + ".h5");
    write_numbers(path);
    std::ifstream in(path, std::ios::binary);
    contents[i].assign(std::istreambuf_iterator<char>(in), {});
  }
  EXPECT_EQ(contents[0], contents[1]);
}

TEST(Hdf5File, AFullDiskIsAnErrorOfTheInput) {
  const TemporaryFolder folder;
  const auto written = [&](Eigen::Index count, rlim_t bytes) {
    return refusal_of([&] {
      const FileSizeLimit full(bytes);
      Hdf5File file = Hdf5File::create(folder / "full.h5");
      file.write_vector("/x", Eigen::VectorXd::Ones(count));
      file.write_text("/", "note", "text");
      file.close();
    });
  };
  EXPECT_TRUE(
      says(written(10000, 4000),
           "full.h5: /x: cannot be written; is the disk full? (HDF5: file write failed: File "
           "too large)"));
  EXPECT_TRUE(says(written(10, 4000), "accepted"));
  // The numbers find room, and what describes them, which closing writes, does not: it lies before
  // them and, where the disk is that full, at the file's start.
  const std::string message = refusal_of([&] {
    Hdf5File file = Hdf5File::create(folder / "full.h5");
    const FileSizeLimit full(50);
    file.write_text("/", "note", "text");
    file.close();
  });
  EXPECT_TRUE(says(message, "full.h5: /: cannot be written; is the disk full?")) << message;
  EXPECT_EQ(written(10000, RLIM_INFINITY), "accepted");  // the library is none the worse for it
  EXPECT_EQ(Hdf5File::open(folder / "full.h5").read_vector("/x").sum(), 10000);
}

}  // namespace
}  // namespace ertbench
