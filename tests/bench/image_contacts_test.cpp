// Contacts read out of images, and what is kept of a frame.

#include "bench/score/image_contacts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/bench/disc_scenes.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::Vector2d;
using testing::kSensor;
using testing::true_change;

constexpr double kMm = 100;  // of a domain unit of the default sheet

Contact disc_mm(double x_mm, double y_mm, double radius_mm, double ratio = 0.6) {
  Contact contact;
  contact.centre = Vector2d(x_mm, y_mm) / kMm;
  contact.half_size = Vector2d::Constant(radius_mm / kMm);
  contact.conductivity_ratio = ratio;
  return contact;
}

/// Blobs exp(-r²/2s²) of given heights, S/m, as blurred images have them.
RowVectorXd blobs(const std::vector<std::pair<Vector2d, double>>& all_mm, double s_mm) {
  RowVectorXd out = RowVectorXd::Zero(kSensor.pixels());
  for (int p = 0; p < out.size(); ++p) {
    for (const auto& [place, height] : all_mm) {
      const double r = (kMm * kSensor.image().centre(p) - place).norm();
      out[p] += height * std::exp(-r * r / (2 * s_mm * s_mm));
    }
  }
  return out;
}

std::vector<FoundContact> read(const RowVectorXd& change, const ContactRule& rule = {}) {
  return contacts_of_image(kSensor, rule, change);
}

TEST(ImageContacts, TwoDiscs30MmApartAreTwo) {
  // 30 mm from centre to centre with a radius of 10 mm: 10 mm, more than a pixel (8.3 mm), lie
  // between them.
  const auto found =
      read(true_change({{disc_mm(-40, 10, 10, 0.4), disc_mm(-10, 10, 10, 0.6)}, {}}));
  ASSERT_EQ(found.size(), 2u);
  // A pixel of the rim that is below the threshold is missed on one side: 8.3 mm away, it weighs a
  // quarter of a peak beside an area of 4.5 peaks, 0.5 mm; there are a few.
  EXPECT_LT((found[0].place * kMm - Vector2d(-40, 10)).norm(), 2) << "the stronger first";
  EXPECT_LT((found[1].place * kMm - Vector2d(-10, 10)).norm(), 2);
  // The area below the threshold is missing: the rims of the disc.
  const double whole = 0.6 * kSensor.background * std::numbers::pi * 0.1 * 0.1;
  EXPECT_LE(found[0].strength, whole * (1 + 1e-9));
  EXPECT_GT(found[0].strength, 0.8 * whole);
  EXPECT_NEAR(found[0].peak, 0.6 * kSensor.background, 1e-12);
}

TEST(ImageContacts, BlobsThatTouchAreTwoWhereTheSaddleIsLow) {
  // Two blobs of deviation s at a distance d have 2 exp(-d²/8s²) of the height of one between them:
  // .65 at 3 s.
  const RowVectorXd far = blobs({{{-22.5, 4}, -0.02}, {{22.5, 4}, -0.02}}, 15);
  ASSERT_EQ(read(far).size(), 2u);
  ContactRule rule;
  rule.saddle = 0.5;
  EXPECT_EQ(read(far, rule).size(), 1u) << ".65 is above that saddle";
  rule.saddle = 0.7;
  // .9 at 2.53 s.
  EXPECT_EQ(read(blobs({{{-19, 4}, -0.02}, {{19, 4}, -0.02}}, 15), rule).size(), 1u);

  const auto found = read(far);
  const double middle = found[0].place.x() + found[1].place.x();
  EXPECT_NEAR(middle, 0, 0.05) << "each pixel goes up its own side";
  EXPECT_GT(std::abs(found[0].place.x() - found[1].place.x()) * kMm, 40);
}

TEST(ImageContacts, NoPixelIsLostAndNoneCountsTwice) {
  const RowVectorXd change = blobs({{{-30, 0}, -0.02}, {{20, 10}, -0.015}, {{0, -45}, -0.01}}, 14);
  double strength = 0;
  double area = 0;
  for (const FoundContact& contact : read(change)) {
    strength += contact.strength;
    area += contact.area;
  }
  const double limit = 0.25 * change.cwiseAbs().maxCoeff();
  const double pixel = kSensor.image().pixel_area();
  const auto bright = change.array().abs() >= limit;
  EXPECT_NEAR(strength, pixel * bright.select(change.array().abs(), 0.0).sum(), 1e-12);
  EXPECT_NEAR(area, pixel * static_cast<double>(bright.count()), 1e-12);
}

TEST(ImageContacts, PlateausAndRidgesAreOne) {
  EXPECT_EQ(read(RowVectorXd::Constant(kSensor.pixels(), -0.01)).size(), 1u);
  Contact ring_part;
  ring_part.shape = Shape::rectangle;
  ring_part.half_size = {0.6, 0.1};
  ring_part.angle = 0.7;
  EXPECT_EQ(read(true_change({{ring_part}, {}})).size(), 0u) << "a ratio of 1 is no change";
  ring_part.conductivity_ratio = 0.5;
  EXPECT_EQ(read(true_change({{ring_part}, {}})).size(), 1u);
}

TEST(ImageContacts, SignsAreKeptApart) {
  RowVectorXd change = RowVectorXd::Zero(kSensor.pixels());
  change.segment(100, 3) << -0.01, -0.012, 0.011;
  const auto found = read(change);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].peak, 0.012, 1e-15);
  EXPECT_NEAR(found[1].peak, 0.011, 1e-15);
}

TEST(ImageContacts, TheRuleSaysWhatCounts) {
  const RowVectorXd change =
      true_change({{disc_mm(-40, 10, 20, 0.5), disc_mm(40, 10, 20, 0.9)}, {}});
  EXPECT_EQ(read(change).size(), 1u) << "the weak one has a fifth";
  ContactRule rule;
  rule.threshold = 0.15;
  EXPECT_EQ(read(change, rule).size(), 2u);
  rule.floor = 0.2;
  EXPECT_EQ(read(change, rule).size(), 1u);
  rule.floor = 0.51;
  EXPECT_EQ(read(change, rule).size(), 0u);
  EXPECT_EQ(read(RowVectorXd::Zero(kSensor.pixels())).size(), 0u);
}

TEST(ImageContacts, AReaderRemembersNothing) {
  ContactReader reader(kSensor);
  std::vector<FoundContact> found;
  const RowVectorXd two = true_change({{disc_mm(-40, 10, 10), disc_mm(-10, 10, 10)}, {}});
  const RowVectorXd none = RowVectorXd::Zero(kSensor.pixels());
  for (int i = 0; i < 3; ++i) {
    reader.read({}, two, found);
    EXPECT_EQ(found.size(), 2u);
    reader.read({}, none, found);
    EXPECT_EQ(found.size(), 0u);
  }
}

TEST(ImageContacts, TruePlacesLieOnTheSheet) {
  Contact triangle;
  triangle.shape = Shape::polygon;
  triangle.vertices = {{0, 0}, {0.3, 0}, {0, 0.3}};
  const Scene scene{{disc_mm(104, 0, 20), disc_mm(96, -50, 20), triangle}, {}};
  const auto places = true_places_mm(kSensor, scene);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_LT((places[0] - Vector2d(96, -50)).norm(), 1e-9);
  EXPECT_LT((places[1] - Vector2d(10, 10)).norm(), 1e-9);
}

TEST(FrameReading, IsInMillimetres) {
  // One disc's sum is its area times the change; its centroid is its centre.
  const RowVectorXd change = true_change({{disc_mm(-41, 13, 20, 0.5)}, {}});
  const FrameReading reading = frame_reading(kSensor, change, read(change));
  EXPECT_NEAR(reading.peak.value(), -0.5 * kSensor.background, 1e-12);
  EXPECT_NEAR(reading.sum.value(), -0.5 * kSensor.background * std::numbers::pi * 400, 1e-9);
  // C4 weighs pixel centres: a pixel covered in part pulls by less than its half side.
  EXPECT_LT((reading.centroid_mm.value() - Vector2d(-41, 13)).norm(), 0.5);
  EXPECT_LT((reading.centroid25_mm.value() - Vector2d(-41, 13)).norm(), 0.5);
  ASSERT_EQ(reading.contacts.size(), 1u);
  EXPECT_LT((reading.contacts[0].place_mm - Vector2d(-41, 13)).norm(), 0.5);
  EXPECT_NEAR(reading.contacts[0].strength, -reading.sum.value(), 0.05 * -reading.sum.value());
  EXPECT_NEAR(reading.contacts[0].area_mm2, std::numbers::pi * 400, 0.3 * 400 * std::numbers::pi);

  const FrameReading empty = frame_reading(kSensor, RowVectorXd::Zero(kSensor.pixels()), {});
  EXPECT_EQ(empty.centroid_mm, std::nullopt);
  EXPECT_EQ(empty.centroid25_mm, std::nullopt);
  EXPECT_EQ(empty.sum, 0);
}

}  // namespace
}  // namespace ertbench
