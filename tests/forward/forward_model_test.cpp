#include "forward/fem/forward_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/random.h"
#include "forward/sheet/rasterise.h"
#include "forward/sheet/sensor.h"
#include "tests/forward/reference_data.h"

namespace ertbench {
namespace {

using testing::relative_difference;

constexpr ForwardMethod methods[] = {ForwardMethod::automatic, ForwardMethod::condensation,
                                     ForwardMethod::contact_update};

/// Independent log-normal conductivities, a factor of about 4 either way.
Images random_sheets(int count, int grid, std::uint64_t seed, double background = 0.06) {
  RandomStream random(seed, 0, 0, Purpose::scene);
  Images sheets(count, grid * grid);
  for (double& value : sheets.reshaped()) value = background * std::exp(0.7 * random.normal());
  return sheets;
}

/// One contact on an otherwise uniform sheet.
Eigen::VectorXd sheet_with_disc(int grid, double x, double y, double radius, double ratio) {
  Contact contact;
  contact.centre = {x, y};
  contact.half_size.setConstant(radius);
  contact.conductivity_ratio = ratio;
  Eigen::VectorXd image(grid * grid);
  rasterise({{contact}}, square_sheet()->pixels(grid), Rasterisation::area, image);
  return 0.06 * image;
}

TEST(ForwardModel, ReferenceVoltagesEqualEidors) {
  const ForwardModel model(Sensor{}, 24);
  const Eigen::VectorXd expected = testing::eidors().read_vector("/reference_voltages");
  EXPECT_LT(relative_difference(model.reference_voltages(), expected), 1e-10);
  const Images uniform = Images::Constant(1, 576, 0.06);
  for (const ForwardMethod method : methods) {
    EXPECT_LT(relative_difference(model.solve(uniform, method), expected.transpose()), 1e-10);
  }
}

TEST(ForwardModel, SceneVoltagesEqualEidors) {
  const ForwardModel model(Sensor{}, 24);
  const Hdf5File file = testing::eidors();
  const Images sheets = file.read_rows("/scenes/conductivity", 0, 6);
  const Frames expected = file.read_rows("/scenes/voltages", 0, 6);
  for (const ForwardMethod method : methods) {
    const Frames voltages = model.solve(sheets, method);
    for (Eigen::Index s = 0; s < 6; ++s) {
      EXPECT_LT(relative_difference(voltages.row(s), expected.row(s)), 1e-10) << "scene " << s;
    }
  }
}

TEST(ForwardModel, JacobianEqualsEidors) {
  const ForwardModel model(Sensor{}, 24);
  const RowMajorMatrix expected = testing::eidors().read_rows("/jacobian", 0, 208);
  EXPECT_LT(relative_difference(model.jacobian(), expected), 1e-10);
  EXPECT_LT(relative_difference(model.jacobian(Eigen::VectorXd::Constant(576, 0.06)), expected),
            1e-10);
}

TEST(ForwardModel, JacobianIsTheDerivativeOnInhomogeneousSheets) {
  const int grid = 24;
  const ForwardModel model(Sensor{}, grid);
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    const Eigen::VectorXd sheet = random_sheets(1, grid, seed).row(0);
    const RowMajorMatrix jacobian = model.jacobian(sheet);
    // Central differences along a random direction; the error is O(step^2) with third derivatives
    // of order 1 in log conductivity, and rounding adds 1e-13 / step.
    RandomStream random(seed, 1, 0, Purpose::scene);
    Eigen::VectorXd direction(sheet.size());
    for (Eigen::Index p = 0; p < sheet.size(); ++p) direction[p] = sheet[p] * random.normal();
    const double step = 1e-4;
    Images two(2, sheet.size());
    two.row(0) = sheet + step * direction;
    two.row(1) = sheet - step * direction;
    const Frames voltages = model.solve(two);
    const Eigen::VectorXd difference = (voltages.row(0) - voltages.row(1)) / (2 * step);
    EXPECT_LT(relative_difference(jacobian * direction, difference), 1e-6);
  }
}

TEST(ForwardModel, MethodsAgreeOnEveryGrid) {
  for (const int grid : {24, 48, 96}) {
    SCOPED_TRACE(grid);
    const ForwardModel model(Sensor{}, grid);
    Images sheets(11, grid * grid);  // more than the lanes, and not a multiple of them
    for (int s = 0; s < sheets.rows(); ++s) {
      sheets.row(s) =
          sheet_with_disc(grid, 0.8 - 0.15 * s, 0.1 * s - 0.5, 0.06 + 0.03 * s, 0.1 + 0.08 * s);
    }
    const Frames one = model.solve(sheets, ForwardMethod::condensation);
    const Frames other = model.solve(sheets, ForwardMethod::contact_update);
    EXPECT_LT(relative_difference(one, other), 1e-11);
    EXPECT_GT((one.row(0) - one.row(10)).norm(), 1e-3 * one.row(0).norm());
  }
}

TEST(ForwardModel, SceneDoesNotDependOnItsBatch) {
  const ForwardModel model(Sensor{}, 24);
  Images sheets = random_sheets(20, 24, 5);
  for (int s = 0; s < 20; s += 3) sheets.row(s) = sheet_with_disc(24, 0.05 * s - 0.5, 0, 0.1, 0.5);
  const Frames all = model.solve(sheets);
  for (int s = 0; s < 20; ++s) {
    EXPECT_EQ(model.solve(sheets.row(s)), all.row(s)) << "scene " << s;
  }
}

TEST(ForwardModel, ReciprocityHolds) {
  const Sensor sensor;
  const ForwardModel model(sensor, 24);
  const Frames voltages = model.solve(random_sheets(4, 24, 7));
  const auto pairs = reciprocal_pairs(sensor);
  ASSERT_EQ(pairs.size(), 104u);
  for (const auto& [a, b] : pairs) {
    for (Eigen::Index s = 0; s < voltages.rows(); ++s) {
      EXPECT_NEAR(voltages(s, a), voltages(s, b), 1e-12 * voltages.row(s).norm());
    }
  }
}

TEST(ForwardModel, TurnsWithTheSymmetriesOfTheSquare) {
  const Sensor sensor;
  const ForwardModel model(sensor, 24);
  const Eigen::VectorXd sheet = random_sheets(1, 24, 11).row(0);
  const Eigen::VectorXd voltages = model.solve(sheet.transpose()).row(0);
  const std::vector<Symmetry> all = symmetries(sensor);
  ASSERT_EQ(all.size(), 8u);
  std::set<std::vector<int>> different;
  for (const Symmetry& symmetry : all) {
    different.insert(symmetry.pixels);
    const Eigen::VectorXd turned = sheet(symmetry.pixels);
    const Eigen::VectorXd seen = model.solve(turned.transpose()).row(0);
    EXPECT_LT((seen - voltages(symmetry.channels)).norm(), 1e-11 * voltages.norm());
  }
  EXPECT_EQ(different.size(), 8u);
}

TEST(ForwardModel, SymmetriesAreThoseOfTheElectrodes) {
  Sensor shifted;
  shifted.image_grid = 40;
  shifted.electrode_offset = 0.1;  // symmetric to no middle line: rotations alone
  EXPECT_EQ(symmetries(shifted).size(), 4u);
  Sensor corners;
  corners.electrode_offset = 0;
  EXPECT_EQ(symmetries(corners).size(), 8u);
}

TEST(ForwardModel, ScalesWithCurrentAndBackground) {
  Sensor other;
  other.drive_current = 0.1;
  other.background = 3.0;
  const Images sheets = random_sheets(3, 24, 13);
  const Frames voltages = ForwardModel(Sensor{}, 24).solve(sheets);
  const Frames scaled = ForwardModel(other, 24).solve(sheets * 50);
  EXPECT_LT(relative_difference(scaled, voltages * (4.0 / 50)), 1e-12);
}

TEST(ForwardModel, OtherSensorsAgreeBetweenMethods) {
  Sensor corners;  // electrodes in the corners too
  corners.electrode_offset = 0;
  Sensor eight;
  eight.electrode_count = 8;
  eight.electrode_offset = 0.5;
  eight.image_grid = 16;
  for (const Sensor& sensor : {corners, eight}) {
    const ForwardModel model(sensor, sensor.image_grid);
    const Images sheet = sheet_with_disc(sensor.image_grid, 0.3, -0.2, 0.3, 0.4).transpose();
    const Frames one = model.solve(sheet, ForwardMethod::condensation);
    EXPECT_EQ(one.cols(), sensor.channels());
    EXPECT_LT(relative_difference(one, model.solve(sheet, ForwardMethod::contact_update)), 1e-11);
  }
}

TEST(ForwardModel, ContactUnderAnElectrode) {
  const ForwardModel model(Sensor{}, 24);
  const Images sheet = sheet_with_disc(24, -0.75, 0.95, 0.3, 0.3).transpose();
  EXPECT_LT(relative_difference(model.solve(sheet, ForwardMethod::contact_update),
                                model.solve(sheet, ForwardMethod::condensation)),
            1e-11);
}

TEST(ForwardModel, ContactUpdateWhereNearlyEveryNodeIsActive) {
  // All nodes but the corners, whose one pixel cannot differ from itself.
  const Images sheet = random_sheets(1, 24, 17);
  const ForwardModel model(Sensor{}, 24);
  EXPECT_LT(relative_difference(model.solve(sheet, ForwardMethod::contact_update),
                                model.solve(sheet, ForwardMethod::condensation)),
            1e-11);
  // With electrodes in the corners these are active too; the update's system would be singular.
  Sensor corners;
  corners.electrode_offset = 0;
  const ForwardModel other(corners, 24);
  EXPECT_EQ(other.solve(sheet, ForwardMethod::contact_update),
            other.solve(sheet, ForwardMethod::condensation));
}

/// log2 of the error's reduction from one grid to the next.
std::vector<double> orders(const std::vector<double>& errors) {
  std::vector<double> out;
  for (std::size_t i = 1; i < errors.size(); ++i) {
    out.push_back(std::log2(errors[i - 1] / errors[i]));
  }
  return out;
}

TEST(ForwardModel, ReferenceVoltagesConvergeAtSecondOrder) {
  const Eigen::VectorXd exact = testing::border_integral().read_vector("/reference_voltages");
  std::vector<double> errors;
  for (const int grid : {24, 48, 96, 192}) {
    errors.push_back(relative_difference(ForwardModel(Sensor{}, grid).reference_voltages(), exact));
  }
  for (const double order : orders(errors)) EXPECT_NEAR(order, 2, 0.05);
  EXPECT_LT(errors.back(), 2e-4);
}

TEST(ForwardModel, VoltageChangesConvergeToTheContinuousSheet) {
  const Hdf5File file = testing::border_integral();
  const RowMajorMatrix exact = file.read_rows("/voltage_change", 0, 9);
  const RowMajorMatrix contacts = file.read_rows("/contacts", 0, 9, true);
  // In units of the noise at 50 dB of the reference frame.
  const double noise = file.read_vector("/reference_voltages").norm() * std::pow(10, -2.5);
  std::vector<double> mean;
  for (const int grid : {24, 48, 96, 192}) {
    const ForwardModel model(Sensor{}, grid);
    double sum = 0;
    for (Eigen::Index s = 0; s < 9; ++s) {
      Scene scene;
      for (Eigen::Index k = 0; k < 18 && std::isfinite(contacts(s, k)); k += 6) {
        Contact contact;
        contact.shape = Shape::ellipse;
        contact.centre = {contacts(s, k), contacts(s, k + 1)};
        contact.half_size = {contacts(s, k + 2), contacts(s, k + 3)};
        contact.angle = contacts(s, k + 4);
        contact.conductivity_ratio = contacts(s, k + 5);
        scene.contacts.push_back(contact);
      }
      Eigen::VectorXd ratio(grid * grid);
      rasterise(scene, square_sheet()->pixels(grid), Rasterisation::area, ratio);
      const Eigen::VectorXd change =
          model.solve(0.06 * ratio.transpose()).row(0).transpose() - model.reference_voltages();
      sum += (change - exact.row(s).transpose()).norm() / noise;
    }
    mean.push_back(sum / 9);
    // A small constant: the mean error is below 1.5 noise units on the image grid.
    EXPECT_LT(mean.back(), 1.5 * 24 / grid) << "grid " << grid;
  }
  // Cut pixels: first order over three halvings.
  EXPECT_GT(std::log2(mean.front() / mean.back()) / 3, 1.0);
}

}  // namespace
}  // namespace ertbench
