#pragma once

#include <Eigen/Core>

/// Arrays of frames and images. Each row is one item, contiguous in memory and in HDF5 files.
namespace ertbench {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
/// The same in single precision.
using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Measured voltages, one frame a row: [frames, channels], V.
using Frames = RowMajorMatrix;
/// Conductivities or their changes, one image a row: [images, pixels], S/m; pixel index
/// `column + grid * row`, row 0 at y = -1, column 0 at x = -1.
using Images = RowMajorMatrix;

using FramesView = Eigen::Ref<const Frames>;
using ImagesView = Eigen::Ref<Images>;

}  // namespace ertbench
