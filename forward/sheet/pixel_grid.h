#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace ertbench {

/// Pixels of an image: equal boxes in rows and columns over the bounding box of a sheet. Row-major
/// from the corner of least x and y, rows upwards. Lengths in domain units.
class PixelGrid {
 public:
  PixelGrid(const Eigen::AlignedBox2d& box, int columns, int rows)
      : columns_(columns),
        rows_(rows),
        low_(box.min()),
        pixel_(box.sizes().x() / columns, box.sizes().y() / rows) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int count() const { return columns_ * rows_; }
  const Eigen::Vector2d& pixel() const { return pixel_; }  ///< sides of a pixel
  double pixel_area() const { return pixel_.prod(); }

  /// Corner of least x and y of a pixel; also the nodes of the grid, which have one more column and
  /// row than the pixels.
  Eigen::Vector2d corner(int column, int row) const {
    return low_ + pixel_.cwiseProduct(Eigen::Vector2d(column, row));
  }
  Eigen::Vector2d corner(int index) const { return corner(index % columns_, index / columns_); }
  Eigen::Vector2d centre(int index) const { return corner(index) + pixel_ / 2; }
  Eigen::AlignedBox2d box(int index) const { return {corner(index), corner(index) + pixel_}; }
  /// x of the columns' centres [columns] and y of the rows' [rows].
  Eigen::RowVectorXd centres_x() const { return centres(0, columns_); }
  Eigen::RowVectorXd centres_y() const { return centres(1, rows_); }
  /// Fractional column and row of a point, from the corner of the image.
  Eigen::Vector2d place(const Eigen::Vector2d& point) const {
    return (point - low_).cwiseQuotient(pixel_);
  }

  /// True if a pixel is on the sheet, at least in part. Off the sheet an image has no change.
  bool on_sheet(int index) const {
    return off_.empty() || off_[static_cast<std::size_t>(index)] == 0;
  }
  /// Share of a pixel's area that is on the sheet, 0 ... 1.
  double part_on_sheet(int index) const {
    if (!on_sheet(index)) return 0;
    return parts_.empty() ? 1 : parts_[static_cast<std::size_t>(index)];
  }
  bool all_on_sheet() const { return off_.empty(); }
  int count_on_sheet() const { return count() - off_count_; }
  void set_off_sheet(int index) {
    if (off_.empty()) off_.assign(static_cast<std::size_t>(count()), 0);
    off_count_ += off_[static_cast<std::size_t>(index)] == 0;
    off_[static_cast<std::size_t>(index)] = 1;
  }
  /// Sets the share of a pixel that is on the sheet.
  void set_part_on_sheet(int index, double part) {
    if (parts_.empty()) parts_.assign(static_cast<std::size_t>(count()), 1);
    parts_[static_cast<std::size_t>(index)] = part;
  }

 private:
  Eigen::RowVectorXd centres(int axis, int number) const {
    const double first = low_[axis] + pixel_[axis] / 2;
    return Eigen::RowVectorXd::LinSpaced(number, first,
                                         low_[axis] + number * pixel_[axis] - pixel_[axis] / 2);
  }

  int columns_;
  int rows_;
  Eigen::Vector2d low_;
  Eigen::Vector2d pixel_;
  std::vector<char> off_;  ///< [count], 1 off the sheet; empty if all pixels are on it
  int off_count_ = 0;
  std::vector<double> parts_;  ///< [count] shares of the area; empty if all are 1
};

/// Conductivity ratios of the patches of a skin, squares at equal distances with the ratio 1
/// between them.
struct PatchField {
  int patches = 0;        ///< along one side
  double width = 1;       ///< of a patch, as a fraction of the distance between their centres
  Eigen::VectorXd ratio;  ///< [patches^2] sigma / background, column + patches * row
};

/// Writes the conductivity ratios [pixels] of a skin's patches, by the fraction of each pixel's
/// area that each patch covers.
void rasterise(const PatchField& field, const PixelGrid& pixels, Eigen::Ref<Eigen::VectorXd> ratio);

}  // namespace ertbench
