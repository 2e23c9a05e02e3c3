#include "forward/sheet/sheet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/errors.h"
#include "disc_sheet.h"
#include "forward/border/border_layout.h"
#include "forward/border/border_model.h"
#include "forward/data/faults.h"
#include "forward/data/scene_distribution.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"
#include "forward/sheet/sensor.h"

namespace ertbench {
namespace {

using std::numbers::pi;
using testing::disc_sensor;
using testing::DiscSheet;

constexpr std::uint64_t seed = 20240611;

Contact disc_at(double x, double y, double radius, double ratio) {
  Contact contact;
  contact.centre = {x, y};
  contact.half_size.setConstant(radius);
  contact.conductivity_ratio = ratio;
  return contact;
}

std::complex<double> on_disc(const Sheet& sheet, double along) {
  const Eigen::Vector2d at = sheet.border_point(along);
  return sheet.to_disc({at.x(), at.y()}).w;
}

TEST(Sheet, TheMapTakesTheBorderClockwiseRoundTheCircle) {
  const DiscSheet round;
  for (const Sheet* sheet : {square_sheet().get(), static_cast<const Sheet*>(&round)}) {
    SCOPED_TRACE(sheet->name());
    constexpr int steps = 400;
    double turned = 0;
    for (int i = 0; i < steps; ++i) {
      const std::complex<double> here = on_disc(*sheet, sheet->border_length() * i / steps);
      const std::complex<double> next = on_disc(*sheet, sheet->border_length() * (i + 1) / steps);
      EXPECT_NEAR(std::abs(here), 1, 1e-13);
      const double step = std::arg(next / here);
      EXPECT_LT(step, 0);
      turned += step;
    }
    EXPECT_NEAR(turned, -2 * pi, 1e-9);
  }
}

TEST(Sheet, TheSquaresElectrodesLieAsItsSymmetriesSay) {
  // Corners and middles of the sides are eighths of the circle. An electrode lies as far from the
  // corner before it as its mirror image from the corner behind.
  const Sheet& sheet = *square_sheet();
  for (int eighth = 0; eighth < 8; ++eighth) {
    const double expected = pi / 2 - pi / 4 * eighth;  // the corner (-1, 1) goes to i
    EXPECT_NEAR(std::arg(on_disc(sheet, eighth) / std::polar(1.0, expected)), 0, 1e-12);
  }
  for (int e = 0; e < 16; ++e) {
    const double corner = 2 * (e / 4);
    const double along = 0.25 + 0.5 * e;
    const std::complex<double> before = on_disc(sheet, along) / on_disc(sheet, corner);
    const std::complex<double> mirrored =
        on_disc(sheet, corner + 2) / on_disc(sheet, 2 * corner + 2 - along);
    EXPECT_NEAR(std::arg(before / mirrored), 0, 1e-12) << "electrode " << e;
  }
}

TEST(Sheet, ThePixelsOnItHaveItsArea) {
  for (const int side : {24, 25, 48, 96}) {
    const PixelGrid square = square_sheet()->pixels(side);
    EXPECT_TRUE(square.all_on_sheet());
    EXPECT_NEAR(square.count_on_sheet() * square.pixel_area(), square_sheet()->area(), 1e-12);

    const DiscSheet round;
    const PixelGrid pixels = round.pixels(side);
    // What is left out are slivers, at most a hundredth of a pixel each on the border's way.
    double area = 0;
    for (int p = 0; p < pixels.count(); ++p) area += pixels.part_on_sheet(p) * pixels.pixel_area();
    EXPECT_NEAR(area, round.area(), 0.02 * 8 * pixels.pixel().x());
    EXPECT_GE(pixels.count_on_sheet() * pixels.pixel_area(), area);
    EXPECT_FALSE(pixels.on_sheet(0));
    EXPECT_TRUE(pixels.on_sheet(side / 2 + side * (side / 2)));
  }
}

TEST(Sheet, DepthAndBoxes) {
  const Sheet& square = *square_sheet();
  EXPECT_DOUBLE_EQ(square.depth({0.2, -0.7}), 0.3);
  EXPECT_DOUBLE_EQ(square.depth({1.3, 1.4}), -0.5);
  EXPECT_DOUBLE_EQ(square.depth({0, -1.25}), -0.25);
  EXPECT_DOUBLE_EQ(square.size_mm().x(), 200);
  const Eigen::AlignedBox2d box(Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(0.8, 0.8));
  EXPECT_TRUE(square.encloses(box, 0.2 - 1e-12));
  EXPECT_FALSE(square.encloses(box, 0.21));
  EXPECT_FALSE(DiscSheet().encloses(box));  // its corner is 1.13 from the middle
}

TEST(Sheet, AnotherOneMakesAnotherSensor) {
  Sensor sensor;
  sensor.sheet = std::make_shared<const DiscSheet>();
  EXPECT_NE(sensor, Sensor{});
  EXPECT_NE(disc_sensor(), sensor);  // by the offset of its electrodes
  const Eigen::Matrix2Xd places = electrode_positions(disc_sensor());
  for (int e = 0; e < 16; ++e) {
    const double angle = 2 * pi * (e + 0.5) / 16;
    EXPECT_NEAR((places.col(e) - Eigen::Vector2d(std::sin(angle), std::cos(angle))).norm(), 0,
                1e-12);
  }
  try {
    ForwardModel(disc_sensor(), 24);
    FAIL() << "the grid model took a disc";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("not a disc"), std::string::npos);
  }
}

TEST(Sheet, ADiscInTheMiddleOfADiscHasTheVoltagesOfSeparation) {
  // Under the current cos(n t) through the border, the potential there is
  // (1 + m a^2n) / (n (1 - m a^2n)) cos(n t), m = (1 - k) / (1 + k), for a disc of radius a and
  // conductivity ratio k; m = 0 without it. A point current is 1 / 2 pi plus the sum of
  // cos(n t) / pi.
  constexpr double radius = 0.6;
  for (const double ratio : {0.2, 3.0}) {
    const Sensor sensor = disc_sensor();
    const double m = (1 - ratio) / (1 + ratio);
    const auto impedance = [&](int i, int j) {
      double sum = 0;
      for (int n = 1; n <= 60; ++n) {
        const double share = m * std::pow(radius, 2 * n);
        sum += 2 * share / (1 - share) / (pi * n) * std::cos(2 * pi * n * (i - j) / 16);
      }
      return sum;
    };
    const BorderModel model(sensor);
    const double size = model.reference_voltages().norm();
    const Eigen::VectorXd change =
        model.solve({{disc_at(0, 0, radius, ratio)}}, 1e-10 * size).change;
    const std::vector<Channel> channels = channels_of(sensor);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto [d, e] = channels[c];
      const double expected =
          -sensor.drive_current / sensor.background *
          (impedance(e + 1, d + 1) - impedance(e + 1, d) - impedance(e, d + 1) + impedance(e, d));
      EXPECT_NEAR(change[static_cast<Eigen::Index>(c)], expected, 1e-9 * size) << "channel " << c;
    }
  }
}

TEST(Sheet, ADiscCutsWhatSticksOut) {
  const auto arcs = contact_arcs({{disc_at(0.9, 0, 0.3, 0.5)}}, DiscSheet());
  ASSERT_EQ(arcs.size(), 1u);
  EXPECT_TRUE(arcs[0].begins_at_sheet && arcs[0].ends_at_sheet);
  EXPECT_NEAR(std::abs(arcs[0].piece.at(arcs[0].begin).z), 1, 1e-9);
  EXPECT_NEAR(std::abs(arcs[0].piece.at(arcs[0].end).z), 1, 1e-9);
  EXPECT_TRUE(contact_arcs({{disc_at(0.9, 0.9, 0.2, 0.5)}}, DiscSheet()).empty());
  // It is the cut that counts: the estimate from reciprocity comes down as the points grow.
  const BorderModel model(disc_sensor());
  const auto solution = model.solve({{disc_at(0.9, 0, 0.3, 0.5)}}, 1e-6);
  EXPECT_LE(solution.error, 1e-6);
  EXPECT_GT(solution.change.norm(), 1e-3 * model.reference_voltages().norm());
}

TEST(Sheet, AnImageOfADiscHasNoChangeBesideIt) {
  const DiscSheet round;
  const PixelGrid pixels = round.pixels(24);
  Eigen::VectorXd ratio(pixels.count());
  for (const Rasterisation rule : {Rasterisation::area, Rasterisation::centre}) {
    rasterise({{disc_at(0, 0, 2, 0.5)}}, pixels, rule, ratio);
    for (int p = 0; p < pixels.count(); ++p) {
      EXPECT_EQ(ratio[p], pixels.on_sheet(p) ? 0.5 : 1) << "pixel " << p;
    }
  }
}

TEST(Sheet, PixelsNeedNotBeSquares) {
  // An image of 12 x 30 pixels of [-2, 2] x [0, 1]: the mean over its area is that of the contact.
  const PixelGrid pixels({Eigen::Vector2d(-2, 0), Eigen::Vector2d(2, 1)}, 12, 30);
  Eigen::VectorXd ratio(pixels.count());
  rasterise({{disc_at(0.3, 0.5, 0.4, 0.25)}}, pixels, Rasterisation::area, ratio);
  EXPECT_NEAR((1 - ratio.array()).sum() * pixels.pixel_area(), 0.75 * pi * 0.16, 1e-12);
  // Two that overlap, along lines across the pixels: to the distance of the lines.
  rasterise({{disc_at(0.2, 0.5, 0.3, 0.25), disc_at(0.4, 0.5, 0.3, 0.25)}}, pixels,
            Rasterisation::area, ratio);
  const double lens = 2 * 0.09 * std::acos(1.0 / 3) - 0.1 * std::sqrt(0.36 - 0.04);
  EXPECT_NEAR((1 - ratio.array()).sum() * pixels.pixel_area(), 0.75 * (2 * pi * 0.09 - lens), 1e-4);
}

TEST(Sheet, ContactsArePlacedOnADisc) {
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  const DiscSheet round;
  SceneDistribution distribution;
  distribution.contacts = {1, 1};
  distribution.shapes = {DrawnShape::disc};
  distribution.radius = {0.2, 0.2};
  constexpr int count = 2000;
  double square = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    RandomStream random(seed, 1, i, Purpose::scene);
    const Contact contact = distribution.draw(random, round).contacts.front();
    EXPECT_GE(round.depth(contact.centre), 0.2 - 1e-9);
    square += contact.centre.squaredNorm() / count;
  }
  // Uniform over a disc of radius .8: the mean square is .32, its variance .8^4 / 12 a contact.
  EXPECT_NEAR(square, 0.32, 4 * std::sqrt(std::pow(0.8, 4) / 12 / count));

  distribution.contacts = {2, 2};
  distribution.gap = {0.3, 0.9};
  for (std::uint64_t i = 0; i < 500; ++i) {
    RandomStream random(seed, 2, i, Purpose::scene);
    const Scene scene = distribution.draw(random, round);
    for (const Contact& contact : scene.contacts) {
      EXPECT_GE(round.depth(contact.centre), 0.2 - 1e-9) << "scene " << i;
    }
    const double distance = (scene.contacts[1].centre - scene.contacts[0].centre).norm();
    EXPECT_GE(distance, 0.7 - 1e-9);
    EXPECT_LE(distance, 1.3 + 1e-9);
  }
}

TEST(Sheet, TurningADiscTurnsItsVoltages) {
  const Sensor sensor = disc_sensor();
  const std::vector<Symmetry> all = symmetries(sensor);
  ASSERT_EQ(all.size(), 8u);
  const BorderModel model(sensor);
  const PixelGrid pixels = sensor.image();
  const Contact contact = disc_at(0.5, 0.2, 0.2, 0.3);
  const Eigen::VectorXd change = model.solve({{contact}}, 1e-9).change;
  Eigen::VectorXd image(pixels.count());
  rasterise({{contact}}, pixels, Rasterisation::area, image);
  const std::vector<Eigen::Matrix2d> turns = sensor.sheet->symmetries();
  for (std::size_t t = 0; t < turns.size(); ++t) {
    Contact turned = contact;
    turned.centre = turns[t] * contact.centre;
    const Eigen::VectorXd expected = model.solve({{turned}}, 1e-9).change;
    Eigen::VectorXd expected_image(pixels.count());
    rasterise({{turned}}, pixels, Rasterisation::area, expected_image);
    for (std::size_t c = 0; c < all[t].channels.size(); ++c) {
      EXPECT_NEAR(change[all[t].channels[c]], expected[static_cast<Eigen::Index>(c)], 1e-8);
    }
    for (std::size_t p = 0; p < all[t].pixels.size(); ++p) {
      EXPECT_NEAR(image[all[t].pixels[p]], expected_image[static_cast<Eigen::Index>(p)], 1e-12);
    }
  }
}

TEST(Sheet, AGradientReachesItsSizeAtTheRadius) {
  Faults faults;
  faults.background_gradient = 0.5;
  const DiscSheet round;
  for (const Sheet* sheet : {square_sheet().get(), static_cast<const Sheet*>(&round)}) {
    SCOPED_TRACE(sheet->name());
    const PixelGrid pixels = sheet->pixels(32);
    RandomStream random(seed, 3, 0, Purpose::gradient);
    const Eigen::VectorXd factors = gradient_factors(faults, *sheet, pixels, random);
    EXPECT_NEAR(factors.mean(), 1, 1e-12);
    for (int p = 0; p < pixels.count(); ++p) {
      EXPECT_LE(std::abs(factors[p] - 1), 0.5 * pixels.centre(p).norm() / sheet->radius() + 1e-12);
    }
    EXPECT_GT(factors.maxCoeff(), 1.5 / sheet->radius());
  }
}

}  // namespace
}  // namespace ertbench
