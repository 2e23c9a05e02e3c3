#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/json.h"
#include "forward/border/border_model.h"
#include "forward/data/sheet_model.h"
#include "forward/ellipses/ellipse_model.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"
#include "forward/sheet/sensor.h"
#include "forward/sheet/sensor_json.h"
#include "forward/sheet/sheet_shapes.h"
#include "tests/forward/reference_data.h"
#include "tests/forward/sensors_testing.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::json;
using namespace testing;

Scene one_disc(const Eigen::Vector2d& centre, double radius, double ratio) {
  Contact contact;
  contact.shape = Shape::disc;
  contact.centre = centre;
  contact.half_size = {radius, radius};
  contact.conductivity_ratio = ratio;
  Scene scene;
  scene.contacts = {contact};
  return scene;
}

json disc_series() {
  std::ifstream file(ERTBENCH_TEST_DATA "/disc_series.json");
  return json::parse(file);
}

VectorXd vector(const json& numbers) {
  const auto values = numbers.get<std::vector<double>>();
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size()));
}

// The square's map has another series behind it; up to a turn of the disc the two are the same.
TEST(RectangleMap, OfASquareIsTheSquareMap) {
  const RectangleMap map(1, 1);
  const SquareMap square;
  const std::complex<double> first(0.3, 0.4);
  const std::complex<double> turn = square(first).w / map(first).w;
  EXPECT_NEAR(std::abs(turn), 1, 1e-14);
  for (const std::complex<double> z : {std::complex<double>(-0.7, 1), {0.2, -0.9}, {1, 0.1}}) {
    const DiscPoint a = map(z);
    const DiscPoint b = square(z);
    EXPECT_LT(std::abs(turn * a.w - b.w), 1e-13);
    EXPECT_LT(std::abs(turn * a.first - b.first), 1e-12);
    EXPECT_LT(std::abs(turn * a.second - b.second), 1e-11);
  }
}

TEST(RectangleMap, TakesTheBorderToTheCircle) {
  for (const Eigen::Vector2d& sides :
       {Eigen::Vector2d(300, 150), Eigen::Vector2d(150, 300), Eigen::Vector2d(500, 100)}) {
    const RectangleSheet sheet(sides);
    EXPECT_DOUBLE_EQ(sheet.size_mm().x(), sides.x());
    EXPECT_DOUBLE_EQ(sheet.size_mm().y(), sides.y());
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector2d at = sheet.border_point(sheet.border_length() * (i - 20) / 100);
      EXPECT_NEAR(sheet.depth(at), 0, 1e-12);
      EXPECT_NEAR(std::abs(sheet.to_disc({at.x(), at.y()}).w), 1, 1e-12);
    }
    EXPECT_LT(std::abs(sheet.to_disc(0).w), 1e-14);
  }
}

// The finite elements know nothing of theta functions, and converge to them at second order.
TEST(Rectangle, VoltagesAreThoseOfTheGridInTheLimit) {
  Sensor sensor = rectangle({{"image_grid", 64}});
  const VectorXd exact = BorderModel(sensor).reference_voltages();
  const double coarse = relative_difference(ForwardModel(sensor, 64).reference_voltages(), exact);
  const double fine = relative_difference(ForwardModel(sensor, 128).reference_voltages(), exact);
  EXPECT_LT(coarse, 0.01);
  EXPECT_NEAR(coarse / fine, 4, 0.3);
}

TEST(Rectangle, ContactsAreThoseOfTheGridInTheLimit) {
  const Sensor sensor = rectangle({{"image_grid", 64}});
  const Scene scene = one_disc({0.4, -0.1}, 0.2, 0.4);
  const VectorXd exact = BorderModel(sensor).solve(scene, 1e-9).change;
  std::vector<double> error;
  for (const int grid : {64, 128}) {
    const ForwardModel model(sensor, grid);
    const PixelGrid pixels = sensor.sheet->pixels(grid);
    VectorXd ratio(pixels.count());
    rasterise(scene, pixels, Rasterisation::area, ratio);
    const Images image = sensor.background * ratio.transpose();
    const VectorXd change = model.solve(image).row(0).transpose() - model.reference_voltages();
    const VectorXd condensed = model.solve(image, ForwardMethod::condensation).row(0).transpose() -
                               model.reference_voltages();
    EXPECT_LT(relative_difference(condensed, change), 1e-9);
    error.push_back(relative_difference(change, exact));
  }
  EXPECT_LT(error[1], 0.02);
  EXPECT_LT(error[1], 0.7 * error[0]);  // first order at the least: cut pixels
}

// Without a mesh, and with one that is refined: second order.
TEST(BorderJacobian, IsTheSquareGridsInTheLimit) {
  const Sensor sensor;
  const RowMajorMatrix exact = border_jacobian(sensor);
  std::vector<double> error;
  for (const int factor : {1, 2, 4}) {
    const int grid = 24 * factor;
    const RowMajorMatrix fine = ForwardModel(sensor, grid).jacobian();
    RowMajorMatrix sum = RowMajorMatrix::Zero(exact.rows(), exact.cols());
    for (int p = 0; p < grid * grid; ++p) {
      sum.col(p % grid / factor + 24 * (p / grid / factor)) += fine.col(p);
    }
    error.push_back(relative_difference(sum, exact));
  }
  EXPECT_LT(error[0], 0.12);
  EXPECT_GT(error[0] / error[1], 3);
  EXPECT_GT(error[1] / error[2], 3.5);
}

// V is homogeneous of degree -1 in the conductivity: the sum over all pixels is -V / c0, on every
// sheet and with every kind of electrode.
TEST(BorderJacobian, SumsUpToTheVoltages) {
  const json opposite = {{"drive", "opposite"}};
  const json skip = {{"drive", {{"skip", 2}}}};
  const json pairs = {{"drive", {{0, 5}, {1, 9}, {3, 12}}}, {"measurement", "adjacent"}};
  for (const Sensor& sensor :
       {Sensor{}, rectangle(), disc(), disc(opposite), disc(skip), disc(pairs)}) {
    const RowMajorMatrix jacobian = border_jacobian(sensor);
    const VectorXd sum = -sensor.background * jacobian.rowwise().sum();
    // Of a disc slivers of pixels are off the sheet, and cut boxes are integrated to first order.
    const double tolerance = sensor.sheet->fills_bounds() ? 1e-6 : 5e-3;
    EXPECT_LT(relative_difference(sum, BorderModel(sensor).reference_voltages()), tolerance)
        << to_json(sensor);
  }
}

TEST(Disc, VoltagesAreThoseOfTheSeries) {
  const json series = disc_series();
  const double width = series.at("width");
  const json wide = {{"electrode_model", "gap"}, {"electrode_width", width}};
  const json conducting = {{"electrode_model", "complete"},
                           {"electrode_width", width},
                           {"contact_impedance", series.at("contact_impedance")}};
  const std::vector<std::tuple<const char*, json, double>> cases = {
      {"point", json::object(), 1e-12}, {"gap", wide, 1e-6}, {"complete", conducting, 2e-4}};
  for (const auto& [name, more, tolerance] : cases) {
    const BorderModel model(disc(more));
    const VectorXd reference = vector(series.at(name).at("reference"));
    EXPECT_LT(relative_difference(model.reference_voltages(), reference), tolerance) << name;
    const Scene scene = one_disc({0, 0}, series.at("radius"), series.at("ratio"));
    const VectorXd change = vector(series.at(name).at("inclusion")) - reference;
    // The series of wide electrodes is cut off; pieces of constant current are no edge singularity.
    EXPECT_LT(relative_difference(model.solve_at(scene, 8).change, change), 10 * tolerance) << name;
  }
}

// Programs of others, on meshes of their own: they come closer as their meshes are refined.
TEST(Disc, VoltagesAreThoseOfEidorsAndPyeit) {
  struct Other {
    const char* file;
    std::vector<const char*> meshes;
    double reference, change;  ///< largest relative difference on the finer mesh
  };
  for (const Other& other : {Other{"eidors_disc", {"f2c", "j2c"}, 1e-3, 0.015},
                             Other{"pyeit_disc", {"coarse", "fine"}, 1e-3, 0.015}}) {
    std::ifstream file(std::string(ERTBENCH_TEST_DATA "/") + other.file + ".json");
    const json numbers = json::parse(file);
    std::vector<double> reference_error;
    std::vector<double> change_error;
    for (const char* mesh : other.meshes) {
      const VectorXd electrodes = vector(numbers.at(mesh).at("electrodes"));
      const double first = std::atan2(electrodes[0], electrodes[1]);  // clockwise from the top
      Sensor sensor = disc();
      sensor.electrode_offset = first;
      sensor.drive_current = numbers.at("current");
      sensor.background = numbers.at("background");
      const Eigen::Matrix2Xd places = electrode_positions(sensor);
      EXPECT_LT((Eigen::Map<const Eigen::Matrix2Xd>(electrodes.data(), 2, 16) - places).norm(),
                1e-9);
      const BorderModel model(sensor);
      const VectorXd reference = vector(numbers.at(mesh).at("reference"));
      reference_error.push_back(relative_difference(reference, model.reference_voltages()));
      const Eigen::Vector2d centre = vector(numbers.at("centre"));
      const Scene scene = one_disc(centre, numbers.at("radius"), numbers.at("ratio"));
      const VectorXd change = vector(numbers.at(mesh).at("inclusion")) - reference;
      change_error.push_back(relative_difference(change, model.solve(scene, 1e-9).change));
    }
    SCOPED_TRACE(other.file);
    std::cout << other.file << ": reference " << reference_error[0] << ", " << reference_error[1]
              << "; one target " << change_error[0] << ", " << change_error[1] << "\n";
    EXPECT_LT(reference_error[1], other.reference);
    EXPECT_LT(reference_error[1], 0.6 * reference_error[0]);
    EXPECT_LT(change_error[1], other.change);
    EXPECT_LT(change_error[1], 0.8 * change_error[0]);
  }
}

TEST(Electrodes, OfNoWidthArePoints) {
  const VectorXd point = BorderModel(disc()).reference_voltages();
  double last = 1;
  for (const double width : {0.2, 0.1, 0.05}) {
    const VectorXd gap = BorderModel(disc({{"electrode_model", "gap"}, {"electrode_width", width}}))
                             .reference_voltages();
    const double error = relative_difference(gap, point);
    EXPECT_LT(error, 1.2 * width * width);  // second order: a mean over the width
    EXPECT_LT(error, last / 3.5);
    last = error;
  }
}

TEST(Electrodes, WithMuchImpedanceSpreadTheirCurrentEvenly) {
  const VectorXd gap = BorderModel(disc({{"electrode_model", "gap"}, {"electrode_width", 0.2}}))
                           .reference_voltages();
  double last = 1;
  for (const double impedance : {0.1, 1.0, 10.0, 100.0}) {
    const VectorXd complete = BorderModel(disc({{"electrode_model", "complete"},
                                                {"electrode_width", 0.2},
                                                {"contact_impedance", impedance}}))
                                  .reference_voltages();
    const double error = relative_difference(complete, gap);
    EXPECT_LT(error, last / 2);
    last = error;
  }
  EXPECT_LT(last, 1e-3);
}

// Without impedance an electrode of two halves that are driven apart reads nothing: conductors
// short what lies below them. Wide ones take most of the voltage away.
TEST(Electrodes, WithoutImpedanceShortTheSheetBelow) {
  const double spacing = 2 * std::numbers::pi / 16;
  const auto size = [&](double share, double impedance) {
    return BorderModel(disc({{"electrode_model", "complete"},
                             {"electrode_width", share * spacing},
                             {"contact_impedance", impedance}}))
        .reference_voltages()
        .norm();
  };
  EXPECT_LT(size(0.9, 0), 0.7 * size(0.9, 10));
  EXPECT_NEAR(size(0.9, 0) / size(0.9, 1e-9), 1, 1e-4);
}

TEST(Electrodes, AreReciprocalWhateverTheyAre) {
  for (const char* model : {"gap", "complete"}) {
    json more = {{"electrode_model", model}, {"electrode_width_mm", 8}};
    if (std::string(model) == "complete") more["contact_impedance"] = 0.01;
    const Sensor sensor = rectangle(more);
    const BorderModel border(sensor);
    const VectorXd& reference = border.reference_voltages();
    for (const auto& [a, b] : reciprocal_pairs(sensor)) {
      EXPECT_NEAR(reference[a], reference[b], 1e-10 * reference.norm());
    }
    // The estimate of the error is the distance from reciprocity.
    const auto solution = border.solve_at(one_disc({0.3, 0.1}, 0.2, 0.5), 4);
    EXPECT_LT(solution.error, 1e-6 * solution.change.norm()) << model;
  }
}

TEST(Linearisation, OfAnySensorIsTheDifferenceOfTwoSolutions) {
  const json complete = {
      {"electrode_model", "complete"}, {"electrode_width", 0.15}, {"contact_impedance", 0.02}};
  json opposite = complete;
  opposite["drive"] = "opposite";
  constexpr double step = 1e-4;
  for (const Sensor& sensor :
       {rectangle(complete), disc(opposite), disc({{"drive", {{"skip", 3}}}})}) {
    const BorderModel model(sensor);
    const auto linear = model.linearise(one_disc({0.3, 0.1}, 0.2, 0.5), 4);
    const VectorXd forth = model.solve_at(one_disc({0.3 + step, 0.1}, 0.2, 0.5), 4).change;
    const VectorXd back = model.solve_at(one_disc({0.3 - step, 0.1}, 0.2, 0.5), 4).change;
    EXPECT_LT(relative_difference(linear.derivatives.col(0), (forth - back) / (2 * step)), 1e-4);
  }
}

TEST(EllipseModel, AgreesWithTheBorderModelForAnySensor) {
  const json complete = {
      {"electrode_model", "complete"}, {"electrode_width", 0.15}, {"contact_impedance", 0.02}};
  const json gap = {{"electrode_model", "gap"}, {"electrode_width", 0.15}};
  for (const Sensor& sensor : {rectangle(), rectangle(complete), disc(gap), disc(complete),
                               disc({{"drive", "opposite"}})}) {
    EllipseModel::Options options;
    options.resolution = 3;
    options.most_points = 80;
    const EllipseModel model(sensor, options);
    EllipticContact contact;
    contact.centre = {0.3, 0.1};
    contact.log_size = std::log(0.2);
    contact.log_ratio = std::log(0.5);
    EllipseModel::Workspace workspace;
    VectorXd change(model.pairs());
    Eigen::MatrixXd derivatives(model.pairs(), EllipticContact::parameters);
    ASSERT_TRUE(model.place({&contact, 1}, workspace));
    model.evaluate(workspace, change);
    model.derivatives(workspace, derivatives);
    const auto linear = BorderModel(sensor).linearise(one_disc({0.3, 0.1}, 0.2, 0.5), 4);
    const auto pairs = reciprocal_pairs(sensor);
    VectorXd exact(model.pairs());
    VectorXd slope(model.pairs());
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      exact[static_cast<Index>(p)] = linear.change[pairs[p][0]];
      slope[static_cast<Index>(p)] = linear.derivatives(pairs[p][0], 0);
    }
    EXPECT_LT(relative_difference(change, exact), 1e-6);
    EXPECT_LT(relative_difference(derivatives.col(0), slope), 1e-4);
  }
}

TEST(Symmetries, AreTheSheetsThatTheElectrodesShare) {
  EXPECT_EQ(symmetries(Sensor{}).size(), 8u);
  EXPECT_EQ(symmetries(disc()).size(), 8u);
  EXPECT_EQ(symmetries(rectangle({{"electrode_count", 24}})).size(), 4u);
  EXPECT_EQ(symmetries(rectangle()).size(), 2u);  // 32 do not part the sides evenly
  EXPECT_EQ(symmetries(disc({{"drive", "opposite"}})).size(), 8u);
  EXPECT_EQ(symmetries(disc({{"electrode_offset", 0.05}})).size(), 4u);
  EXPECT_EQ(
      symmetries(disc({{"drive", {{0, 5}, {1, 9}, {3, 12}}}, {"measurement", "adjacent"}})).size(),
      1u);
}

TEST(Symmetries, TurnTheVoltagesAsTheyTurnTheScene) {
  for (const Sensor& sensor : {rectangle({{"electrode_count", 24}}), disc({{"drive", "opposite"}}),
                               disc({{"drive", {{"skip", 1}}}})}) {
    const BorderModel model(sensor);
    const Eigen::Vector2d place(0.4, 0.15);
    const VectorXd change = model.solve_at(one_disc(place, 0.15, 0.4), 3).change;
    std::size_t found = 0;
    for (const Symmetry& symmetry : symmetries(sensor)) {
      const VectorXd turned = change(symmetry.channels);
      for (const Eigen::Matrix2d& turn : sensor.sheet->symmetries()) {
        const VectorXd there = model.solve_at(one_disc(turn * place, 0.15, 0.4), 3).change;
        if (relative_difference(turned, there) < 1e-6) ++found;
      }
    }
    EXPECT_EQ(found, symmetries(sensor).size());
  }
}

TEST(UniformSheet, ServesWhereTheGridDoesNot) {
  const Sensor between = sensor_of({{"electrode_count", 10}, {"image_grid", 16}});
  EXPECT_FALSE(fits_grid(between, 16));
  EXPECT_EQ(uniform_jacobian(between).rows(), 70);
  EXPECT_TRUE(fits_grid(Sensor{}, 24));
  EXPECT_EQ(uniform_reference(Sensor{}), ForwardModel(Sensor{}, 24).reference_voltages());
}

}  // namespace
}  // namespace ertbench
