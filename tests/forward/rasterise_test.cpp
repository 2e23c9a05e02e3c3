#include "forward/sheet/rasterise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/json.h"
#include "core/random.h"
#include "forward/data/scene_distribution.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

Contact make(Shape shape, Vector2d centre, Vector2d half_size, double angle, double ratio = 0.5) {
  Contact contact;
  contact.shape = shape;
  contact.centre = centre;
  contact.half_size = half_size;
  contact.angle = angle;
  contact.conductivity_ratio = ratio;
  return contact;
}

Contact polygon(std::vector<Vector2d> vertices, double ratio = 0.5) {
  Contact contact;
  contact.shape = Shape::polygon;
  contact.vertices = std::move(vertices);
  contact.conductivity_ratio = ratio;
  return contact;
}

Eigen::VectorXd ratios(const Scene& scene, int grid, Rasterisation rule = Rasterisation::area) {
  Eigen::VectorXd out(grid * grid);
  rasterise(scene, square_sheet()->pixels(grid), rule, out);
  return out;
}

/// Area that the image assigns to a contact.
double imaged_area(const Contact& contact, int grid) {
  const double pixel = 4.0 / (grid * grid);
  return pixel * (1 - ratios({{contact}}, grid).array()).sum() / (1 - contact.conductivity_ratio);
}

TEST(Rasterise, AreasAreExact) {
  for (const int grid : {24, 48, 7}) {
    SCOPED_TRACE(grid);
    EXPECT_NEAR(imaged_area(make(Shape::disc, {0.11, -0.3}, {0.2, 0.2}, 0), grid), pi * 0.04,
                1e-12);
    EXPECT_NEAR(imaged_area(make(Shape::disc, {0.11, -0.3}, {0.01, 0.01}, 0), grid), pi * 1e-4,
                1e-12);
    EXPECT_NEAR(imaged_area(make(Shape::ellipse, {-0.2, 0.3}, {0.4, 0.07}, 0.7), grid),
                pi * 0.4 * 0.07, 1e-12);
    EXPECT_NEAR(imaged_area(make(Shape::rectangle, {0.2, 0.1}, {0.3, 0.05}, -1.1), grid),
                4 * 0.3 * 0.05, 1e-12);
    // An L, which is not convex.
    EXPECT_NEAR(
        imaged_area(polygon({{0, 0}, {0.5, 0}, {0.5, 0.2}, {0.13, 0.2}, {0.13, 0.6}, {0, 0.6}}),
                    grid),
        0.5 * 0.2 + 0.13 * 0.4, 1e-12);
  }
}

TEST(Rasterise, WhatLiesOutsideTheSheetIsCutOff) {
  EXPECT_NEAR(imaged_area(make(Shape::disc, {1, 0}, {0.3, 0.3}, 0), 24), pi * 0.09 / 2, 1e-12);
  EXPECT_NEAR(imaged_area(make(Shape::disc, {-1, -1}, {0.3, 0.3}, 0), 24), pi * 0.09 / 4, 1e-12);
  EXPECT_EQ(ratios({{make(Shape::disc, {3, 0}, {0.3, 0.3}, 0)}}, 24), Eigen::VectorXd::Ones(576));
  EXPECT_EQ(ratios({{make(Shape::rectangle, {0, 0}, {3, 3}, 0.2)}}, 24),
            Eigen::VectorXd::Constant(576, 0.5));
}

/// Every pixel against counting points, for random shapes.
TEST(Rasterise, CoverageEqualsCounting) {
  SceneDistribution distribution;
  distribution.contacts = {1, 1};
  distribution.inside = false;
  constexpr int grid = 12;
  constexpr int points = 100;
  for (std::uint64_t s = 0; s < 24; ++s) {
    SCOPED_TRACE(s);
    RandomStream random(3, 0, s, Purpose::scene);
    const Scene scene = distribution.draw(random, *square_sheet());
    const Contact& contact = scene.contacts[0];
    const Eigen::VectorXd image = ratios(scene, grid);
    for (int p = 0; p < grid * grid; ++p) {
      int inside = 0;
      for (int i = 0; i < points; ++i) {
        for (int j = 0; j < points; ++j) {
          inside += contact.contains({-1 + 2.0 / grid * (p % grid + (i + 0.5) / points),
                                      -1 + 2.0 / grid * (p / grid + (j + 0.5) / points)});
        }
      }
      const double counted = 1 + (contact.conductivity_ratio - 1) * inside / (points * points);
      // A border of length <= 8 pixel sides crosses <= 8 * points cells; half of each is in doubt.
      EXPECT_NEAR(image[p], counted, 4.0 / points) << "pixel " << p;
    }
  }
}

TEST(Rasterise, LowestRatioCountsWhereContactsOverlap) {
  const Contact weak = make(Shape::disc, {0.05, 0}, {0.3, 0.3}, 0, 0.8);
  const Contact strong = make(Shape::rectangle, {0.25, 0.1}, {0.2, 0.3}, 0.3, 0.2);
  const Eigen::VectorXd one = ratios({{weak, strong}}, 24);
  EXPECT_EQ(one, ratios({{strong, weak}}, 24)) << "the order must not matter";
  const Eigen::VectorXd centres = ratios({{weak, strong}}, 24, Rasterisation::centre);
  constexpr int points = 100;
  for (int p = 0; p < 576; ++p) {
    double sum = 0;
    for (int i = 0; i < points * points; ++i) {
      const Vector2d x(-1 + (p % 24 + (i % points + 0.5) / points) / 12.0,
                       -1 + (p / 24 + (i / points + 0.5) / points) / 12.0);
      sum += strong.contains(x) ? 0.2 : weak.contains(x) ? 0.8 : 1;
    }
    EXPECT_NEAR(one[p], sum / (points * points), 4.0 / points) << "pixel " << p;
    const Vector2d centre(-1 + (p % 24 + 0.5) / 12.0, -1 + (p / 24 + 0.5) / 12.0);
    EXPECT_EQ(centres[p], strong.contains(centre) ? 0.2 : weak.contains(centre) ? 0.8 : 1);
  }
}

TEST(Rasterise, TheSameContactTwiceIsOneContact) {
  const Contact disc = make(Shape::disc, {0.1, 0.2}, {0.3, 0.3}, 0);
  const Eigen::VectorXd once = ratios({{disc}}, 24);
  const Eigen::VectorXd twice = ratios({{disc, disc}}, 24);
  // Cut pixels are now integrated line by line: the midpoint rule's error on a circle's border.
  EXPECT_LT((once - twice).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_GT((once.array() - 1).abs().sum(), 1);
}

TEST(Rasterise, FineImageAveragesToTheCoarseOne) {
  const Scene scene = {{make(Shape::ellipse, {0.3, -0.4}, {0.35, 0.2}, 1.0, 0.3)}};
  const Eigen::VectorXd coarse = ratios(scene, 24);
  const Eigen::VectorXd fine = ratios(scene, 96);
  for (int p = 0; p < 576; ++p) {
    double sum = 0;
    for (int i = 0; i < 16; ++i) sum += fine[4 * (p % 24) + i % 4 + 96 * (4 * (p / 24) + i / 4)];
    EXPECT_NEAR(coarse[p], sum / 16, 1e-12);
  }
}

TEST(SceneDistribution, KeepsItsPromises) {
  SceneDistribution distribution;
  distribution.blank_fraction = 0.25;
  int blank = 0;
  std::array<int, 4> kinds{};
  constexpr int scenes = 4000;
  for (std::uint64_t s = 0; s < scenes; ++s) {
    RandomStream random(8, key_of("train"), s, Purpose::scene);
    const Scene scene = distribution.draw(random, *square_sheet());
    blank += scene.contacts.empty();
    ASSERT_LE(scene.contacts.size(), 3u);
    for (const Contact& contact : scene.contacts) {
      ++kinds[static_cast<std::size_t>(contact.shape)];
      EXPECT_GE(contact.conductivity_ratio, 0.1);
      EXPECT_LE(contact.conductivity_ratio, 0.9);
      const Eigen::AlignedBox2d box = contact.bounds();
      EXPECT_GE(box.min().minCoeff(), -1 - 1e-12);
      EXPECT_LE(box.max().maxCoeff(), 1 + 1e-12);
      EXPECT_LE(box.sizes().maxCoeff(), 0.8 + 1e-12);
      EXPECT_TRUE(contact.contains(contact.centroid()));
    }
  }
  // Five standard errors of a share of 1/4.
  EXPECT_NEAR(blank / double(scenes), 0.25, 5 * std::sqrt(0.25 * 0.75 / scenes));
  const double contacts = kinds[0] + kinds[1] + kinds[2] + kinds[3];
  for (const int kind : kinds) {
    EXPECT_NEAR(kind / contacts, 0.25, 5 * std::sqrt(0.25 * 0.75 / contacts));
  }
}

/// Scenes of one contact of the shape, inside the sheet.
Scene drawn(SceneDistribution distribution, DrawnShape shape, std::uint64_t index) {
  distribution.contacts = {1, 1};
  distribution.shapes = {shape};
  RandomStream random(8, key_of("test"), index, Purpose::scene);
  return distribution.draw(random, *square_sheet());
}

TEST(SceneDistribution, DrawsRingsCrossesAndBars) {
  const double sectors = 30;
  const double inscribed = sectors / 2 * std::sin(2 * pi / sectors);  // of a unit circle's area
  const double tip = 1 / std::sqrt(1 + 0.35 * 0.35);
  const double arm = 0.35 * tip;
  const std::map<DrawnShape, double> areas = {
      {DrawnShape::ring, inscribed * (1 - 0.55 * 0.55)},
      {DrawnShape::cross, 2 * (2 * tip) * (2 * arm) - 4 * arm * arm},
      {DrawnShape::bar, 4 * 0.12 / (1 + 0.12 * 0.12)}};
  for (const auto& [shape, area] : areas) {
    SCOPED_TRACE(name_of(shape));
    for (std::uint64_t s = 0; s < 20; ++s) {
      const Contact disc = drawn({}, DrawnShape::disc, s).contacts.front();
      const Contact contact = drawn({}, shape, s).contacts.front();
      const double radius = disc.half_size.x();
      EXPECT_NEAR(imaged_area(contact, 24), area * radius * radius, 1e-9);
      EXPECT_LT((contact.centroid() - disc.centre).norm(), 1e-9) << "paired with the disc";
      EXPECT_EQ(contact.contains(disc.centre), shape != DrawnShape::ring);
    }
  }
}

TEST(SceneDistribution, PlacesContactsWhereItIsTold) {
  SceneDistribution distribution;
  distribution.centre.emplace(std::pair(0.7, 0.7), std::pair(-0.2, 0.0));
  for (std::uint64_t s = 0; s < 20; ++s) {
    const Contact contact = drawn(distribution, DrawnShape::disc, s).contacts.front();
    EXPECT_EQ(contact.centre.x(), 0.7);
    EXPECT_GE(contact.centre.y(), -0.2);
    EXPECT_LE(contact.centre.y(), 0.0);
  }
}

TEST(SceneDistribution, SetsTwoContactsApart) {
  SceneDistribution distribution;
  distribution.contacts = {2, 2};
  distribution.shapes = {DrawnShape::disc};
  distribution.radius = {0.1, 0.3};
  for (const double gap : {0.0, 0.3, 0.8}) {
    distribution.gap = {gap, gap};
    for (std::uint64_t s = 0; s < 200; ++s) {
      RandomStream random(8, key_of("test"), s, Purpose::scene);
      const Scene scene = distribution.draw(random, *square_sheet());
      ASSERT_EQ(scene.contacts.size(), 2u);
      const Contact& a = scene.contacts[0];
      const Contact& b = scene.contacts[1];
      EXPECT_NEAR((a.centre - b.centre).norm() - a.half_size.x() - b.half_size.x(), gap, 1e-12);
      for (const Contact& contact : scene.contacts) {
        EXPECT_LE(contact.centre.cwiseAbs().maxCoeff() + contact.half_size.x(), 1 + 1e-12);
      }
    }
  }
}

TEST(SceneDistribution, WritesNewKeysOnlyWhereTheyAreUsed) {
  const auto round_trip = [](const nlohmann::json& json) {
    return to_json(scene_distribution_from_json(JsonObject(json, "", ""), *square_sheet()));
  };
  const nlohmann::json plain = round_trip(nlohmann::json::object());
  EXPECT_FALSE(plain.contains("centre"));
  EXPECT_FALSE(plain.contains("gap"));
  const nlohmann::json placed = round_trip({{"centre", {{"x", 0.5}, {"y", {-1, 1}}}}});
  EXPECT_EQ(placed.at("centre"), nlohmann::json({{"x", {0.5, 0.5}}, {"y", {-1.0, 1.0}}}));
  EXPECT_THROW(round_trip({{"gap", 0.1}}), InputError);
  EXPECT_THROW(round_trip({{"contacts", 2}, {"radius", 0.4}, {"gap", 0.5}}), InputError);
}

}  // namespace
}  // namespace ertbench
