#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/json.h"
#include "forward/touch/indenter.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::VectorXd;

Indenter indenter(const char* text) {
  const auto json = nlohmann::json::parse(text);
  return indenter_from_json(JsonObject(json, "test", ""));
}

const Indenter kBall = indenter(R"({"type": "sphere", "radius_mm": 15})");
const Indenter kDisc = indenter(R"({"type": "flat", "radius_mm": 10})");
const Indenter kFinger = indenter(R"({"type": "finger", "angle": 0.4})");
const Indenter kTriangle =
    indenter(R"({"type": "flat", "vertices_mm": [[-9, -6], [9, -6], [0, 12]]})");

Sensor sensor_with(ContactLaw law = {}) {
  Sensor sensor;
  sensor.skin = Skin{};
  sensor.skin->law = law;
  return sensor;
}

/// Force on the boxes of a grid over [-60, 60]^2 mm, N.
double integrated(const Touch& touch, double cell_mm) {
  double newton = 0;
  for (double x = -60; x < 60 - 1e-9; x += cell_mm) {
    for (double y = -60; y < 60 - 1e-9; y += cell_mm) {
      const AlignedBox2d box(Vector2d(x, y), Vector2d(x + cell_mm, y + cell_mm));
      newton += mean_pressure_kPa(touch, Foam{}, box) * box.volume() / 1000;
    }
  }
  return newton;
}

TEST(Touch, PressureIntegratesToTheForce) {
  for (const Indenter& one : {kBall, kDisc, kFinger, kTriangle}) {
    for (const double force : {0.1, 1.0, 10.0}) {
      const Touch touch{one, {3.7, -12.2}, force};
      EXPECT_NEAR(integrated(touch, 7.5), force, 1e-9 * force) << one.text();
      EXPECT_NEAR(integrated(touch, 20), force, 1e-9 * force) << one.text();
    }
  }
}

TEST(Touch, BallHasWinklersContactRadiusAndPeak) {
  // F = pi k a^4 / 4R, p0 = k a^2 / 2R with k = 0.5 MPa / 3 mm: at 10 N a = 5.82 mm.
  const Touch touch{kBall, {0, 0}, 10};
  const double a = std::pow(4 * 15 * 10 / (std::numbers::pi * 0.5 / 3), 0.25);
  EXPECT_NEAR(footprint_mm(touch, Foam{}).half_size.x(), a, 1e-12);
  EXPECT_NEAR(a, 5.82, 0.01);
  const double tiny = 1e-4;
  const AlignedBox2d middle(Vector2d(-tiny, -tiny), Vector2d(tiny, tiny));
  EXPECT_NEAR(mean_pressure_kPa(touch, Foam{}, middle), 0.5 / 3 * a * a / 30 * 1000, 1e-4);
}

TEST(Touch, WhatFallsOffTheSheetPressesNothing) {
  const Sensor sensor = sensor_with();
  // Half of the disc is on the sheet; patches cover 0.81 of what is.
  const Touch edge{kDisc, {100, 0}, 10};
  const double newton = relaxed_pressure_kPa(sensor, std::vector{edge}).sum() * 7.5 * 7.5 / 1000;
  EXPECT_NEAR(newton, 0.81 * 5, 0.6);
  EXPECT_EQ(relaxed_pressure_kPa(sensor, std::vector{Touch{kDisc, {150, 0}, 10}}).sum(), 0);
}

TEST(Touch, ConductivityOfAPatchIsWhatItsLawSays) {
  // A flat punch of radius 30 mm around the corner of four patches covers them whole: p = F / S.
  Touch touch{indenter(R"({"type": "flat", "radius_mm": 30})"), {0, 0}, 20};
  const double pressure = 20 / (std::numbers::pi * 900) * 1000;
  for (const ContactLaw& law : {ContactLaw(FallingLaw{}), ContactLaw(RisingLaw{})}) {
    const Sensor sensor = sensor_with(law);
    const Scene scene = still_scene(sensor, std::vector{touch});
    const int middle = 12 + 24 * 12;
    EXPECT_NEAR(scene.patches->ratio[middle], conductivity_ratio(law, pressure), 1e-12);
    EXPECT_EQ(scene.patches->ratio[0], 1);
    // A pixel of the image holds one patch, and around it sheet that nothing touches.
    VectorXd image(576);
    rasterise(*scene.patches, sensor.image(), image);
    EXPECT_NEAR(image[middle] - 1, 0.81 * (scene.patches->ratio[middle] - 1), 1e-12);
    // A finer grid sees the same area.
    VectorXd fine(96 * 96);
    rasterise(*scene.patches, sensor.sheet->pixels(96), fine);
    EXPECT_NEAR((fine.array() - 1).mean(), (image.array() - 1).mean(), 1e-13);
    ASSERT_EQ(scene.contacts.size(), 1u);
    EXPECT_EQ(scene.contacts[0].force_N, 20);
    EXPECT_NEAR(scene.contacts[0].half_size.x(), 0.3, 1e-12);
  }
}

TEST(ContactLaw, PassesThroughItsKnownPoints) {
  EXPECT_EQ(conductivity_ratio(FallingLaw{}, 0), 1);
  EXPECT_NEAR(conductivity_ratio(FallingLaw{}, 20), 1 - 0.45, 1e-15);
  EXPECT_NEAR(conductivity_ratio(RisingLaw{}, 0), 1, 1e-15);
  // 10 N on the disc of radius 10 mm.
  EXPECT_NEAR(conductivity_ratio(RisingLaw{}, 10 / (std::numbers::pi * 100) * 1000), 10, 1e-9);
  // x / tanh x is x for large x, and x^2 is proportional to the pressure.
  EXPECT_NEAR(conductivity_ratio(RisingLaw{}, 400) / conductivity_ratio(RisingLaw{}, 100), 2, 1e-9);
}

TEST(FoamMemory, FollowsAStepAndARampAsAStandardLinearSolid) {
  const Foam foam;  // 80 % at once, the rest with 0.3 s
  const VectorXd none = VectorXd::Zero(1);
  const VectorXd ten = VectorXd::Constant(1, 10);
  FoamMemory step(foam, none);
  step.advance(0, ten);
  EXPECT_NEAR(step.pressure_kPa()[0], 8, 1e-12);
  step.advance(0.3, ten);
  EXPECT_NEAR(step.pressure_kPa()[0], 8 + 2 * (1 - std::exp(-1)), 1e-12);
  step.advance(0, none);  // on release the ghost is what was remembered
  EXPECT_NEAR(step.pressure_kPa()[0], 2 * (1 - std::exp(-1)), 1e-12);

  // Under a ramp of rate g the memory lags: m = g (t - tau (1 - exp(-t / tau))). However the time
  // is divided.
  for (const int parts : {1, 7}) {
    FoamMemory ramp(foam, none);
    for (int i = 1; i <= parts; ++i) {
      ramp.advance(0.6 / parts, VectorXd::Constant(1, 10.0 * i / parts));
    }
    const double memory = 10 / 0.6 * (0.6 - 0.3 * (1 - std::exp(-2)));
    EXPECT_NEAR(ramp.pressure_kPa()[0], 8 + 0.2 * memory, 1e-12);
  }
}

TEST(TouchPath, MovesStraightFromPointToPoint) {
  const TouchPath path{kDisc, {{1, {0, 0}, 2}, {3, {10, -20}, 4}}};
  EXPECT_EQ(path.at(0.5).force_N, 0);
  EXPECT_EQ(path.at(1).force_N, 2);
  EXPECT_EQ(path.at(2).force_N, 3);
  EXPECT_EQ(path.at(2).place_mm, Vector2d(5, -10));
  EXPECT_EQ(path.at(3).force_N, 4);
  EXPECT_EQ(path.at(3.5).force_N, 0);
}

TEST(Indenter, WhatCannotBeReadSaysWhere) {
  const auto refused = [](const char* text, const char* message) {
    try {
      indenter(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  refused(R"({"type": "cone"})", "/type");
  refused(R"({"type": "sphere", "radius_mm": 0})", "/radius_mm");
  refused(R"({"type": "flat", "vertices_mm": [[0, 0], [1, 0], [2, 0]]})", "enclose an area");
  for (const Indenter& one : {kBall, kDisc, kFinger, kTriangle}) {
    const auto json = to_json(one);
    EXPECT_EQ(indenter_from_json(JsonObject(json, "", "")), one);
  }
}

}  // namespace
}  // namespace ertbench
