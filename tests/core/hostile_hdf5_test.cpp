// HDF5 files that lead elsewhere, or declare what they do not hold.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// What reading the dataset "/voltages" [rows, 4] of a file says; empty where it can be read.
std::string complaint(const fs::path& path) {
  try {
    const Hdf5File file = Hdf5File::open(path);
    const auto shape = file.require_shape("/voltages", {0, 4});
    file.read_rows("/voltages", 0, std::min<std::uint64_t>(shape[0], 1024));
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

hid_t new_file(const fs::path& path) {
  return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
}

/// Declares [rows, 4] doubles with these properties, and writes nothing.
void declare(hid_t file, hsize_t rows, hid_t properties) {
  const hsize_t shape[] = {rows, 4};
  const hid_t space = H5Screate_simple(2, shape, nullptr);
  const hid_t set =
      H5Dcreate2(file, "/voltages", H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  EXPECT_GE(set, 0);
  H5Dclose(set);
  H5Sclose(space);
}

void write_good(const fs::path& path) {
  Hdf5File file = Hdf5File::create(path);
  file.write_matrix("/voltages", RowMajorMatrix::Ones(3, 4));
}

/// A file with links to "other.h5" beside it, which this process could not make, as it does without
/// them: /voltages, /group/link, /elsewhere (of the whole file) and the soft link /through, which
/// leads through /elsewhere to its voltages.
void copy_links(const fs::path& to) { fs::copy_file(ERTBENCH_TEST_DATA "/hostile/links.h5", to); }

TEST(HostileHdf5, LinksToOtherFilesAreNotFollowed) {
  const TemporaryFolder folder;
  write_good(folder / "other.h5");
  ASSERT_EQ(complaint(folder / "other.h5"), "");
  copy_links(folder / "links.h5");
  const Hdf5File links = Hdf5File::open(folder / "links.h5");
  for (const char* dataset : {"/voltages", "/through", "/elsewhere/voltages", "/group/link"}) {
    EXPECT_THROW(links.shape(dataset), InputError) << dataset;
    EXPECT_THROW(links.read_rows(dataset, 0, 1), InputError) << dataset;
  }
  for (const char* group : {"/", "/group", "/elsewhere"}) {
    EXPECT_THROW(links.names(group), InputError) << group;
  }
}

TEST(HostileHdf5, ALinkToAPipeDoesNotHang) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::create_symlink(folder / "pipe", folder / "frames.h5");
  EXPECT_NE(complaint(folder / "frames.h5").find("is a FIFO; name a regular file"),
            std::string::npos);
  EXPECT_NE(complaint(folder.path()).find("is a directory; name a regular file"),
            std::string::npos);
}

TEST(HostileHdf5, ValuesOfOtherFilesAreNotRead) {
  const TemporaryFolder folder;
  std::ofstream(folder / "secret") << std::string(96, 'x');
  const hid_t external = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(external, (folder / "secret").c_str(), 0, 96);
  const hid_t file = new_file(folder / "external.h5");
  declare(file, 3, external);
  H5Fclose(file);
  EXPECT_NE(complaint(folder / "external.h5").find("keeps its values in other files"),
            std::string::npos)
      << complaint(folder / "external.h5");

  write_good(folder / "other.h5");
  const hsize_t shape[] = {3, 4};
  const hid_t space = H5Screate_simple(2, shape, nullptr);
  const hid_t mapped = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_virtual(mapped, space, (folder / "other.h5").c_str(), "/voltages", space);
  const hid_t second = new_file(folder / "virtual.h5");
  declare(second, 3, mapped);
  H5Fclose(second);
  EXPECT_NE(complaint(folder / "virtual.h5").find("keeps its values in other files"),
            std::string::npos)
      << complaint(folder / "virtual.h5");
}

TEST(HostileHdf5, RowsThatNobodyStoredAreNotRead) {
  const TemporaryFolder folder;
  for (const hsize_t rows : {hsize_t{100'000'000}, hsize_t{1} << 36, hsize_t{1} << 60}) {
    for (const bool chunked : {false, true}) {
      SCOPED_TRACE(std::to_string(rows) + (chunked ? " in chunks" : ""));
      const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
      const hsize_t chunk[] = {1024, 4};
      if (chunked) H5Pset_chunk(properties, 2, chunk);
      const hid_t file = new_file(folder / "declared.h5");
      if (!chunked && rows > hsize_t{1} << 58) {
        H5Fclose(file);  // the library itself refuses to declare that
        continue;
      }
      declare(file, rows, properties);
      H5Fclose(file);
      EXPECT_NE(complaint(folder / "declared.h5").find("declares more values than the file holds"),
                std::string::npos)
          << complaint(folder / "declared.h5");
    }
  }
}

TEST(HostileHdf5, CompressedFilesAreRead) {
  const TemporaryFolder folder;
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t chunk[] = {512, 4};
  H5Pset_chunk(properties, 2, chunk);
  if (H5Pset_deflate(properties, 9) < 0) GTEST_SKIP() << "this HDF5 library has no deflate";
  const hid_t file = new_file(folder / "deflated.h5");
  const hsize_t shape[] = {100'000, 4};
  const hid_t space = H5Screate_simple(2, shape, nullptr);
  const hid_t set =
      H5Dcreate2(file, "/voltages", H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  const std::vector<double> zeros(400'000, 0);
  H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, zeros.data());
  H5Dclose(set);
  H5Fclose(file);
  ASSERT_LT(fs::file_size(folder / "deflated.h5"), 200'000u);
  EXPECT_EQ(complaint(folder / "deflated.h5"), "");
}

TEST(Hdf5Checksum, SeesEveryChangedByteOfWhatIsThere) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, double value, const std::string& text) {
    Hdf5File file = Hdf5File::create(folder / name);
    RowMajorMatrix matrix = RowMajorMatrix::Ones(3000, 700);  // more than one block
    matrix(2999, 699) = value;
    file.write_matrix("/voltages", matrix);
    file.write_text_dataset("/recipe", text);
    file.write_text("/", "sensor", "{}");
    file.write_checksum();
    return file.read_text("/", "checksum");
  };
  const std::string checksum = write("a.h5", 1, "recipe");
  EXPECT_EQ(write("b.h5", 1, "recipe"), checksum);
  EXPECT_NE(write("b.h5", 1 + 1e-16, "recipe "), checksum);
  EXPECT_NE(write("b.h5", 1 + 1e-15, "recipe"), checksum);
  EXPECT_EQ(Hdf5File::open(folder / "a.h5").why_changed(), "");
  {
    Hdf5File file = Hdf5File::open_writable(folder / "a.h5");
    file.write_rows("/voltages", 1500, RowMajorMatrix::Constant(1, 700, 1 + 1e-15));
  }
  EXPECT_EQ(Hdf5File::open(folder / "a.h5").why_changed(),
            "it has been changed since it was written");
  { Hdf5File::create(folder / "none.h5"); }
  EXPECT_EQ(Hdf5File::open(folder / "none.h5").why_changed(), "it has no checksum");
}

TEST(TextDataset, HoldsMoreThanAnAttribute) {
  const TemporaryFolder folder;
  const std::string text = std::string(300'000, 'x') + "ä";
  {
    Hdf5File file = Hdf5File::create(folder / "t.h5");
    file.write_text_dataset("/recipe", text);
    file.write_text_dataset("/empty", "");
  }
  const Hdf5File file = Hdf5File::open(folder / "t.h5");
  EXPECT_EQ(file.read_text_dataset("/recipe"), text);
  EXPECT_EQ(file.read_text_dataset("/empty"), "");
  EXPECT_THROW(file.read_text_dataset("/absent"), InputError);
}

}  // namespace
}  // namespace ertbench
